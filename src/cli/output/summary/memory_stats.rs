//! Memory use by part.

use super::process_status::process_status;
use super::table::bytes;
use phalanx::frame::TreeStats;
use phalanx::scene::Scene;
use serde::Serialize;
use std::collections::BTreeMap;

/// Bytes by part. Parts in a mapped cache are included here and also in `mapped_bytes`.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MemoryStats {
    /// Total of all scene columns.
    scene_bytes: u64,
    /// Scene columns by part.
    scene_parts: BTreeMap<&'static str, u64>,
    bvh_node_bytes: u64,
    bvh_primitive_bytes: u64,
    /// The wide tree; 0 if none was built.
    bvh_wide_bytes: u64,
    /// The film and its encoded picture; 0 if there is none.
    film_bytes: u64,
    /// Sum of all of the above.
    total_bytes: u64,
    /// Scene and tree per stored primitive; `None` if there are none.
    bytes_per_primitive: Option<f64>,
    /// The process's peak per stored primitive; `None` if either is unknown.
    peak_bytes_per_primitive: Option<f64>,
    /// Size of the mapped cache; 0 if there is none.
    mapped_bytes: u64,
    /// Peak memory of the process; `None` if the system does not report it.
    peak_rss_bytes: Option<u64>,
}

impl MemoryStats {
    /// Figures of a scene with its BVH, a film of `film_bytes` bytes, and a mapped file.
    pub fn of(scene: &Scene, tree: &TreeStats, film_bytes: u64, mapped_bytes: u64) -> MemoryStats {
        let scene_bytes = scene.memory_bytes() as u64;
        let trees = [tree.node_bytes, tree.prim_bytes, tree.wide_bytes];
        let [nodes, prims, wide] = trees.map(|bytes| bytes as u64);
        let at_rest = scene_bytes + nodes + prims + wide;
        let parts = scene.memory_parts().into_iter();
        let parts = parts.map(|(name, bytes)| (name, bytes as u64));
        let count = scene.prim_count();
        let each = |bytes: u64| (count > 0).then(|| bytes as f64 / count as f64);
        let peak = peak_rss_bytes();
        MemoryStats {
            scene_bytes,
            scene_parts: parts.filter(|(_, bytes)| *bytes > 0).collect(),
            bvh_node_bytes: nodes,
            bvh_primitive_bytes: prims,
            bvh_wide_bytes: wide,
            film_bytes,
            total_bytes: at_rest + film_bytes,
            bytes_per_primitive: each(at_rest),
            peak_bytes_per_primitive: peak.and_then(each),
            mapped_bytes,
            peak_rss_bytes: peak,
        }
    }

    /// The figures as rows of a table.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let mut all = vec![
            ("scene", self.scene_bytes),
            ("tree nodes", self.bvh_node_bytes),
            ("tree primitives", self.bvh_primitive_bytes),
        ];
        let others = [
            ("wide tree", self.bvh_wide_bytes),
            ("film", self.film_bytes),
        ];
        all.extend(others.into_iter().filter(|(_, bytes)| *bytes > 0));
        let listed = |parts: &mut dyn Iterator<Item = (&str, u64)>| {
            let words = parts.map(|(name, b)| format!("{name} {}", bytes(b)));
            Vec::from_iter(words).join(", ")
        };
        let mut rows = vec![("memory", listed(&mut all.into_iter()))];
        if !self.scene_parts.is_empty() {
            let mut parts = self.scene_parts.iter().map(|(name, b)| (*name, *b));
            rows.push(("columns", listed(&mut parts)));
        }
        if let Some(rest) = self.bytes_per_primitive {
            let peak = self.peak_bytes_per_primitive;
            let peak = peak.map_or(String::new(), |peak| format!(", {peak:.1} at peak"));
            rows.push(("bytes each", format!("primitive {rest:.1}{peak}")));
        }
        if self.mapped_bytes > 0 {
            let mapped = bytes(self.mapped_bytes);
            rows.push(("mapped", format!("{mapped} of a scene cache")));
        }
        if let Some(peak) = self.peak_rss_bytes {
            rows.push(("peak memory", bytes(peak)));
        }
        rows
    }
}

/// Peak memory of this process; only Linux reports it.
fn peak_rss_bytes() -> Option<u64> {
    let peak = process_status("VmHWM")?;
    let kib: u64 = peak.strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
