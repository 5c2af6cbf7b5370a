//! A record arranged for reading: its scenes, kinds and thread counts, and the rows that belong
//! together.

use super::number_format;
use crate::ray_kind::{FRAME, RayKind};
use crate::report::{self, AUTO, BenchRecord, ORACLE, PHALANX, Program, RateRow, SceneRecord};
use maud::{Markup, html};
use std::collections::{BTreeMap, BTreeSet};

/// A record, arranged.
pub(super) struct RecordView<'a> {
    pub(super) record: &'a BenchRecord,
    /// Scenes in the record's order, then those that only rows name.
    pub(super) scenes: Vec<&'a str>,
    /// Kinds of rays that have a row or counters.
    pub(super) kinds: Vec<&'a str>,
    /// Thread counts that have a row, fewest first.
    pub(super) threads: Vec<u32>,
    /// Engines: ours, the oracle, then peers by name.
    pub(super) engines: Vec<&'a str>,
    /// Rows by scene, kind and threads.
    rows: BTreeMap<&'a str, BTreeMap<&'a str, BTreeMap<u32, Vec<&'a RateRow>>>>,
}

impl<'a> RecordView<'a> {
    pub(super) fn new(record: &'a BenchRecord) -> RecordView<'a> {
        let rows = &record.rows;
        let counters = &record.counters;
        let own = record.scenes.iter().map(|s| s.name.as_str());
        let scenes = own
            .chain(rows.iter().map(|r| r.scene.as_str()))
            .chain(counters.iter().map(|c| c.scene.as_str()));
        let kinds = rows.iter().map(|r| r.rays.as_str());
        let kinds: BTreeSet<&str> = kinds
            .chain(counters.iter().map(|c| c.rays.as_str()))
            .collect();
        let engines: BTreeSet<&str> = rows.iter().map(|r| r.engine.as_str()).collect();
        let threads: BTreeSet<u32> = rows.iter().map(|r| r.threads).collect();
        let mut together: BTreeMap<&str, BTreeMap<&str, BTreeMap<u32, Vec<&RateRow>>>> =
            BTreeMap::new();
        for row in rows {
            let of_scene = together.entry(&row.scene).or_default();
            let of_kind = of_scene.entry(&row.rays).or_default();
            of_kind.entry(row.threads).or_default().push(row);
        }
        RecordView {
            record,
            scenes: first_of_each(scenes),
            kinds: in_order(kinds, &RayKind::names().collect::<Vec<_>>()),
            threads: threads.into_iter().collect(),
            engines: in_order(engines, &[PHALANX, ORACLE]),
            rows: together,
        }
    }

    /// All rows of one scene, kind and thread count.
    pub(super) fn rows(&self, scene: &str, kind: &str, threads: u32) -> &[&'a RateRow] {
        let of_scene = self.rows.get(scene);
        let rows = of_scene.and_then(|kinds| kinds.get(kind)?.get(&threads));
        rows.map_or(&[], Vec::as_slice)
    }

    /// The fastest of the rows of one scene, kind and thread count that are wanted.
    fn fastest(
        &self,
        (scene, kind, threads): (&str, &str, u32),
        wanted: impl Fn(&RateRow) -> bool,
    ) -> Option<&'a RateRow> {
        let rows = self.rows(scene, kind, threads).iter().copied();
        rows.filter(|r| has_rate(r) && wanted(r))
            .max_by(|a, b| a.mrays_per_s.median.total_cmp(&b.mrays_per_s.median))
    }

