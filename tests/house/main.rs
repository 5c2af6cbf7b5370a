//! The house and its rules, read from the text of the sources.

mod layering;
mod source;
