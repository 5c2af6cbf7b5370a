//! Comparison of a run with an earlier one, its baseline: the changes, their size, and their
//! uncertainty.
//!
//! Rates are taken in units of the oracle's rate in the same scene and run (the geometric mean over
//! all kinds of rays, which one rate's noise moves little). So a machine that is slower today makes
//! no regression. (A faster oracle does: it is the yardstick, and a change to it needs a new
//! baseline.)
//!
//! The criteria for a regression are explained at [`Changes::regressions`].

mod compatibility;
mod counters;
mod log_change;
#[cfg(test)]
mod noise;
mod regressions;
mod text;

pub(super) use compatibility::of_rays;
pub use compatibility::{IncompatibleRecords, Mismatch, check_baseline};
pub use counters::{CountDifference, CounterChange, counters};
pub use log_change::RateChange;
pub(super) use regressions::ROWS_TO_DECIDE;
pub use regressions::{RETAKES, Regression};
pub(super) use text::BY_RAYS_HEAD;
pub use text::{changes_table, counters_table, regressions_table};

use super::{BenchRecord, ORACLE, PHALANX, RateRow};
pub(super) use log_change::LogRate;
use log_change::mean_change;
use std::collections::BTreeMap;

/// Key of one of our rates in a record.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RowKey {
    /// Name of the scene.
    pub scene: String,
    /// Kind of rays.
    pub rays: String,
    /// Kernel.
    pub kernel: String,
    /// Threads.
    pub threads: u32,
}

impl RowKey {
    fn of(row: &RateRow) -> RowKey {
        RowKey {
            scene: row.scene.clone(),
            rays: row.rays.clone(),
            kernel: row.kernel.clone(),
            threads: row.threads,
        }
    }
}

/// The oracle rates in whose units a row is taken, in both runs alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normalisation {
    /// Rates of the same scene on the same number of threads.
    SameThreads,
    /// Rates of the same scene on one thread.
    OneThread,
    /// No rates, as both runs have none in common: the machine's own fluctuations are in the
    /// change.
    No,
}

/// The change of one rate.
#[derive(Clone, Debug, PartialEq)]
pub struct RowChange {
    /// The rate's key.
    pub key: RowKey,
    /// The baseline's median, millions of rays per second, as measured.
    pub old: f64,
    /// This run's median, millions of rays per second, as measured.
    pub new: f64,
    /// The change, in units of the oracle's rate.
    pub change: RateChange,
    /// The oracle rates that are the unit.
    pub normalised: Normalisation,
}

/// The dimension over which a kernel's rates are averaged.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grouping {
    /// One kind of rays on one number of threads, over all scenes.
    Scenes {
        /// Kind of rays.
        rays: String,
        /// Threads.
        threads: u32,
    },
    /// One scene, over all kinds of rays and numbers of threads.
    Rays {
        /// Name of the scene.
        scene: String,
    },
}

impl Grouping {
    /// Returns true if the rows of a group are in units of the same oracle rates.
    fn shares_yardsticks(&self) -> bool {
        matches!(self, Grouping::Rays { .. })
    }
}

/// The change of one kernel's rates together: their geometric mean.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupChange {
    /// Kernel.
    pub kernel: String,
    /// The rates that are averaged.
    pub over: Grouping,
    /// Number of rates.
    pub rows: usize,
    /// The change.
    pub change: RateChange,
    /// True if all of them are in units of the oracle's rates.
    pub normalised: bool,
}

/// The changes from a baseline to a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Every rate of ours that both have, in the run's order. A kernel whose samples are those of
    /// another kernel on both builds is omitted.
    pub rows: Vec<RowChange>,
    /// Groups by kernel and kind of rays, and by kernel and scene.
    pub groups: Vec<GroupChange>,
    /// Rates that only the baseline has.
    pub only_old: Vec<RowKey>,
    /// Rates that only the run has.
    pub only_new: Vec<RowKey>,
    /// Rates that both have, without a positive sample in one of them.
    pub empty: Vec<RowKey>,
    /// Mismatches that `force` has overridden.
    pub forced: Vec<Mismatch>,
}

/// Compares a run with its baseline. `force` overrides another machine or instruction set, never
/// other rays.
///
/// # Errors
/// Every reason why the rates do not measure the same thing.
pub fn compare(
    old: &BenchRecord,
    new: &BenchRecord,
    force: bool,
) -> Result<Changes, IncompatibleRecords> {
    let (before, now) = (Index::of(old), Index::of(new));
    let mut reasons = compatibility::of_machine(old, new);
    reasons.extend(compatibility::of_rays(old, new));
    let mut both = Vec::new();
    let mut changes = Changes::default();
    for (key, &row) in &now.kernels {
        match before.kernels.get(key) {
            None => changes.only_new.push(key.clone()),
            Some(&old) => {
                reasons.extend(compatibility::of_part(old, row));
                both.push((key, old, row));
            }
        }
    }
    let gone = before
        .kernels
        .keys()
        .filter(|key| !now.kernels.contains_key(*key));
    changes.only_old = gone.cloned().collect();
    if both.is_empty() {
        reasons.push(Mismatch::NothingInCommon);
    }
    changes.forced = compatibility::refuse(reasons, force)?;
    let mut logs = Vec::new();
    for (key, old, new) in both {
        if before.repeats(key) && now.repeats(key) && old.same_as == new.same_as {
            continue;
        }
        match row_change(key, (&before, old), (&now, new)) {
            None => changes.empty.push(key.clone()),
            Some((change, log)) => {
                changes.rows.push(change);
                logs.push(log);
            }
        }
    }
    changes.groups = groups(&changes.rows, &logs);
    Ok(changes)
}

