//! Results, progress, messages and output files.
//!
//! | module | holds |
//! |---|---|
//! | `sinks` | where results, messages, progress and files go |
//! | `summary` | statements about a scene, its picture, its rays and its memory |
//! | `error` | errors of commands, and their exit codes |

mod error;
mod sinks;
mod summary;

pub use error::CliError;
pub use sinks::*;
pub use summary::*;
