//! The rows of a record by what they measure, the row that stands for each engine, and means and
//! ratios of such rows.

use super::numbers::{counted, rate};
use super::{BenchRecord, ORACLE, PHALANX, RateRow, SceneRecord, geometric_mean};
use crate::ray_kind::{FRAME, RayKind};
use std::collections::{BTreeMap, BTreeSet};

/// The kernel that `render` would use, which stands for ours.
pub const AUTO: &str = "auto";

/// Scene, kind of rays, engine and threads of a rate.
pub(super) type RateKey<'a> = (&'a str, &'a str, &'a str, u32);

/// Scene, kind of rays, engine, kernel and threads of a row.
pub(super) type KernelKey<'a> = (&'a str, &'a str, &'a str, &'a str, u32);

/// The row of an earlier record, and that of a later one.
pub(super) type SharedRow<'a> = (&'a RateRow, &'a RateRow);

/// The key of a row.
pub(super) fn kernel_key(row: &RateRow) -> KernelKey<'_> {
    (&row.scene, &row.rays, &row.engine, &row.kernel, row.threads)
}

/// Rows by entrant: `auto`, our kernels by name, the oracle, and each peer by its fastest exact
/// mode. Rows without a rate are omitted.
pub struct RecordIndex<'a> {
    /// Kinds of rays that `auto` has, whole frames first.
    pub kinds: Vec<&'a str>,
    /// Thread counts of `auto`, fewest first.
    pub threads: Vec<u32>,
    /// Scenes, in the order of the rows.
    pub scenes: Vec<&'a str>,
    /// Scenes that means are over: those of triangles alone, or all if there are none. A few
    /// spheres are traced seven times as fast as by a tracer of meshes, which would decide a mean
    /// over eight scenes.
    pub averaged: Vec<&'a str>,
    /// Names of the other entrants: our kernels, the oracle, then peers.
    pub others: Vec<&'a str>,
    /// The engines of all rows: ours, the oracle, then peers.
    pub engines: Vec<&'a str>,
    /// All rows, those without a rate included.
    pub(super) rows: &'a [RateRow],
    /// These rows by their keys.
    pub(super) by_key: BTreeMap<KernelKey<'a>, &'a RateRow>,
    best: BTreeMap<BestKey<'a>, &'a RateRow>,
}

/// Entrant, scene, kind of rays, threads.
type BestKey<'a> = (&'a str, &'a str, &'a str, u32);

/// Our rates as a multiple of an entrant's, over the scenes that both have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedRatio {
    /// Geometric mean.
    pub mean: f64,
    /// The ratio of the scene where it is least.
    pub least: f64,
    /// The ratio of the scene where it is greatest.
    pub most: f64,
    /// Number of scenes.
    pub scenes: usize,
}

