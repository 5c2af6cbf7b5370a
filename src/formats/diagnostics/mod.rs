//! Errors and warnings about a file, each with its place in it.
//!
//! | file | holds |
//! |---|---|
//! | `diagnostic_sink` | what a reader reports about its file, with line and column |
//! | `chunk_remarks` | what threads report about chunks, of which each kind is given once |

mod chunk_remarks;
mod diagnostic_sink;

pub(crate) use chunk_remarks::{ChunkRemarks, ParseError, WarningTally, counted};
pub use diagnostic_sink::{Diagnostic, MAX_DIAGNOSTICS};
pub(crate) use diagnostic_sink::{DiagnosticSink, Span, quoted_bytes, quoted_file};
pub(crate) use phalanx_files::quoted;
