//! Conversion of records to text and back.

use super::{BenchRecord, SCHEMA_VERSION};
use phalanx_files::shown_path;
use serde_json::Value;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// The reason why a file is not a record.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", shown_path(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is not JSON.
    #[error("{}: not JSON: {}", position(path, error), message(error))]
    NotJson {
        /// The file.
        path: PathBuf,
        /// The mistake, and where it is.
        error: serde_json::Error,
    },
    /// The file is a record of another version, or JSON of another kind.
    #[error(
        "{}: {}, and this program reads version {SCHEMA_VERSION}",
        shown_path(path),
        version.map_or("no benchmark record (no schema_version)".to_owned(), |v| format!("a record of version {v}"))
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Version of the record, if it has any.
        version: Option<u64>,
    },
    /// The file claims this version, but a field is missing or of another kind.
    #[error(
        "{}: no record of version {SCHEMA_VERSION}: {}",
        position(path, error),
        message(error)
    )]
    Layout {
        /// The file.
        path: PathBuf,
        /// The mistake, and where it is.
        error: serde_json::Error,
    },
}

/// File, line and column, counted from 1.
fn position(path: &Path, error: &serde_json::Error) -> String {
    format!("{}:{}:{}", shown_path(path), error.line(), error.column())
}

/// The mistake without its position, which serde_json ends a message with.
fn message(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let end = format!(" at line {} column {}", error.line(), error.column());
    text.strip_suffix(&end).unwrap_or(&text).to_owned()
}

/// Longest record that is read: a hundred times the suite's. A device never ends.
const MAX_BYTES: u64 = 64 << 20;

/// Reads a record.
///
/// # Errors
/// The mistake in the file, and its position.
pub fn load(path: &Path) -> Result<BenchRecord, RecordError> {
    let path = path.to_owned();
    let mut bytes = Vec::new();
    let file = File::open(&path);
    let read = file.and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
    if let Err(source) = read.and_then(|read| {
        if read as u64 > MAX_BYTES {
            Err(io::Error::other("it is longer than any record"))
        } else {
            Ok(())
        }
    }) {
        return Err(RecordError::Io { path, source });
    }
    match serde_json::from_slice::<BenchRecord>(&bytes) {
        Ok(record) if record.schema_version == SCHEMA_VERSION => Ok(record),
        Ok(record) => Err(RecordError::Version {
            path,
            version: Some(record.schema_version.into()),
        }),
        Err(error) => Err(mistake(path, &bytes, error)),
    }
}

/// The mistake in a file that is no record. Mistakes in a record of another version do not matter.
fn mistake(path: PathBuf, bytes: &[u8], error: serde_json::Error) -> RecordError {
    let document: Value = match serde_json::from_slice(bytes) {
        Ok(document) => document,
        Err(error) => return RecordError::NotJson { path, error },
    };
    let version = document.get("schema_version").and_then(Value::as_u64);
    if version == Some(u64::from(SCHEMA_VERSION)) {
        RecordError::Layout { path, error }
    } else {
        RecordError::Version { path, version }
    }
}

/// A record as JSON, indented, with a line break at its end. Numbers that JSON cannot express
/// become `null`.
pub fn to_json(record: &BenchRecord) -> String {
    let text = serde_json::to_string_pretty(record);
    text.expect("a record's keys are text, and writing to memory does not fail") + "\n"
}

const CSV_HEAD: &str = "scene,rays,engine,kernel,threads,sample,mrays_per_s,median,low,high,\
                        rays_timed,hits,difference,exact,same_as,cpu,hardware_threads,isa,version,\
                        commit,dirty,started";

/// A record as CSV (RFC 4180, but lines end in LF), one sample a line. Columns of the row, of the
/// machine and of the program are repeated in each line, so that files of several runs can be put
/// together. Unknown values are empty.
pub fn to_csv(record: &BenchRecord) -> String {
    let origin = csv_origin(record);
    let mut text = String::from(CSV_HEAD) + "\n";
    for row in &record.rows {
        let names = [&row.scene, &row.rays, &row.engine, &row.kernel];
        let (names, threads) = (names.map(|text| quoted(text)).join(","), row.threads);
        let rate = &row.mrays_per_s;
        let (median, low, high) = (rate.median, rate.low, rate.high);
        let (timed, hits, exact) = (row.rays_timed, row.hits, row.exact);
        let difference = row.difference.map_or(String::new(), |d| d.to_string());
        let same_as = quoted(row.same_as.as_deref().unwrap_or_default());
        let rest = format!("{median},{low},{high},{timed},{hits},{difference},{exact},{same_as}");
        for (i, sample) in row.samples.iter().enumerate() {
            text += &format!("{names},{threads},{},{sample},{rest},{origin}\n", i + 1);
        }
    }
    text
}

/// The columns of machine and program.
fn csv_origin(record: &BenchRecord) -> String {
    let (machine, program) = (&record.machine, &record.program);
    let cells = [
        quoted(&machine.cpu),
        machine.threads.to_string(),
        quoted(&program.isa_compiled),
        quoted(&program.version),
        quoted(program.git_revision.as_deref().unwrap_or_default()),
        program.git_dirty.map_or(String::new(), |d| d.to_string()),
        quoted(&record.run.started),
    ];
    cells.join(",")
}

fn quoted(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
