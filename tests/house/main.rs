//! The house and its rules, read from the text of the sources.

mod binaries;
mod circles;
mod comments;
mod features;
mod imports;
mod layering;
mod names;
mod source;