    /// The row of the kernel that `render` would use, if it has a rate.
    pub(super) fn auto(&self, scene: &str, kind: &str, threads: u32) -> Option<&'a RateRow> {
        self.stands_for(PHALANX, scene, kind, threads)
    }

    /// The row that stands for an engine in charts: ours is `auto`, a peer's its best exact mode.
    pub(super) fn stands_for(
        &self,
        engine: &str,
        scene: &str,
        kind: &str,
        threads: u32,
    ) -> Option<&'a RateRow> {
        self.fastest((scene, kind, threads), |r| {
            let counts = match engine {
                PHALANX => r.kernel == AUTO,
                ORACLE => true,
                _ => r.exact,
            };
            r.engine == engine && counts
        })
    }

    /// The fastest exact mode of any peer.
    pub(super) fn best_peer(&self, scene: &str, kind: &str, threads: u32) -> Option<&'a RateRow> {
        self.fastest((scene, kind, threads), |r| r.exact && is_peer(&r.engine))
    }

    /// Returns true if any other project's tracer took part.
    pub(super) fn has_peers(&self) -> bool {
        self.engines.iter().any(|engine| is_peer(engine))
    }

    /// The most threads of any row.
    pub(super) fn most_threads(&self) -> Option<u32> {
        self.threads.last().copied()
    }

    /// Thread counts, most first, which is what a frame is rendered with.
    pub(super) fn threads_from_most(&self) -> impl Iterator<Item = u32> + '_ {
        self.threads.iter().rev().copied()
    }

    /// The record's data of a scene.
    pub(super) fn scene(&self, name: &str) -> Option<&'a SceneRecord> {
        self.record.scenes.iter().find(|s| s.name == name)
    }

    /// A scene's name as the axes have it: a standard scene's family and size.
    pub(super) fn short_name(&self, name: &str) -> String {
        let plain = name.strip_prefix("standard:").unwrap_or(name);
        number_format::shortened(&plain.replace(':', " "), 18)
    }
}

/// A scene's name for the first column of a table: without parts that are obvious, and shortened if
/// too long.
pub(super) fn row_name(name: &str) -> Markup {
    let plain = name.strip_prefix("standard:").unwrap_or(name);
    let short = number_format::shortened(plain, 24);
    html! { span title=[(short != name).then_some(name)] { (short) } }
}

/// Returns true if the engine is another project's tracer.
pub(super) fn is_peer(engine: &str) -> bool {
    engine != PHALANX && engine != ORACLE
}

/// Returns true if a row's rate can be used at all.
pub(super) fn has_rate(row: &RateRow) -> bool {
    let median = row.mrays_per_s.median;
    median.is_finite() && median > 0.0
}

/// A kind of rays in words; `frame` is everything that a picture takes.
pub(super) fn kind_text(kind: &str) -> String {
    match kind {
        FRAME => "whole frames".to_owned(),
        _ => format!("{kind} rays"),
    }
}

/// The day of a run.
pub(super) fn day(record: &BenchRecord) -> &str {
    record.run.started.split('T').next().unwrap_or_default()
}

/// The first letters of a program's commit, and whether files differed from it.
pub(super) fn commit_text(program: &Program) -> String {
    let Some(commit) = &program.git_revision else {
        return "not known".to_owned();
    };
    let short: String = commit.chars().take(8).collect();
    match program.git_dirty {
        Some(true) => format!("{short}, changed"),
        _ => short,
    }
}

/// `2 threads` or `1 thread`.
pub(super) fn threads_text(threads: u32) -> String {
    number_format::plural(threads as usize, "thread")
}

/// The geometric mean of the positive finite values, and their number.
pub(super) fn geometric_mean(values: impl IntoIterator<Item = f64>) -> Option<(f64, usize)> {
    let good = values.into_iter().filter(|v| v.is_finite() && *v > 0.0);
    let good: Vec<f64> = good.collect();
    let number = good.len();
    report::geometric_mean(good).map(|mean| (mean, number))
}

fn first_of_each<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen = BTreeSet::new();
    names.filter(|name| seen.insert(*name)).collect()
}

/// The names that are in the list, in its order, then the rest by name.
fn in_order<'a>(names: BTreeSet<&'a str>, order: &[&str]) -> Vec<&'a str> {
    let rank = |name: &&str| order.iter().position(|o| o == name).unwrap_or(order.len());
    let mut names: Vec<&str> = names.into_iter().collect();
    names.sort_by_key(rank);
    names
}
