//! Destinations of results, messages, progress and files.
//!
//! | file | holds |
//! |---|---|
//! | `stdout` | results |
//! | `stderr`, `verbosity` | messages, and how many of them |
//! | `diagnose` | errors and warnings about scene files |
//! | `destination` | checks of the names of files to write |
//! | `ledger` | files that this process reads and writes |
//! | `output_file` | the file of a picture, and its format |
//! | `progress` | a bar, lines of JSON, or a preview |
//! | `live_preview`, `preview` | the unfinished picture, in a file or in the terminal |
//! | `interrupt` | signals, and files that are written despite them |

mod destination;
mod diagnose;
pub mod interrupt;
mod ledger;
mod live_preview;
mod output_file;
mod preview;
pub mod progress;
mod stderr;
mod stdout;
mod verbosity;

pub use destination::{
    absolute_path, check_kind, check_picture_place, check_place, check_png_place,
    check_report_place, is_replaced, refuse_stdout,
};
pub(super) use diagnose::print_error;
pub use diagnose::{print_notes, print_warnings};
pub use ledger::{free_path, reads, taken, writes};
pub use live_preview::LivePreview;
pub use output_file::{OutputFile, format_of};
pub use progress::{ProgressMode, ProgressOptions};
pub use stderr::{advise, error, message, note, printable, status, warning};
pub use stdout::{Output, is_dash, print, print_json, print_output, print_raw, stdout_columns};
pub use verbosity::{Verbosity, set_verbosity, verbosity};
