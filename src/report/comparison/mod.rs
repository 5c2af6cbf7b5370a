//! Several records side by side: who is fastest, geometric means, and what has changed beyond
//! noise.
//!
//! Records may be of different machines, whose rates are compared as measured. Where the machine is
//! the same, its own change ([`RunNoise`]) is taken out. A [`RecordComparison`] is the one verdict:
//! text, JSON, Markdown and pages show it, and `bench --fail-above` decides by it.

mod compatibility;
mod counters;
mod groups;
mod log_rate;
mod noise;
mod rates;
mod regressions;
#[cfg(test)]
mod simulation;
mod summary;
mod tables;

pub use compatibility::{
    IncompatibleRecords, Mismatch, check_baseline, check_run, nothing_in_common,
};
pub use counters::{CountDifference, CounterChange, counters, counters_table};
pub use groups::GroupChange;
pub use log_rate::RateChange;
pub use rates::ComparedRate;
pub use regressions::{RETAKES, Regressions};
pub use summary::{EngineRank, MeanRates, MeanRatios};
pub(super) use tables::changes;
pub use tables::{comparison_markdown, comparison_tables, comparison_text, regressions_text};

use super::{BenchRecord, PHALANX, RecordIndex};
use compatibility::ray_mismatches;
use noise::{RunNoise, is_same_machine};
use serde::Serialize;

/// Settings of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonOptions {
    /// Smallest change that counts, as a share such as 0.03.
    pub threshold: f64,
    /// True if every rate of every kernel is listed, not just the best of each engine that differ.
    pub all: bool,
    /// True if records of other machines count as measured on the first one's.
    pub any_machine: bool,
}

/// Records side by side. All rates are millions of rays per second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordComparison {
    /// Smallest change that counts, as a share. A rate differs if the whole interval of the
    /// difference is beyond it.
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
    /// Our kernels that are faster or slower as a whole, in one scene, or on one kind of rays.
    pub groups: Vec<GroupChange>,
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
    /// Our rates that look slower in all further records, as far as two runs show: suspects.
    #[serde(skip)]
    slow_rates: Vec<ComparedRate>,
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
    pub fn new(records: &[(&str, &BenchRecord)], options: ComparisonOptions) -> RecordComparison {
        let ComparisonOptions { threshold, all, .. } = options;
        let records_only = records.iter().map(|(_, record)| record);
        let indices = records_only.map(|record| RecordIndex::new(&record.scenes, &record.rows));
        let indices: Vec<RecordIndex> = indices.collect();
        let ranking = summary::ranking(&indices);
        let noise = (1..records.len()).map(|i| {
            let same = options.any_machine || is_same_machine(records[0].1, records[i].1);
            same.then(|| RunNoise::between(&indices[0], &indices[i]))?
        });
        let noise: Vec<Option<RunNoise>> = noise.collect();
        let engines = rates::best_of_engines(&indices, &noise, threshold);
        let kernels = rates::every_kernel(&indices, &noise, threshold);
        let slower = |rate: &&ComparedRate| rate.engine == PHALANX && rate.looks_slower;
        let slow_rates = kernels.iter().filter(slower).cloned().collect();
        let most_rows = indices.iter().map(|index| index.rows.len()).max();
        let left_out = most_rows.unwrap_or(0).saturating_sub(kernels.len());
        let compared = if all { &kernels } else { &engines };
        RecordComparison {
            threshold,
            records: compared_records(records, &noise),
            groups: groups::changed_groups(&noise, threshold),
            ranked_rates: ranking.rates,
            ranked_scenes: ranking.scenes,
            ranks: ranking.ranks,
            means: summary::means(&indices),
            ratios: summary::ratios(&indices),
            compared: compared.len(),
            differing: compared.iter().filter(|rate| rate.differs).count(),
            rates: if all { kernels } else { rates::largest_first(engines) },
            all,
            left_out,
            slow_rates,
        }
    }
}

fn compared_records(
    records: &[(&str, &BenchRecord)],
    noise: &[Option<RunNoise>],
) -> Vec<ComparedRecord> {
    let compared = |(i, (name, record)): (usize, &(&str, &BenchRecord))| ComparedRecord {
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
    records.iter().enumerate().map(compared).collect()
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
    let mismatches = ray_mismatches(first, record);
    if let Some(one) = mismatches.first() {
        let more = match mismatches.len() {
            1 => String::new(),
            count => format!(", and {} more", count - 1),
        };
        remarks.push(format!("not the same rays: {one}{more}"));
    }
    remarks
}
