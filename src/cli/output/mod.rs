//! Results, progress, messages and output files.

mod destination;
mod diagnose;
mod empty_picture;
mod error;
mod file_coordinates;
pub mod interrupt;
mod ledger;
mod live_preview;
mod memory_stats;
mod output_file;
mod preview;
mod process_status;
pub mod progress;
mod render_summary;
mod stats;
mod stderr;
mod stdout;
mod table;
mod verbosity;

pub use destination::{
    absolute_path, check_kind, check_picture_place, check_place, check_png_place,
    check_report_place, is_replaced, refuse_stdout,
};
pub use diagnose::{print_notes, print_warnings};
pub use empty_picture::{EMPTY, EvenColor};
pub use error::CliError;
pub use file_coordinates::{origin_row, to_file_coordinates};
pub use ledger::{free_path, reads, taken, writes};
pub use live_preview::LivePreview;
pub use memory_stats::MemoryStats;
pub use output_file::{OutputFile, format_of};
pub use progress::{ProgressMode, ProgressOptions};
pub use render_summary::{PictureWindow, RenderSummary};
pub use stats::{
    PrimitiveCounts, TreeFigures, mrays_per_s, rays_by_kind, serialize_rates, serialize_rays,
};
pub use stderr::{advise, error, message, note, printable, status, warning};
pub use stdout::{Output, is_dash, print, print_json, print_output, print_raw, stdout_columns};
pub use table::{aligned, bytes, grouped, lines};
pub use verbosity::{Verbosity, set_verbosity};
