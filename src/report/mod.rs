//! Records of benchmark runs: their layout, statistics, comparison, and a page to look at them.

mod record;
mod statistics;

pub use record::*;
pub use statistics::{geometric_mean, median};
