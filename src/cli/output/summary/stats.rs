//! Counts of primitives, BVH nodes and rays, for JSON documents and tables.

use super::table::grouped;
use phalanx::frame::TreeStats;
use phalanx::render::RayCounts;
use phalanx::report::plural;
use phalanx::scene::{PrimKind, Scene};
use serde::{Serialize, Serializer};

/// Primitives by kind; ellipsoids count as spheres.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveCounts([usize; PrimKind::COUNT]);

impl PrimitiveCounts {
    /// Counts of a scene.
    pub fn of(scene: &Scene) -> PrimitiveCounts {
        let mut counts = scene.counts();
        counts[PrimKind::Sphere as usize] += counts[PrimKind::Ellipsoid as usize];
        PrimitiveCounts(counts)
    }

    /// Each kind that has a count of its own.
    fn kinds(&self) -> impl Iterator<Item = (PrimKind, usize)> {
        let kinds = PrimKind::ALL.into_iter().zip(self.0);
        kinds.filter(|(kind, _)| *kind != PrimKind::Ellipsoid)
    }

    /// The counts in words: "12,345 triangles, 3 spheres".
    pub fn words(&self) -> String {
        let counted = |(kind, n): (PrimKind, usize)| {
            (n > 0).then(|| format!("{} {}", grouped(n as u64), plural(n, kind.name())))
        };
        let words: Vec<_> = self.kinds().filter_map(counted).collect();
        if words.is_empty() { "none".to_owned() } else { words.join(", ") }
    }
}

impl Serialize for PrimitiveCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let plural = |(kind, n): (PrimKind, usize)| (format!("{}s", kind.name()), n);
        serializer.collect_map(self.kinds().map(plural))
    }
}

/// Figures of the BVH.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TreeFigures {
    /// Nodes, as [`TreeStats::nodes`] counts them.
    pub nodes: usize,
    /// Longest path from the root, the root counting 1.
    pub depth: usize,
    /// Surface area heuristic cost.
    pub sah: f64,
}

impl TreeFigures {
    /// The size in words.
    pub fn words(&self) -> String {
        format!("{} nodes, depth {}", grouped(self.nodes as u64), self.depth)
    }
}

impl From<TreeStats> for TreeFigures {
    fn from(stats: TreeStats) -> TreeFigures {
        TreeFigures {
            nodes: stats.nodes,
            depth: stats.depth,
            sah: stats.sah,
        }
    }
}

/// Rays of each kind and in total, by their names in documents and tables.
pub fn rays_by_kind(rays: &RayCounts) -> [(&'static str, u64); 5] {
    let [primary, shadow, reflection, refraction] = rays.by_kind();
    let total = ("total", rays.total());
    [primary, shadow, reflection, refraction, total]
}

/// Serializes rays by kind, as an object.
pub fn serialize_rays<S: Serializer>(rays: &RayCounts, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(rays_by_kind(rays))
}

/// Serializes a rate for each kind of ray, as an object.
pub fn serialize_rates<S: Serializer>(
    rates: &[(&'static str, f64); 5],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(*rates)
}

/// Millions of rays per second. The rates of the kinds all use the total time, so they add up.
pub fn mrays_per_s(rays: u64, seconds: f64) -> f64 {
    if seconds > 0.0 { rays as f64 / 1e6 / seconds } else { 0.0 }
}
