//! `bench compare` and `bench report`: saved records, side by side.

use super::args::{RecordCompareArgs, RecordReportArgs};
use super::baseline::load;
use crate::cli::output::{self, CliError, Output, interrupt};
use phalanx::report::html::{comparison_page, page};
use phalanx::report::{
    BenchRecord, ComparisonOptions, RecordComparison, comparison_markdown, comparison_text,
};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Smallest change that counts as a difference in a report.
const REPORT_THRESHOLD: f64 = 0.03;

/// Prints a comparison, and writes its page.
pub fn compare(args: &RecordCompareArgs) -> Result<(), CliError> {
    if let Some(path) = &args.html {
        output::check_report_place(path, "--html")?;
    }
    let mut records = load_all(&args.records)?;
    if let Some(filter) = &args.filter {
        for (_, record) in &mut records {
            record.rows.retain(|row| filter.is_match(&row.name()));
        }
    }
    let compared = |all| {
        let options = ComparisonOptions {
            threshold: args.threshold,
            all,
        };
        RecordComparison::of(&pairs(&records), options)
    };
    let shown = compared(args.all);
    if shown.compared == 0 {
        return Err(nothing_in_common(args.filter.is_some()));
    }
    if let Some(path) = &args.html {
        save(path, &comparison_page(&pairs(&records), &compared(false)))?;
    }
    match args.markdown {
        true => output::print(&comparison_markdown(&shown)),
        false => output::print_output(&ComparisonDocument(shown), args.json),
    }
}

/// Writes the page of one record, or of several side by side.
pub fn report(args: &RecordReportArgs) -> Result<(), CliError> {
    output::check_report_place(&args.output, "--output")?;
    let records = load_all(&args.records)?;
    if let [(_, record)] = &records[..] {
        return save(&args.output, &page(record, &[]));
    }
    let options = ComparisonOptions {
        threshold: REPORT_THRESHOLD,
        all: false,
    };
    let compared = RecordComparison::of(&pairs(&records), options);
    save(&args.output, &comparison_page(&pairs(&records), &compared))
}

fn nothing_in_common(filtered: bool) -> CliError {
    let error = CliError::Usage("these records have no rates in common".to_owned());
    match filtered {
        true => error
            .with_hint("--filter matches names such as: standard:room:200k primary phalanx auto"),
        false => error,
    }
}

/// Records, with their names on the command line.
type NamedRecords = Vec<(String, BenchRecord)>;

fn load_all(paths: &[PathBuf]) -> Result<NamedRecords, CliError> {
    let named = |path: &PathBuf| Ok((path.display().to_string(), load(path)?));
    paths.iter().map(named).collect()
}

fn pairs(records: &[(String, BenchRecord)]) -> Vec<(&str, &BenchRecord)> {
    let pairs = records.iter().map(|(name, record)| (&**name, record));
    pairs.collect()
}

/// A comparison, as the output of a command.
#[derive(Serialize)]
struct ComparisonDocument(RecordComparison);

impl Output for ComparisonDocument {
    fn table(&self) -> String {
        comparison_text(&self.0, output::stdout_columns())
    }
}

/// Writes text to a file.
pub fn save(path: &Path, text: &str) -> Result<(), CliError> {
    interrupt::write_file(path, |file| file.write_all(text.as_bytes()))
}
