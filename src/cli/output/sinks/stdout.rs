//! Results on stdout.

use super::stderr::printable;
use super::verbosity::{Verbosity, verbosity};
use crate::cli::output::error::CliError;
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use terminal_size::{Width, terminal_size_of};

/// Version of all JSON documents of the command line; incremented when a key changes its meaning or
/// is removed.
const SCHEMA_VERSION: u32 = 1;

/// Columns of a table if stdout is not a terminal.
const COLUMNS: usize = 80;

/// Columns of the terminal on stdout; 80 if there is none, so that a pipe gets the same text
/// everywhere.
pub fn stdout_columns() -> usize {
    terminal_size_of(io::stdout()).map_or(COLUMNS, |(Width(columns), _)| columns.max(20).into())
}

/// Returns true for `-`, which means stdin or stdout.
pub fn is_dash(path: &Path) -> bool {
    path == Path::new("-")
}

/// True if stdout carries a file's bytes, which other text would corrupt.
static STDOUT_TAKEN: AtomicBool = AtomicBool::new(false);

/// Reserves stdout for a file's bytes.
pub fn reserve_stdout() {
    STDOUT_TAKEN.store(true, Ordering::Relaxed);
}

/// Writes results for people to stdout, or to stderr if stdout is reserved for a file; nothing with
/// `--quiet`. A closed pipe (`phalanx info … | head -1`) is not an error.
pub fn print(text: &str) -> Result<(), CliError> {
    match verbosity() {
        Verbosity::Quiet => Ok(()),
        _ => print_raw(&printable(text)),
    }
}

/// Writes text that is not for people, or that may contain control sequences, to the same place as
/// results.
pub fn print_raw(text: &str) -> Result<(), CliError> {
    if STDOUT_TAKEN.load(Ordering::Relaxed) {
        let _ = io::stderr().lock().write_all(text.as_bytes());
        return Ok(());
    }
    let mut stdout = io::stdout().lock();
    let written = stdout.write_all(text.as_bytes());
    match written.and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CliError::Runtime(format!(
            "cannot write to stdout: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Result of a command, for programs and for people.
pub trait Output: Serialize {
    /// The text for people, with every figure.
    fn table(&self) -> String;
    /// The short text for people.
    fn short(&self) -> String {
        self.table()
    }
}

/// Writes a result: as JSON, or as the text that `--quiet` and `--verbose` select.
pub fn print_output(output: &impl Output, json: bool) -> Result<(), CliError> {
    match (json, verbosity()) {
        (true, _) => print_json(output),
        (false, Verbosity::Quiet) => Ok(()),
        (false, Verbosity::Normal) => print(&output.short()),
        (false, Verbosity::Verbose) => print(&output.table()),
    }
}

/// Writes one JSON document, with its version before its own keys.
pub fn print_json(document: &impl Serialize) -> Result<(), CliError> {
    #[derive(Serialize)]
    struct VersionedDocument<'a, T> {
        schema_version: u32,
        #[serde(flatten)]
        document: &'a T,
    }
    let text = serde_json::to_string_pretty(&VersionedDocument {
        schema_version: SCHEMA_VERSION,
        document,
    })
    .map_err(|e| CliError::Runtime(format!("cannot write JSON: {e}")))?;
    // JSON has already escaped the texts in it.
    print_raw(&(text + "\n"))
}
