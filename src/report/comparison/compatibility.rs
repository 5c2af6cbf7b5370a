//! Compatibility of two records: the reasons why they may not be compared.

use crate::{BenchRecord, Cache, PHALANX, RateRow, RecordIndex, SceneRecord};
use std::collections::BTreeSet;
use std::fmt::{self, Display};

/// One reason why the rates of two records do not measure the same thing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{words}")]
pub struct Mismatch {
    words: String,
    /// True if the records may be compared nevertheless: they are of another machine, build or
    /// quality of trees. Rates of other rays measure something else, and may never be compared.
    pub can_be_forced: bool,
}

impl Mismatch {
    /// A reason that cannot be overridden.
    fn fatal(words: String) -> Mismatch {
        Mismatch {
            words,
            can_be_forced: false,
        }
    }
}

fn difference(what: &str, old: impl Display, new: impl Display) -> String {
    format!("{what}: {old} in the baseline, {new} here")
}

/// The reasons why two records are not compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IncompatibleRecords {
    /// Every reason, those that cannot be forced included; at least one.
    pub reasons: Vec<Mismatch>,
}

impl IncompatibleRecords {
    /// Returns true if every reason can be overridden.
    pub fn can_be_forced(&self) -> bool {
        self.reasons.iter().all(|reason| reason.can_be_forced)
    }
}

/// Most reasons that are listed: one changed generator makes many.
const MAX_REASONS: usize = 5;

impl Display for IncompatibleRecords {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the baseline cannot be compared with this run:")?;
        for reason in self.reasons.iter().take(MAX_REASONS) {
            write!(f, "\n  {reason}")?;
        }
        match self.reasons.len().saturating_sub(MAX_REASONS) {
            0 => Ok(()),
            more => write!(f, "\n  and {more} more of the like"),
        }
    }
}

impl std::error::Error for IncompatibleRecords {}

/// Differences in machine, build and trees. A fact that one record does not know differs from
/// nothing.
fn machine_mismatches(old: &BenchRecord, new: &BenchRecord) -> Vec<Mismatch> {
    type Fact = fn(&BenchRecord) -> Option<String>;
    let facts: [(&str, Fact); 6] = [
        ("another CPU", |r| Some(r.machine.cpu.clone())),
        ("another number of hardware threads", |r| {
            Some(r.machine.threads.to_string())
        }),
        ("other caches", |r| {
            Some(caches(r)).filter(|c| !c.is_empty())
        }),
        ("another hypervisor", |r| {
            r.machine.hypervisor_words().map(str::to_owned)
        }),
        ("compiled for another instruction set", |r| {
            Some(r.program.isa_compiled.clone())
        }),
        ("trees of another quality", |r| Some(r.run.quality.clone())),
    ];
    let differing = facts.into_iter().filter_map(|(what, fact)| {
        let (old, new) = (fact(old)?, fact(new)?);
        (old != new).then(|| Mismatch {
            words: difference(what, old, new),
            can_be_forced: true,
        })
    });
    differing.collect()
}

fn caches(record: &BenchRecord) -> String {
    let one = |c: &Cache| {
        let (level, kind, kib, threads) = (c.level, &c.kind, c.bytes >> 10, c.shared_by);
        format!("L{level} {kind} {kib} KiB for {threads}")
    };
    let all: Vec<String> = record.machine.caches.iter().map(one).collect();
    all.join(", ")
}

/// Refuses a baseline that a run will not be comparable with: `new` is its record before anything
/// was measured, `scenes` are the names of its scenes.
///
/// Returns the differences that `force` overrides.
///
/// # Errors
/// Every reason that can be known by then.
pub fn check_baseline(
    old: &BenchRecord,
    new: &BenchRecord,
    scenes: &[&str],
    force: bool,
) -> Result<Vec<Mismatch>, IncompatibleRecords> {
    let mut reasons = machine_mismatches(old, new);
    let in_common = |row: &RateRow| scenes.contains(&&*row.scene);
    if !old.rows.iter().any(in_common) {
        let scenes = scenes.join(", ");
        let words = format!("no scene in common with the baseline, here {scenes}");
        reasons.push(Mismatch::fatal(words));
    }
    refuse(reasons, force)
}

