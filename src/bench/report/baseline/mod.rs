//! A run against an earlier one, its baseline: what changed, by how much, and how sure that is.
//!
//! Rates are taken in units of the oracle's of the same scene in the same run (their geometric mean over all kinds of
//! rays, which one rate's noise moves little), so that a machine that is slower today makes no regression. (A faster
//! oracle does: it is the yardstick, and a change to it needs a new baseline.)
//!
//! What decides is explained at [`Changes::regressions`].

mod change;
mod counters;
mod judge;
#[cfg(test)]
mod noise;
mod same;
mod text;

pub use change::Change;
pub use counters::{CounterChange, Difference, counters};
pub use judge::{RETAKES, Regression};
pub(super) use same::of_rays;
pub use same::{Mismatch, Refusal};
pub use text::{changes_table, counters_table, regressions_table};

use super::{Record, Row};
use change::{Log, mean_change};
use std::collections::BTreeMap;

/// Names a rate of ours in a record.
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
    fn of(row: &Row) -> RowKey {
        RowKey {
            scene: row.scene.clone(),
            rays: row.rays.clone(),
            kernel: row.kernel.clone(),
            threads: row.threads,
        }
    }
}

/// In units of which rates of the oracle's a row is taken, in both runs alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normalised {
    /// Of the same scene on as many threads.
    SameThreads,
    /// Of the same scene on one thread.
    OneThread,
    /// None that both runs have: the machine's own ups and downs are in the change.
    No,
}

/// How one rate changed.
#[derive(Clone, Debug, PartialEq)]
pub struct RowChange {
    /// Which.
    pub key: RowKey,
    /// The baseline's median, millions of rays a second, as measured.
    pub old: f64,
    /// This run's.
    pub new: f64,
    /// The change, in units of the oracle's rate.
    pub change: Change,
    /// Which of its rates.
    pub normalised: Normalised,
}

/// Over what a kernel's rates are taken together.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Over {
    /// One kind of rays on so many threads, over all scenes.
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

impl Over {
    /// Whether the rows of a group are in units of the same rates of the oracle's.
    fn shares_yardsticks(&self) -> bool {
        matches!(self, Over::Rays { .. })
    }
}

/// How the rates of one kernel changed together: their geometric mean.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupChange {
    /// Kernel.
    pub kernel: String,
    /// Which of its rates.
    pub over: Over,
    /// How many.
    pub rows: usize,
    /// The change.
    pub change: Change,
    /// Whether all of them are in units of the oracle's rates.
    pub normalised: bool,
}

/// What changed from a baseline to a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Every rate of ours that both have, in the run's order. A kernel that is the same as another on both builds is
    /// left out beside it.
    pub rows: Vec<RowChange>,
    /// By kernel and kind of rays, and by kernel and scene.
    pub groups: Vec<GroupChange>,
    /// Rates that only the baseline has.
    pub only_old: Vec<RowKey>,
    /// Rates that only the run has.
    pub only_new: Vec<RowKey>,
    /// Rates that both have, without a positive sample in one of them.
    pub empty: Vec<RowKey>,
    /// What should have kept the two from being compared.
    pub forced: Vec<Mismatch>,
}

/// Compares a run with its baseline. `force` overrides another machine or instruction set, never other rays.
///
/// # Errors
/// Every reason why the rates are not of the same thing.
pub fn compare(old: &Record, new: &Record, force: bool) -> Result<Changes, Refusal> {
    let (before, now) = (Index::of(old), Index::of(new));
    let mut reasons = same::of_machine(old, new);
    reasons.extend(same::of_rays(old, new));
    let mut both = Vec::new();
    let mut changes = Changes::default();
    for (key, &row) in &now.ours {
        match before.ours.get(key) {
            None => changes.only_new.push(key.clone()),
            Some(&old) => {
                reasons.extend(same::of_part(old, row));
                both.push((key, old, row));
            }
        }
    }
    let gone = before
        .ours
        .keys()
        .filter(|key| !now.ours.contains_key(*key));
    changes.only_old = gone.cloned().collect();
    if both.is_empty() {
        reasons.push(Mismatch::NothingInCommon);
    }
    changes.forced = reasons;
    let refused = changes.forced.iter().any(|r| !force || !r.can_be_forced());
    if refused {
        let reasons = changes.forced;
        return Err(Refusal { reasons });
    }
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

/// A record's rows by what they are of.
struct Index<'a> {
    ours: BTreeMap<RowKey, &'a Row>,
    oracle: BTreeMap<(&'a str, &'a str, u32), &'a Row>,
}

