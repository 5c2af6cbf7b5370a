//! `bench compare` and `bench report`: saved records, side by side.

use super::args::{RecordCompareArgs, RecordReportArgs};
use super::baseline::load;
use crate::cli::output::{self, CliError, Output, interrupt};
use phalanx::report::html::{comparison_page, page};
use phalanx::report::{
    BenchRecord, ComparisonOptions, RecordComparison, comparison_markdown, comparison_text,
    nothing_in_common,
};
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
    let compared = |all| compared(&records, args.threshold, all);
    let shown = compared(args.all).map_err(|error| match &args.filter {
        Some(_) => error.with_hint(FILTERED),
        None => error,
    })?;
    if let Some(path) = &args.html {
        save(path, &comparison_page(&pairs(&records), &compared(false)?))?;
    }
    if args.markdown {
        output::print(&comparison_markdown(&shown))
    } else {
        output::print_output(&shown, args.json)
    }
}

/// Writes the page of one record, or of several side by side.
pub fn report(args: &RecordReportArgs) -> Result<(), CliError> {
    output::check_report_place(&args.output, "--output")?;
    let records = load_all(&args.records)?;
    if let [(_, record)] = &records[..] {
        return save(&args.output, &page(record, &[]));
    }
    let compared = compared(&records, REPORT_THRESHOLD, false)?;
    save(&args.output, &comparison_page(&pairs(&records), &compared))
}

/// Advice for records without common rates that pass a filter.
const FILTERED: &str = "--filter matches names such as: standard:room:200k primary phalanx auto";

/// The comparison of records that have rates in common.
fn compared(
    records: &NamedRecords,
    threshold: f64,
    all: bool,
) -> Result<RecordComparison, CliError> {
    let options = ComparisonOptions {
        threshold,
        all,
        any_machine: false,
    };
    let compared = RecordComparison::new(&pairs(records), options);
    if compared.compared == 0 {
        Err(CliError::Usage(nothing_in_common(&pairs(records))))
    } else {
        Ok(compared)
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

impl Output for RecordComparison {
    fn table(&self) -> String {
        comparison_text(self, output::stdout_columns())
    }
}

/// Writes text to a file.
pub fn save(path: &Path, text: &str) -> Result<(), CliError> {
    interrupt::write_file(path, |file| file.write_all(text.as_bytes()))
}