impl<'a> RecordIndex<'a> {
    /// The index of the rows of some scenes.
    pub fn new(records: &'a [SceneRecord], rows: &'a [RateRow]) -> RecordIndex<'a> {
        let mut best: BTreeMap<BestKey<'a>, &'a RateRow> = BTreeMap::new();
        let stands = |row: &&RateRow| row.has_rate() && (row.exact || !is_peer(&row.engine));
        for row in rows.iter().filter(stands) {
            let key = (entrant(row), &*row.scene, &*row.rays, row.threads);
            let fastest = best.entry(key).or_insert(row);
            if row.mrays_per_s.median > fastest.mrays_per_s.median {
                *fastest = row;
            }
        }
        let others = best.iter().filter(|(key, _)| key.0 != AUTO);
        let ours = || best.keys().filter(|key| key.0 == AUTO);
        let threads: BTreeSet<u32> = ours().map(|key| key.3).collect();
        let measured: BTreeSet<&str> = ours().map(|key| key.2).collect();
        let scenes = first_of_each(rows.iter().map(|row| row.scene.as_str()));
        let meshes = records.iter().filter(|scene| scene.is_of_triangles());
        let meshes: Vec<&str> = meshes.map(|scene| &*scene.name).collect();
        let engines = rows.iter().map(|row| (&*row.engine, &*row.engine));
        let ours_first = &[PHALANX, ORACLE];
        RecordIndex {
            kinds: kinds_frame_first()
                .filter(|kind| measured.contains(kind))
                .collect(),
            threads: threads.into_iter().collect(),
            averaged: some_or_all(&scenes, |scene| meshes.contains(scene)),
            scenes,
            others: in_order(others.map(|(key, row)| (key.0, &*row.engine)), ours_first),
            engines: in_order(engines, ours_first),
            rows,
            by_key: rows.iter().map(|row| (kernel_key(row), row)).collect(),
            best,
        }
    }

    /// The scenes that means are over, in words.
    pub fn averaged_words(&self) -> String {
        let scenes = counted(self.averaged.len(), "scene");
        if self.averaged.len() < self.scenes.len() {
            format!("{scenes} of triangles")
        } else {
            scenes
        }
    }

    /// The peers that took part.
    pub fn peers(&self) -> impl Iterator<Item = &'a str> {
        let engines = self.engines.iter().copied();
        engines.filter(|engine| is_peer(engine))
    }

    /// The rows of an engine that both records have, this one's first.
    pub(super) fn shared(&self, now: &RecordIndex<'a>, engine: &str) -> Vec<SharedRow<'a>> {
        let rows = now.by_key.iter().filter(|(key, _)| key.2 == engine);
        let both = rows.filter_map(|(key, row)| Some((*self.by_key.get(key)?, *row)));
        both.collect()
    }

    /// Returns true if any other project's tracer took part.
    pub fn has_peers(&self) -> bool {
        self.peers().next().is_some()
    }

    /// The row of an entrant.
    pub fn get(&self, name: &str, scene: &str, rays: &str, threads: u32) -> Option<&'a RateRow> {
        self.best.get(&(name, scene, rays, threads)).copied()
    }

    /// The rate of an entrant, millions of rays per second.
    pub fn rate(&self, name: &str, scene: &str, rays: &str, threads: u32) -> Option<f64> {
        let row = self.get(name, scene, rays, threads)?;
        Some(row.mrays_per_s.median)
    }

    /// The largest share of rays in a row of a peer that it answers otherwise than we do.
    fn most_different(&self, name: &str) -> f64 {
        let rows = self.best.iter().filter(|(key, _)| key.0 == name);
        let shares = rows.filter_map(|(_, row)| row.difference);
        shares.fold(0.0, f64::max)
    }

    /// The row that stands for each engine: ours is `auto`.
    pub(super) fn by_engine(&self) -> BTreeMap<RateKey<'a>, &'a RateRow> {
        let rows = self.best.iter();
        let rows = rows.filter(|(key, row)| key.0 == AUTO || row.engine != PHALANX);
        rows.map(|(&(_, scene, rays, threads), row)| ((scene, rays, &*row.engine, threads), *row))
            .collect()
    }

    /// Geometric mean of an entrant's rates over the scenes of [`RecordIndex::averaged`].
    pub fn mean(&self, name: &str, rays: &str, threads: u32) -> Option<f64> {
        let rates = self.averaged.iter();
        geometric_mean(rates.filter_map(|scene| self.rate(name, scene, rays, threads)))
    }

    /// Our rates as a multiple of another entrant's, over the scenes of
    /// [`RecordIndex::averaged`] that both have.
    pub fn over(&self, name: &str, rays: &str, threads: u32) -> Option<SpeedRatio> {
        let other = |scene: &str| self.rate(name, scene, rays, threads);
        self.over_rates(rays, threads, other)
    }

    /// Our rates as a multiple of the fastest peer's in each scene.
    pub fn over_best_peer(&self, rays: &str, threads: u32) -> Option<SpeedRatio> {
        let other = |scene: &str| {
            let rates = self
                .peers()
                .filter_map(|peer| self.rate(peer, scene, rays, threads));
            rates.max_by(f64::total_cmp)
        };
        self.over_rates(rays, threads, other)
    }

    fn over_rates(
        &self,
        rays: &str,
        threads: u32,
        other: impl Fn(&str) -> Option<f64>,
    ) -> Option<SpeedRatio> {
        let ratio = |scene: &&str| Some(self.rate(AUTO, scene, rays, threads)? / other(scene)?);
        let ratios: Vec<f64> = self.averaged.iter().filter_map(ratio).collect();
        Some(SpeedRatio {
            mean: geometric_mean(ratios.iter().copied())?,
            least: ratios.iter().copied().fold(f64::INFINITY, f64::min),
            most: ratios.iter().copied().fold(0.0, f64::max),
            scenes: ratios.len(),
        })
    }

    /// Geometric mean of our rates as a multiple of another entrant's, over all kinds of rays, and
    /// the scenes of [`RecordIndex::averaged`], that both have.
    pub fn over_all(&self, name: &str, threads: u32) -> Option<f64> {
        let pairs = self.best.iter();
        let pairs = pairs.filter(|(key, _)| key.0 == name && key.3 == threads);
        let pairs = pairs.filter(|(key, _)| self.averaged.contains(&key.1));
        geometric_mean(pairs.filter_map(|(&(_, scene, rays, threads), other)| {
            let ours = self.rate(AUTO, scene, rays, threads)?;
            Some(ours / other.mrays_per_s.median)
        }))
    }
}

