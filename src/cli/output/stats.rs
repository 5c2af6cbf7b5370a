//! Counts as the JSON documents and the tables give them: primitives, tree, rays.

use super::table::grouped;
use phalanx::frame::TreeStats;
use phalanx::render::RayCounts;
use phalanx::scene::Scene;
use serde::Serialize;

/// Primitives by kind.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PrimitiveCounts {
    /// Spheres, ellipsoids included.
    pub spheres: usize,
    /// Triangles.
    pub triangles: usize,
    /// Truncated cones and cylinders.
    pub cones: usize,
}

impl PrimitiveCounts {
    /// Counts of a scene.
    pub fn of(scene: &Scene) -> PrimitiveCounts {
        PrimitiveCounts {
            spheres: scene.spheres.len() + scene.ellipsoids.len(),
            triangles: scene.triangles.len(),
            cones: scene.cones.len(),
        }
    }

    /// The counts in words: "12,345 triangles, 3 spheres".
    pub fn words(&self) -> String {
        let counted = |n: usize, name: &str| {
            let plural = if n == 1 { "" } else { "s" };
            (n > 0).then(|| format!("{} {name}{plural}", grouped(n as u64)))
        };
        let kinds = [
            counted(self.spheres, "sphere"),
            counted(self.triangles, "triangle"),
            counted(self.cones, "cone"),
        ];
        let words: Vec<_> = kinds.into_iter().flatten().collect();
        if words.is_empty() {
            "none".to_owned()
        } else {
            words.join(", ")
        }
    }
}

/// Figures of the tree.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TreeFigures {
    /// Nodes, as [`TreeStats::nodes`] counts them.
    pub nodes: usize,
    /// Longest path from the root, the root counting 1.
    pub depth: usize,
    /// Surface area heuristic cost.
    pub sah: f64,
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

/// One number per kind of ray, and the total.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PerRayKind<T> {
    pub primary: T,
    pub shadow: T,
    pub reflection: T,
    pub refraction: T,
    pub total: T,
}

impl PerRayKind<u64> {
    /// Rays as counted.
    pub fn of(rays: &RayCounts) -> PerRayKind<u64> {
        PerRayKind {
            primary: rays.primary,
            shadow: rays.shadow,
            reflection: rays.reflection,
            refraction: rays.refraction,
            total: rays.total(),
        }
    }

    /// Millions of rays a second of the whole render, for each kind: they add up to the total.
    pub fn mrays_per_s(&self, seconds: f64) -> PerRayKind<f64> {
        let speed = |rays: u64| {
            if seconds > 0.0 {
                rays as f64 / 1e6 / seconds
            } else {
                0.0
            }
        };
        PerRayKind {
            primary: speed(self.primary),
            shadow: speed(self.shadow),
            reflection: speed(self.reflection),
            refraction: speed(self.refraction),
            total: speed(self.total),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_time_gives_no_speed() {
        let kinds = PerRayKind::of(&RayCounts::default()).mrays_per_s(0.0);
        assert_eq!(kinds, PerRayKind::default());
    }
}
