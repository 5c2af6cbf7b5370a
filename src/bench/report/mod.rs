//! Records of benchmark runs: their layout, statistics, comparison, and presentation as a page.

mod baseline;
mod compare_table;
mod files;
pub mod html;
mod machine;
mod readme_table;
mod record;
mod statistics;
mod text;

pub use baseline::{
    Changes, CountDifference, CounterChange, GroupChange, Grouping, IncompatibleRecords, Mismatch,
    Normalisation, RETAKES, RateChange, Regression, RowChange, RowKey, changes_table, compare,
    counters, counters_table, regressions_table,
};
pub use compare_table::compare_table;
pub use files::{RecordError, load, to_csv, to_json};
pub use readme_table::{readme_table, scene_table};
pub use record::*;
pub use statistics::{geometric_mean, median};
