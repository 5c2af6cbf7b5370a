//! Rules for the source code, checked in its text.

mod binaries;
mod c_header;
mod circles;
mod comments;
mod features;
mod imports;
mod layering;
mod map;
mod names;
mod regressions;
mod source;
