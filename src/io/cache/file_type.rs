//! Characteristics of a cache file: the ending of its name, its first bytes, its version.

/// Ending of the names of cache files.
pub const ENDING: &str = "phx";

/// File magic. It is not text, and is changed by anything that mangles text, an idea from PNG.
pub(super) const MAGIC: [u8; 8] = *b"\x93PHX\r\n\x1a\n";
/// Version of the format. It is incremented whenever a section changes its meaning; a change of
/// names or sizes already changes the layout.
pub(super) const VERSION: u32 = 10;
