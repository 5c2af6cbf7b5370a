//! Records of benchmark runs: their layout, statistics, comparison, and presentation as a page.
//! What is measured, and how, is another crate's business: nothing here knows a tracer. The suite
//! is read here, too.

mod comparison;
mod files;
#[cfg(test)]
#[path = "../../tests/common/full_or.rs"]
mod full_or;
pub mod html;
mod numbers;
mod ray_kind;
mod record;
mod record_index;
mod report_table;
mod statistics;
mod suite;
mod text;

pub use comparison::{
    ComparedRate, ComparedRecord, ComparisonOptions, CountDifference, CounterChange, EngineRank,
    GroupChange, IncompatibleRecords, MeanRates, MeanRatios, Mismatch, RETAKES, RateChange,
    RecordComparison, Regressions, check_baseline, check_run, comparison_markdown,
    comparison_tables, comparison_text, counters, counters_table, nothing_in_common,
    regressions_text,
};
pub use files::{RecordError, load, to_csv, to_json};
pub use numbers::{NONE, bytes, counted, grouped, plural, rate};
pub use ray_kind::{FRAME, QueryKind, RayKind};
pub use record::*;
pub use record_index::{AUTO, RecordIndex, SpeedRatio, is_peer, kinds_frame_first, quotable_line};
pub use report_table::{ReportTable, aligned};
pub use statistics::{geometric_mean, median};
pub use suite::{Suite, SuiteError, SuiteScene};
pub use text::{commit, day, markdown, wrapped};
