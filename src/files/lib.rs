//! Files that appear whole or not at all.
//!
//! A result goes through [`replace_file`], which finds out what its path names ([`Destination`]):
//! a regular file is written beside its place and renamed over it, a pipe or a device is written
//! into. [`shown_path()`] is how messages name files, and [`shell_path()`] how commands do.

#[cfg_attr(
    unix,
    allow(unsafe_code, reason = "an open file is known by its number alone")
)]
mod descriptor;
mod destination;
mod folder;
mod replace;
mod shell_word;
mod shown_path;
mod temporary;

pub use destination::Destination;
pub use folder::folder_of;
pub use replace::{WriteSeek, check_writable, in_memory, replace_file, replace_file_seeking};
pub use shell_word::{operand, shell_path, shell_word};
pub use shown_path::{
    QUOTED_CHARS, escaped, quoted, quoted_text, quoted_up_to, shown_path, shown_text, steers,
};