impl<'a> Index<'a> {
    fn of(record: &'a Record) -> Index<'a> {
        let of_engine =
            |engine: &'static str| record.rows.iter().filter(move |r| r.engine == engine);
        Index {
            ours: of_engine("phalanx").map(|r| (RowKey::of(r), r)).collect(),
            oracle: of_engine("oracle")
                .map(|r| ((r.scene.as_str(), r.rays.as_str(), r.threads), r))
                .collect(),
        }
    }

    /// Whether a row's samples are another's, which is there, too.
    fn repeats(&self, key: &RowKey) -> bool {
        let same_as = self.ours.get(key).and_then(|row| row.same_as.clone());
        same_as.is_some_and(|kernel| {
            let other = RowKey {
                kernel,
                ..key.clone()
            };
            other != *key && self.ours.contains_key(&other)
        })
    }
}

/// A row's change in units of its yardstick's, and the yardstick's change by itself.
#[derive(Clone, Copy)]
struct Logs {
    row: Log,
    yardstick: Log,
}

fn row_change(
    key: &RowKey,
    (before, old): (&Index, &Row),
    (now, new): (&Index, &Row),
) -> Option<(RowChange, Logs)> {
    let row = Log::of(new)?.over(Log::of(old)?);
    let of = |threads| yardstick(&key.scene, threads, before, now);
    let same = of(key.threads).map(|log| (log, Normalised::SameThreads));
    let one = || of(1).map(|log| (log, Normalised::OneThread));
    let (yardstick, normalised) = same.or_else(one).unwrap_or((Log::ONE, Normalised::No));
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

/// How the oracle's rates of a scene changed, all kinds of rays together that both runs timed alike.
fn yardstick(scene: &str, threads: u32, before: &Index, now: &Index) -> Option<Log> {
    let of_scene = now
        .oracle
        .iter()
        .filter(|((of, _, on), _)| (*of, *on) == (scene, threads));
    let ratios = of_scene.filter_map(|(key, new)| {
        let old = before.oracle.get(key)?;
        // The rate of another part of the rays is another yardstick.
        let alike = old.rays_timed == new.rays_timed;
        alike.then_some(Log::of(new)?.over(Log::of(old)?))
    });
    Log::mean(&ratios.collect::<Vec<_>>())
}

/// The rows of each kernel by kind of rays and threads, and by scene.
fn groups(rows: &[RowChange], logs: &[Logs]) -> Vec<GroupChange> {
    let mut members: BTreeMap<(Over, &str), Vec<usize>> = BTreeMap::new();
    for (i, RowChange { key, .. }) in rows.iter().enumerate() {
        let (rays, scene, threads) = (key.rays.clone(), key.scene.clone(), key.threads);
        for over in [Over::Scenes { rays, threads }, Over::Rays { scene }] {
            members.entry((over, &key.kernel)).or_default().push(i);
        }
    }
    let group = |((over, kernel), members): ((Over, &str), Vec<usize>)| {
        let changes: Vec<Log> = members.iter().map(|&i| logs[i].row).collect();
        let yardsticks: Vec<Log> = members.iter().map(|&i| logs[i].yardstick).collect();
        let normalised = |&i: &usize| rows[i].normalised != Normalised::No;
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
