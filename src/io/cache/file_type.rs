//! Marks that tell a cache from other files: its name's ending, its first bytes, its version.

/// Ending of the names of cache files.
pub const ENDING: &str = "phx";

/// File magic. It is not text, and anything that mangles text mangles it: the idea is PNG's.
pub(super) const MAGIC: [u8; 8] = *b"\x93PHX\r\n\x1a\n";
/// Version of the format. It rises whenever a section changes its meaning; a change of names or
/// sizes shows in the layout by itself.
pub(super) const VERSION: u32 = 5;
