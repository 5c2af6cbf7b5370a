//! Records of benchmark runs: their layout, statistics, comparison, and a page to look at them.

mod record;

pub use record::*;
