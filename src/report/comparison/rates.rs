//! The rates that all records have, with their differences from the first record.

use super::log_rate::RateChange;
use super::noise::{RunNoise, looks_slower, rate_change};
use crate::record_index::{KernelKey, RateKey, kernel_key};
use crate::{Estimate, PHALANX, RateRow, RecordIndex};
use serde::Serialize;
use std::collections::BTreeMap;

/// A rate that all records have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedRate {
    /// Name of the scene.
    pub scene: String,
    /// Kind of rays.
    pub rays: String,
    /// Engine.
    pub engine: String,
    /// Threads.
    pub threads: u32,
    /// Kernel or mode in each record. The best exact mode of a peer need not be the same in all.
    pub kernels: Vec<String>,
    /// The rate in each record.
    pub rates: Vec<Estimate>,
    /// Difference of each further record from the first, with its 99.95 % interval; beyond the
    /// machine's own change, where the machine is the same. The interval is unknown where there are
    /// too few samples.
    pub changes: Vec<RateChange>,
    /// True if the whole interval of any of them is beyond the threshold.
    pub differs: bool,
    /// True if all of them look slower by more than the threshold, as far as two runs show.
    #[serde(skip)]
    pub looks_slower: bool,
}

impl ComparedRate {
    /// Size of the largest difference, as a logarithm.
    pub fn size(&self) -> f64 {
        let changes = self.changes.iter();
        let sizes = changes.map(|change| libm::log(1.0 + change.by).abs());
        sizes.fold(0.0, f64::max)
    }

    /// Name of the tracer in lists of changes: our kernel, or another engine.
    pub(super) fn tracer(&self) -> &str {
        if self.engine == PHALANX {
            self.kernels.first().map_or("", String::as_str)
        } else {
            &self.engine
        }
    }

    /// Key of the rate in the first record.
    pub(super) fn key(&self) -> KernelKey<'_> {
        let kernel = self.kernels.first().map_or("", String::as_str);
        let (scene, rays, engine) = (&self.scene, &self.rays, &self.engine);
        (scene, rays, engine, kernel, self.threads)
    }
}

/// The best row of every engine that all records have: ours is `auto`, a peer's its fastest exact
/// mode.
pub(super) fn best_of_engines(
    records: &[RecordIndex],
    noise: &[Option<RunNoise>],
    threshold: f64,
) -> Vec<ComparedRate> {
    let best: Vec<BTreeMap<RateKey, &RateRow>> =
        records.iter().map(RecordIndex::by_engine).collect();
    let rate = |key: &RateKey| {
        let rows = best.iter().map(|rows| rows.get(key).copied());
        compared(&rows.collect::<Option<Vec<_>>>()?, noise, threshold)
    };
    let first = best.iter().take(1).flat_map(BTreeMap::keys);
    first.filter_map(rate).collect()
}

/// Every row that all records have, in the order of the first.
pub(super) fn every_kernel(
    records: &[RecordIndex],
    noise: &[Option<RunNoise>],
    threshold: f64,
) -> Vec<ComparedRate> {
    let rate = |row: &RateRow| {
        let rows = records.iter().map(|record| {
            let row = record.by_key.get(&kernel_key(row)).copied();
            row.filter(|row| row.has_rate())
        });
        compared(&rows.collect::<Option<Vec<_>>>()?, noise, threshold)
    };
    let first = records.iter().take(1).flat_map(|first| first.rows);
    first.filter_map(rate).collect()
}

/// The rows of one rate, one of each record; `noise` is that of each further record.
fn compared(rows: &[&RateRow], noise: &[Option<RunNoise>], threshold: f64) -> Option<ComparedRate> {
    let (first, others) = rows.split_first()?;
    let others = || others.iter().zip(noise);
    let changes = others().map(|(row, noise)| rate_change(first, row, noise.as_ref()));
    let changes: Vec<RateChange> = changes.collect::<Option<_>>()?;
    let slower = |(row, noise): (&&RateRow, &Option<RunNoise>)| {
        looks_slower(first, row, noise.as_ref(), threshold)
    };
    let differs = changes.iter().any(|change| change.exceeds(threshold));
    Some(ComparedRate {
        scene: first.scene.clone(),
        rays: first.rays.clone(),
        engine: first.engine.clone(),
        threads: first.threads,
        kernels: rows.iter().map(|row| row.kernel.clone()).collect(),
        rates: rows.iter().map(|row| row.mrays_per_s).collect(),
        changes,
        differs,
        looks_slower: others().all(slower),
    })
}

/// The rates that differ, largest difference first.
pub(super) fn largest_first(rates: Vec<ComparedRate>) -> Vec<ComparedRate> {
    let mut differing: Vec<ComparedRate> = rates.into_iter().filter(|rate| rate.differs).collect();
    differing.sort_by(|a, b| b.size().total_cmp(&a.size()));
    differing
}