/// A record's rows by their keys.
struct Index<'a> {
    kernels: BTreeMap<RowKey, &'a RateRow>,
    oracle: BTreeMap<(&'a str, &'a str, u32), &'a RateRow>,
}

impl<'a> Index<'a> {
    fn of(record: &'a BenchRecord) -> Index<'a> {
        let of_engine =
            |engine: &'static str| record.rows.iter().filter(move |r| r.engine == engine);
        Index {
            kernels: of_engine(PHALANX).map(|r| (RowKey::of(r), r)).collect(),
            oracle: of_engine(ORACLE)
                .map(|r| ((r.scene.as_str(), r.rays.as_str(), r.threads), r))
                .collect(),
        }
    }

    /// Returns true if a row's samples are those of another row, which the record also has.
    fn repeats(&self, key: &RowKey) -> bool {
        let same_as = self.kernels.get(key).and_then(|row| row.same_as.clone());
        same_as.is_some_and(|kernel| {
            let other = RowKey {
                kernel,
                ..key.clone()
            };
            other != *key && self.kernels.contains_key(&other)
        })
    }
}

/// A row's change in units of its yardstick's, and the yardstick's change by itself.
#[derive(Clone, Copy)]
struct Logs {
    row: LogRate,
    yardstick: LogRate,
}

fn row_change(
    key: &RowKey,
    (before, old): (&Index, &RateRow),
    (now, new): (&Index, &RateRow),
) -> Option<(RowChange, Logs)> {
    let row = LogRate::of(new)?.over(LogRate::of(old)?);
    let of = |threads| yardstick(&key.scene, threads, before, now);
    let same = of(key.threads).map(|log| (log, Normalisation::SameThreads));
    let one = || of(1).map(|log| (log, Normalisation::OneThread));
    let (yardstick, normalised) = same
        .or_else(one)
        .unwrap_or((LogRate::ONE, Normalisation::No));
    let change = RowChange {
        key: key.clone(),
        old: old.mrays_per_s.median,
        new: new.mrays_per_s.median,
        change: row.over(yardstick).change(),
        normalised,
    };
    let row = row.over(yardstick.exactly());
    Some((change, Logs { row, yardstick }))
}

/// Change of the oracle's rates of a scene, over all kinds of rays that both runs timed alike.
fn yardstick(scene: &str, threads: u32, before: &Index, now: &Index) -> Option<LogRate> {
    let of_scene = now
        .oracle
        .iter()
        .filter(|((of, _, on), _)| (*of, *on) == (scene, threads));
    let ratios = of_scene.filter_map(|(key, new)| {
        let old = before.oracle.get(key)?;
        // The rate of another part of the rays is another yardstick.
        let alike = old.rays_timed == new.rays_timed;
        alike.then_some(LogRate::of(new)?.over(LogRate::of(old)?))
    });
    LogRate::mean(&ratios.collect::<Vec<_>>())
}

/// The rows of each kernel by kind of rays and threads, and by scene.
fn groups(rows: &[RowChange], logs: &[Logs]) -> Vec<GroupChange> {
    let mut members: BTreeMap<(Grouping, &str), Vec<usize>> = BTreeMap::new();
    for (i, RowChange { key, .. }) in rows.iter().enumerate() {
        let (rays, scene, threads) = (key.rays.clone(), key.scene.clone(), key.threads);
        for over in [Grouping::Scenes { rays, threads }, Grouping::Rays { scene }] {
            members.entry((over, &key.kernel)).or_default().push(i);
        }
    }
    let group = |((over, kernel), members): ((Grouping, &str), Vec<usize>)| {
        let changes: Vec<LogRate> = members.iter().map(|&i| logs[i].row).collect();
        let yardsticks: Vec<LogRate> = members.iter().map(|&i| logs[i].yardstick).collect();
        let normalised = |&i: &usize| rows[i].normalised != Normalisation::No;
        GroupChange {
            kernel: kernel.to_owned(),
            change: mean_change(&changes, &yardsticks, over.shares_yardsticks()),
            over,
            rows: members.len(),
            normalised: members.iter().all(normalised),
        }
    };
    members.into_iter().map(group).collect()
}