/// The names for which `wanted` holds, or all if there are none.
pub(super) fn some_or_all<'a>(all: &[&'a str], wanted: impl Fn(&&str) -> bool) -> Vec<&'a str> {
    let some: Vec<&str> = all.iter().copied().filter(wanted).collect();
    if some.is_empty() { all.to_vec() } else { some }
}

/// Each name once, where it occurs first.
pub(super) fn first_of_each<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen = BTreeSet::new();
    names.filter(|name| seen.insert(*name)).collect()
}

/// Each name once, which comes with the word that it is ranked by: in the order of these words,
/// then the rest, by name.
pub(super) fn in_order<'a>(
    named: impl Iterator<Item = (&'a str, &'a str)>,
    order: &[&str],
) -> Vec<&'a str> {
    let rank = |word| order.iter().position(|other| *other == word);
    let ranked = named.map(|(name, word)| (rank(word).unwrap_or(usize::MAX), name));
    let ranked: BTreeSet<(usize, &str)> = ranked.collect();
    ranked.into_iter().map(|(_, name)| name).collect()
}

/// Name of a row's entrant.
fn entrant(row: &RateRow) -> &str {
    match row.engine.as_str() {
        PHALANX => &row.kernel,
        engine => engine,
    }
}

/// Kinds of rays in the order of tables for people: whole frames, then rays as they are reported.
pub fn kinds_frame_first() -> impl Iterator<Item = &'static str> {
    std::iter::once(FRAME).chain(RayKind::ALL.map(RayKind::name))
}

/// Returns true if an engine is another project's tracer.
pub fn is_peer(engine: &str) -> bool {
    engine != PHALANX && engine != ORACLE
}

/// One line to quote: our rate and its ratios to the peers', or to the oracle's where no peer took
/// part. It is about primary rays where there are any, on the most threads. `None` if there are no
/// rates of ours.
pub fn quotable_line(record: &BenchRecord) -> Option<String> {
    let best = RecordIndex::new(&record.scenes, &record.rows);
    let kind = RayKind::names().find(|kind| best.kinds.contains(kind))?;
    let threads = *best.threads.last()?;
    let rate = rate(best.mean(AUTO, kind, threads)?);
    let mut parts = vec![format!("phalanx {rate} Mrays/s {kind}")];
    let over = |name: &str, shown: &str| {
        let ratio = best.over(name, kind, threads)?;
        Some(format!("{:.2} × {shown}", ratio.mean))
    };
    parts.extend(best.peers().filter_map(|name| {
        let part = over(name, name)?;
        Some(match best.most_different(name) {
            0.0 => part,
            share => format!("{part} (up to {:.1} of a million rays differ)", 1e6 * share),
        })
    }));
    if parts.len() == 1 {
        parts.extend(over(ORACLE, "its scalar oracle"));
    }
    let (threads, scenes) = (counted(threads as usize, "thread"), best.averaged_words());
    Some(format!("{} ({threads}, {scenes})", parts.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Estimate;

    fn row(scene: &str, (engine, kernel): (&str, &str), rate: f64, exact: bool) -> RateRow {
        RateRow {
            scene: scene.to_owned(),
            rays: "primary".to_owned(),
            engine: engine.to_owned(),
            kernel: kernel.to_owned(),
            threads: 1,
            exact,
            mrays_per_s: Estimate {
                median: rate,
                ..Estimate::default()
            },
            ..RateRow::default()
        }
    }

    #[test]
    fn a_peer_is_its_best_exact_mode_on_scenes_that_both_have() {
        let rows = [
            row("a", ("phalanx", "auto"), 8.0, true),
            row("a", ("phalanx", "packet8"), 4.0, true),
            row("a", ("embree", "single"), 2.0, true),
            row("a", ("embree", "packet8"), 4.0, true),
            row("a", ("embree", "packet16"), 16.0, false),
            row("b", ("phalanx", "auto"), 32.0, true),
            row("b", ("oracle", "scalar"), 1.0, true),
        ];
        let best = RecordIndex::new(&[], &rows);
        assert_eq!(best.others, ["packet8", "oracle", "embree"]);
        let over = |name| best.over(name, "primary", 1).map(|m| (m.mean, m.scenes));
        assert_eq!(over("embree"), Some((2.0, 1)));
        assert_eq!(over("oracle"), Some((32.0, 1)));
        assert_eq!(over("obvhs"), None);
        let mean = best.mean(AUTO, "primary", 1).expect("a mean");
        assert!((mean - 16.0).abs() < 1e-9);
    }
}