/// Refuses a baseline that a finished run is not comparable with: one with other answers, or other
/// rays, or without a rate in common.
///
/// # Errors
/// Every reason.
pub fn check_run(
    old: &BenchRecord,
    new: &BenchRecord,
    force: bool,
) -> Result<(), IncompatibleRecords> {
    let [before, now] = [old, new].map(|record| RecordIndex::new(&record.scenes, &record.rows));
    let pairs = before.shared(&now, PHALANX);
    let mut reasons = machine_mismatches(old, new);
    reasons.extend(ray_mismatches(old, new));
    reasons.extend(
        pairs
            .iter()
            .filter_map(|(old, new)| part_mismatch(old, new)),
    );
    if pairs.is_empty() {
        let records = [("the baseline", old), ("this run", new)];
        reasons.push(Mismatch::fatal(nothing_in_common(&records)));
    }
    refuse(reasons, force).map(drop)
}

/// The reason why no rate occurs in all of some records, which come with a name each: their
/// scenes, kinds of rays or tracers, whichever have none in common first.
pub fn nothing_in_common<'a>(records: &[(&str, &'a BenchRecord)]) -> String {
    type RowPart = fn(&RateRow) -> &str;
    let parts: [(&str, RowPart); 3] = [
        ("scene", |row| &row.scene),
        ("kind of rays", |row| &row.rays),
        ("tracer", |row| &row.engine),
    ];
    for (what, part) in parts {
        let set = |(_, record): &(&str, &'a BenchRecord)| record.rows.iter().map(part).collect();
        let sets: Vec<BTreeSet<&str>> = records.iter().map(set).collect();
        let is_shared = |word: &&str| sets.iter().all(|set| set.contains(word));
        if !sets.iter().flatten().any(is_shared) {
            let words = records.iter().zip(sets).map(|((name, _), set)| {
                let shown: Vec<&str> = set.into_iter().take(MAX_REASONS).collect();
                if shown.is_empty() {
                    format!("\n  {name}: no rates")
                } else {
                    format!("\n  {name}: {}", shown.join(", "))
                }
            });
            return format!("no {what} in common:{}", words.collect::<String>());
        }
    }
    "no rate in common: scenes, rays, tracers and threads occur in other combinations".to_owned()
}

/// The reasons, if each of them may be overridden and `force` does.
fn refuse(reasons: Vec<Mismatch>, force: bool) -> Result<Vec<Mismatch>, IncompatibleRecords> {
    if reasons.iter().all(|reason| force && reason.can_be_forced) {
        Ok(reasons)
    } else {
        Err(IncompatibleRecords { reasons })
    }
}

/// Differences in the scenes and rays that both records have.
pub fn ray_mismatches(old: &BenchRecord, new: &BenchRecord) -> Vec<Mismatch> {
    let before = |name: &str| old.scenes.iter().rfind(|scene| scene.name == name);
    let scenes = new.scenes.iter();
    let both = scenes.filter_map(|new| Some((before(&new.name)?, new)));
    both.flat_map(|(old, new)| scene_mismatches(old, new))
        .collect()
}

fn scene_mismatches(old: &SceneRecord, new: &SceneRecord) -> Vec<Mismatch> {
    let scene = &new.name;
    let answers = |what: &str, number: &str, old: &str, new: &str| {
        let words = format!("{what} ({number} {old} in the baseline, {new} here)");
        Mismatch::fatal(words)
    };
    if old.hash != new.hash {
        let what = format!("{scene}: another scene of this name");
        return vec![answers(&what, "hash", &old.hash, &new.hash)];
    }
    if old.size != new.size {
        let [old, new] = [old, new].map(|s| format!("{}×{}", s.size[0], s.size[1]));
        let what = format!("{scene}: rays of another size");
        return vec![Mismatch::fatal(difference(&what, old, new))];
    }
    let sets = new.rays.iter();
    let both = sets.filter_map(|(rays, new)| Some((rays, old.rays.get(rays)?, new)));
    let differing = both.filter(|(_, old, new)| old != new);
    let mismatch = differing.map(|(rays, old, new)| {
        if old.rays == new.rays {
            let what = format!("{scene}, {rays}: other answers");
            answers(&what, "checksum", &old.checksum, &new.checksum)
        } else {
            count_mismatch(scene, rays, old.rays, new.rays)
        }
    });
    mismatch.collect()
}

fn count_mismatch(scene: &str, rays: &str, old: u64, new: u64) -> Mismatch {
    let what = format!("{scene}, {rays}: another number of rays");
    Mismatch::fatal(difference(&what, old, new))
}

/// Returns the mismatch if a row of ours timed another part of its set of rays than the baseline's
/// did.
fn part_mismatch(old: &RateRow, new: &RateRow) -> Option<Mismatch> {
    let same = old.rays_timed == new.rays_timed;
    (!same).then(|| count_mismatch(&new.scene, &new.rays, old.rays_timed, new.rays_timed))
}
