//! Changes from an earlier run, the baseline, to another: their size, and their uncertainty.
//!
//! Rates are taken in units of the oracle's rate in the same scene and run (the geometric mean over
//! all kinds of rays, which one rate's noise moves little). So a machine that is slower today makes
//! no regression. (A faster oracle does: it is the yardstick, and a change to it needs a new
//! baseline.)
//!
//! The criteria for a regression are explained at [`Changes::regressions`].

use super::compatibility::{
    IncompatibleRecords, Mismatch, nothing_in_common, of_machine, of_part, of_rays, refuse,
};
use super::log_rate::{LogRate, RateChange, mean_change};
use crate::record_index::SharedRow;
use crate::{BenchRecord, ORACLE, PHALANX, RateRow, RecordIndex};
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
    /// The change in units of its yardstick's, which is taken to be exact.
    log: LogRate,
    /// The change of the yardstick by itself.
    yardstick: LogRate,
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
    let [before, now] = [old, new].map(|record| RecordIndex::of(&record.scenes, &record.rows));
    let both = before.shared(&now, PHALANX);
    let mut reasons = of_machine(old, new);
    reasons.extend(of_rays(old, new));
    reasons.extend(both.iter().filter_map(|(old, new)| of_part(old, new)));
    if both.is_empty() {
        let records = [("the baseline", old), ("this run", new)];
        reasons.push(Mismatch::NothingInCommon(nothing_in_common(&records)));
    }
    let mut changes = Changes {
        only_old: keys(before.lacking(&now, PHALANX)),
        only_new: keys(now.lacking(&before, PHALANX)),
        forced: refuse(reasons, force)?,
        ..Changes::default()
    };
    let repeated = |(old, new): &SharedRow| {
        before.repeats(old) && now.repeats(new) && old.same_as == new.same_as
    };
    let oracle = before.shared(&now, ORACLE);
    for pair in both.into_iter().filter(|pair| !repeated(pair)) {
        match row_change(pair, &oracle) {
            None => changes.empty.push(RowKey::of(pair.1)),
            Some(change) => changes.rows.push(change),
        }
    }
    changes.groups = groups(&changes.rows);
    Ok(changes)
}

fn keys(rows: Vec<&RateRow>) -> Vec<RowKey> {
    rows.into_iter().map(RowKey::of).collect()
}

fn row_change((old, new): SharedRow, oracle: &[SharedRow]) -> Option<RowChange> {
    let change = LogRate::change_between(old, new)?;
    let of = |threads| yardstick(&new.scene, threads, oracle);
    let same = of(new.threads).map(|log| (log, Normalisation::SameThreads));
    let one = || of(1).map(|log| (log, Normalisation::OneThread));
    let (yardstick, normalised) = same
        .or_else(one)
        .unwrap_or((LogRate::ONE, Normalisation::No));
    Some(RowChange {
        key: RowKey::of(new),
        old: old.mrays_per_s.median,
        new: new.mrays_per_s.median,
        change: change.over(yardstick).change(),
        normalised,
        log: change.over(yardstick.exactly()),
        yardstick,
    })
}

/// Change of the oracle's rates of a scene, over all kinds of rays that both runs timed alike.
fn yardstick(scene: &str, threads: u32, oracle: &[SharedRow]) -> Option<LogRate> {
    let of_scene = oracle.iter().filter(|(old, new)| {
        // The rate of another part of the rays is another yardstick.
        let alike = old.rays_timed == new.rays_timed;
        alike && (&*new.scene, new.threads) == (scene, threads)
    });
    let changes = of_scene.filter_map(|(old, new)| LogRate::change_between(old, new));
    LogRate::mean(&changes.collect::<Vec<_>>())
}

/// The rows of each kernel by kind of rays and threads, and by scene.
fn groups(rows: &[RowChange]) -> Vec<GroupChange> {
    let mut members: BTreeMap<(Grouping, &str), Vec<&RowChange>> = BTreeMap::new();
    for row in rows {
        let key = &row.key;
        let (rays, scene, threads) = (key.rays.clone(), key.scene.clone(), key.threads);
        for over in [Grouping::Scenes { rays, threads }, Grouping::Rays { scene }] {
            members.entry((over, &key.kernel)).or_default().push(row);
        }
    }
    let group = |((over, kernel), members): ((Grouping, &str), Vec<&RowChange>)| {
        let changes: Vec<LogRate> = members.iter().map(|row| row.log).collect();
        let yardsticks: Vec<LogRate> = members.iter().map(|row| row.yardstick).collect();
        let normalised = |row: &&RowChange| row.normalised != Normalisation::No;
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
