//! Several records side by side: who is fastest, geometric means, and the rates that differ beyond
//! noise.
//!
//! Records may be of different machines, whose rates are compared as measured. Where the machine is
//! the same, its own change ([`RunNoise`]) is taken out.

mod change_tables;
mod changes;
mod compatibility;
mod counters;
mod log_rate;
#[cfg(test)]
mod noise;
mod rates;
mod regressions;
mod run_noise;
mod summary;
mod tables;

pub(super) use change_tables::{BY_RAYS_HEAD, worst_first};
pub use change_tables::{changes_table, counters_table, regressions_table};
pub use changes::{Changes, GroupChange, Grouping, Normalisation, RowChange, RowKey, compare};
pub use compatibility::{IncompatibleRecords, Mismatch, check_baseline, nothing_in_common};
pub use counters::{CountDifference, CounterChange, counters};
pub use log_rate::RateChange;
pub use rates::ComparedRate;
pub use regressions::{RETAKES, Regression};
pub use run_noise::KernelChange;
pub use summary::{EngineRank, MeanRates, MeanRatios};
pub(super) use tables::differing;
pub use tables::{comparison_markdown, comparison_tables, comparison_text};

use super::{BenchRecord, RecordIndex};
use compatibility::of_rays;
use run_noise::{RunNoise, changed_kernels};
use serde::Serialize;

/// Settings of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonOptions {
    /// Rates differ where the whole interval of the difference is beyond this share, such as 0.03.
    pub threshold: f64,
    /// True if every rate of every kernel is listed, not just the best of each engine that differ.
    pub all: bool,
}

/// Records side by side. All rates are millions of rays per second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordComparison {
    /// Rates differ where the whole interval of the difference is beyond this share.
    pub threshold: f64,
    /// The records; everything else has an entry for each, in this order.
    pub records: Vec<ComparedRecord>,
    /// Number of rates of each entry of `ranks`: those that all of them have.
    pub ranked_rates: usize,
    /// Number of scenes of these rates.
    pub ranked_scenes: usize,
    /// Engines of all records, fastest first.
    pub ranks: Vec<EngineRank>,
    /// Geometric means of our rates over the scenes that all records have.
    pub means: Vec<MeanRates>,
    /// Our rates as a multiple of the others'.
    pub ratios: Vec<MeanRatios>,
    /// Our kernels that are faster or slower as a whole.
    pub kernels: Vec<KernelChange>,
    /// The rates that differ, largest difference first; with [`ComparisonOptions::all`] every rate.
    pub rates: Vec<ComparedRate>,
    /// True if `rates` has every rate.
    pub all: bool,
    /// Number of rates that all records have.
    pub compared: usize,
    /// Number of these that differ.
    pub differing: usize,
    /// Largest number of rates of a record that the others lack.
    pub left_out: usize,
}

/// A record of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedRecord {
    /// Letter that stands for the record in tables: A, B, C.
    pub label: String,
    /// Name of the record, such as its file's.
    pub name: String,
    /// CPU model.
    pub cpu: String,
    /// Hardware threads.
    pub threads: u32,
    /// Instruction-set level of the build.
    pub isa: String,
    /// Version of the program.
    pub version: String,
    /// Commit of the program.
    pub commit: Option<String>,
    /// Start of the run.
    pub started: String,
    /// Quality of our trees.
    pub quality: String,
    /// Peers that took part.
    pub peers: Vec<String>,
    /// Change of the machine's speed since the first record, if it is the same machine. Changes of
    /// rates are beyond it.
    pub machine: Option<RateChange>,
    /// Differences in what was measured, from the first record.
    pub remarks: Vec<String>,
}

impl RecordComparison {
    /// Compares records, which come with a name each. Differences are from the first.
    pub fn of(records: &[(&str, &BenchRecord)], options: ComparisonOptions) -> RecordComparison {
        let records_only = records.iter().map(|(_, record)| record);
        let best = records_only.map(|record| RecordIndex::of(&record.scenes, &record.rows));
        let best: Vec<RecordIndex> = best.collect();
        let ranking = summary::ranking(&best);
        let of = |i: usize| (records[i].1, &best[i]);
        let further = 1..records.len();
        let noise = further.map(|i| RunNoise::of(of(0), of(i)));
        let noise: Vec<Option<RunNoise>> = noise.collect();
        let engines = rates::best_of_engines(&best, &noise, options.threshold);
        let kernels = rates::every_kernel(&best, &noise, options.threshold);
        let compared = if options.all { &kernels } else { &engines };
        let differing = compared.iter().filter(|rate| rate.differs).count();
        let compared = compared.len();
        let rows = best.iter().map(|of| of.rows.len());
        let left_out = rows.max().unwrap_or(0).saturating_sub(kernels.len());
        RecordComparison {
            threshold: options.threshold,
            records: compared_records(records, &noise),
            kernels: changed_kernels(&noise, options.threshold),
            ranked_rates: ranking.rates,
            ranked_scenes: ranking.scenes,
            ranks: ranking.ranks,
            means: summary::means(&best),
            ratios: summary::ratios(&best),
            left_out,
            rates: if options.all { kernels } else { rates::largest_first(engines) },
            all: options.all,
            compared,
            differing,
        }
    }
}

fn compared_records(
    records: &[(&str, &BenchRecord)],
    noise: &[Option<RunNoise>],
) -> Vec<ComparedRecord> {
    let of = |(i, (name, record)): (usize, &(&str, &BenchRecord))| ComparedRecord {
        label: label(i),
        name: (*name).to_owned(),
        cpu: record.machine.cpu.clone(),
        threads: record.machine.threads,
        isa: record.program.isa_compiled.clone(),
        version: record.program.version.clone(),
        commit: record.program.git_revision.clone(),
        started: record.run.started.clone(),
        quality: record.run.quality.clone(),
        peers: record.run.peers.clone(),
        machine: i
            .checked_sub(1)
            .and_then(|i| Some(noise[i].as_ref()?.machine())),
        remarks: remarks(records[0].1, record),
    };
    records.iter().enumerate().map(of).collect()
}

/// A, B, … Z, then numbers.
fn label(i: usize) -> String {
    match u8::try_from(i) {
        Ok(i @ 0..26) => char::from(b'A' + i).to_string(),
        _ => format!("R{}", i + 1),
    }
}

/// Differences that make a record's rates incomparable with the first one's, or less so.
fn remarks(first: &BenchRecord, record: &BenchRecord) -> Vec<String> {
    let mut remarks = Vec::new();
    if first.run.quality != record.run.quality {
        let (ours, theirs) = (&record.run.quality, &first.run.quality);
        remarks.push(format!("trees of quality {ours}, {theirs} in A"));
    }
    let differ = of_rays(first, record);
    if let Some(one) = differ.first() {
        let more = match differ.len() {
            1 => String::new(),
            count => format!(", and {} more", count - 1),
        };
        remarks.push(format!("not the same rays: {one}{more}"));
    }
    remarks
}
