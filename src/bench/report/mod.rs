//! Records of benchmark runs: their layout, statistics, comparison, and a page to look at them.

mod baseline;
mod files;
pub mod html;
mod machine;
mod record;
mod side_by_side;
mod statistics;
mod table;
mod text;

pub use baseline::{
    Change, Changes, CounterChange, Difference, GroupChange, Mismatch, Normalised, Over, RETAKES,
    Refusal, Regression, RowChange, RowKey, changes_table, compare, counters, counters_table,
    regressions_table,
};
pub use files::{RecordError, load, to_csv, to_json};
pub use record::*;
pub use side_by_side::side_by_side;
pub use statistics::{geometric_mean, median};
pub use table::readme_table;
