//! Records of benchmark runs: their layout, statistics, comparison, and a page to look at them.

pub mod html;
mod record;

pub use record::*;
