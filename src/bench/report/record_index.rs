//! The row that stands for each engine in a record, and means and ratios of such rows.

use super::{BenchRecord, ORACLE, PHALANX, RateRow, geometric_mean};
use crate::ray_kind::{FRAME, RayKind};
use std::collections::{BTreeMap, BTreeSet};

/// The kernel that `render` would use, which stands for ours.
pub const AUTO: &str = "auto";

/// Rows by entrant: `auto`, our kernels by name, the oracle, and each peer by its fastest exact
/// mode.
pub struct BestRows<'a> {
    /// Kinds of rays, whole frames first.
    pub kinds: Vec<&'a str>,
    /// Thread counts of our rows, fewest first.
    pub threads: Vec<u32>,
    /// Scenes, in the order of the rows.
    pub scenes: Vec<&'a str>,
    /// Names of the other entrants: our kernels, the oracle, then peers.
    pub others: Vec<&'a str>,
    /// The engines of the rows.
    pub engines: BTreeSet<&'a str>,
    rows: BTreeMap<BestKey<'a>, &'a RateRow>,
}

/// Entrant, scene, kind of rays, threads.
type BestKey<'a> = (&'a str, &'a str, &'a str, u32);

/// The rates of an entrant on all scenes that it shares with `auto`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedMean {
    /// Geometric mean of `auto` divided by the entrant.
    pub ratio: f64,
    /// Number of scenes.
    pub scenes: usize,
}

impl<'a> BestRows<'a> {
    /// The rows that stand for the entrants among some rows. Rows without a rate are left out, and
    /// so are inexact modes.
    pub fn of(rows: &'a [RateRow]) -> BestRows<'a> {
        let mut best: BTreeMap<BestKey<'a>, &'a RateRow> = BTreeMap::new();
        let usable = |row: &&RateRow| row.exact && row.mrays_per_s.median > 0.0;
        for row in rows.iter().filter(usable) {
            let key = (entrant(row), &*row.scene, &*row.rays, row.threads);
            let kept = best.entry(key).or_insert(row);
            if row.mrays_per_s.median > kept.mrays_per_s.median {
                *kept = row;
            }
        }
        let names: BTreeSet<&str> = best.keys().map(|key| key.0).collect();
        let rank = |name: &&str| match *name {
            ORACLE => 1,
            name if rows.iter().any(|r| r.engine == PHALANX && r.kernel == name) => 0,
            _ => 2,
        };
        let mut others: Vec<&str> = names.into_iter().filter(|name| *name != AUTO).collect();
        others.sort_by_key(rank);
        let ours = || best.keys().filter(|key| key.0 == AUTO);
        let threads: BTreeSet<u32> = ours().map(|key| key.3).collect();
        let measured: BTreeSet<&str> = ours().map(|key| key.2).collect();
        let mut seen = BTreeSet::new();
        let scenes = rows.iter().map(|row| row.scene.as_str());
        BestRows {
            kinds: kinds_frame_first()
                .filter(|kind| measured.contains(kind))
                .collect(),
            threads: threads.into_iter().collect(),
            scenes: scenes.filter(|scene| seen.insert(*scene)).collect(),
            others,
            engines: rows.iter().map(|row| row.engine.as_str()).collect(),
            rows: best,
        }
    }

    /// The row of an entrant.
    pub fn get(&self, name: &str, scene: &str, rays: &str, threads: u32) -> Option<&'a RateRow> {
        self.rows.get(&(name, scene, rays, threads)).copied()
    }

    /// Geometric mean of an entrant's rates over its scenes.
    pub fn mean(&self, name: &str, rays: &str, threads: u32) -> Option<f64> {
        let rates = self.scenes.iter();
        geometric_mean(rates.filter_map(|scene| self.rate(name, scene, rays, threads)))
    }

    /// Our rates as a multiple of another entrant's, over the scenes that both have.
    pub fn over(&self, name: &str, rays: &str, threads: u32) -> Option<SharedMean> {
        let ratio = |scene: &&str| {
            let ours = self.rate(AUTO, scene, rays, threads)?;
            Some(ours / self.rate(name, scene, rays, threads)?)
        };
        let ratios: Vec<f64> = self.scenes.iter().filter_map(ratio).collect();
        let scenes = ratios.len();
        geometric_mean(ratios).map(|ratio| SharedMean { ratio, scenes })
    }

    /// Geometric mean of our rates as a multiple of another entrant's, over all scenes and kinds of
    /// rays that both have.
    pub fn over_all(&self, name: &str, threads: u32) -> Option<f64> {
        let pairs = self
            .rows
            .iter()
            .filter(|(key, _)| key.0 == name && key.3 == threads);
        geometric_mean(pairs.filter_map(|(&(_, scene, rays, threads), other)| {
            let ours = self.rate(AUTO, scene, rays, threads)?;
            Some(ours / other.mrays_per_s.median)
        }))
    }

    fn rate(&self, name: &str, scene: &str, rays: &str, threads: u32) -> Option<f64> {
        let row = self.get(name, scene, rays, threads)?;
        Some(row.mrays_per_s.median)
    }
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
/// part. It is about primary rays where there are any, on the most threads. `None` where there are
/// no rates of ours.
pub fn quotable_line(record: &BenchRecord) -> Option<String> {
    let best = BestRows::of(&record.rows);
    let kind = RayKind::names().find(|kind| best.kinds.contains(kind))?;
    let threads = *best.threads.last()?;
    let rate = super::text::rate(best.mean(AUTO, kind, threads)?);
    let mut parts = vec![format!("phalanx {rate} Mrays/s {kind}")];
    let over = |name: &str, shown: &str| {
        let mean = best.over(name, kind, threads)?;
        Some(format!("{:.2} × {shown}", mean.ratio))
    };
    let of_peers = best.engines.iter().filter(|engine| is_peer(engine));
    parts.extend(of_peers.filter_map(|name| over(name, name)));
    if parts.len() == 1 {
        parts.extend(over(ORACLE, "its scalar oracle"));
    }
    let counted = super::text::counted;
    let (threads, scenes) = (
        counted(threads as usize, "thread"),
        counted(best.scenes.len(), "scene"),
    );
    Some(format!("{} ({threads}, {scenes})", parts.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Estimate;

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
        let best = BestRows::of(&rows);
        assert_eq!(best.others, ["packet8", "oracle", "embree"]);
        let over = |name| best.over(name, "primary", 1).map(|m| (m.ratio, m.scenes));
        assert_eq!(over("embree"), Some((2.0, 1)));
        assert_eq!(over("oracle"), Some((32.0, 1)));
        assert_eq!(over("obvhs"), None);
        let mean = best.mean(AUTO, "primary", 1).expect("a mean");
        assert!((mean - 16.0).abs() < 1e-9);
    }
}
