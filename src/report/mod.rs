//! Records of benchmark runs: their layout, statistics, comparison, and a page to look at them.

mod baseline;
pub mod html;
mod record;
mod statistics;
mod text;

pub use baseline::{
    Change, Changes, CounterChange, Difference, GroupChange, Mismatch, Normalised, Over, Refusal,
    Regression, RowChange, RowKey, changes_table, compare, counters, counters_table,
    regressions_table,
};
pub use record::*;
pub use statistics::{geometric_mean, median};
