//! Pictures that were wrong once, each named for what is right, with the report that showed the
//! wrong one.

mod highlights;
mod texels;
