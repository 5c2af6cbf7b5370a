//! Records of benchmark runs: their layout, statistics, comparison, and presentation as a page.
//! What is measured, and how, is another crate's business: nothing here knows a tracer.

mod baseline;
mod comparison;
mod files;
pub mod html;
mod ray_kind;
mod readme_table;
mod record;
mod record_index;
mod statistics;
mod text;

pub use baseline::{
    Changes, CountDifference, CounterChange, GroupChange, Grouping, IncompatibleRecords, Mismatch,
    Normalisation, RETAKES, RateChange, Regression, RowChange, RowKey, changes_table,
    check_baseline, compare, counters, counters_table, regressions_table,
};
pub use comparison::{
    ComparedRate, ComparedRecord, ComparisonOptions, ComparisonTable, EngineRank, KernelChange,
    MeanRates, MeanRatios, RecordComparison, comparison_markdown, comparison_tables,
    comparison_text,
};
pub use files::{RecordError, load, to_csv, to_json};
pub use ray_kind::{FRAME, QueryKind, RayKind};
pub use readme_table::{readme_table, scene_table};
pub use record::*;
pub use record_index::{AUTO, RecordIndex, SpeedRatio, is_peer, kinds_frame_first, quotable_line};
pub use statistics::{geometric_mean, median};
pub use text::{ColumnLayout, fitted_table, rate, wrapped};
