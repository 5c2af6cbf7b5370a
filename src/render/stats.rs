//! Work counters of a render, independent of the number of threads.

use phalanx_scene::RayCounts;

/// Work counters of one render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderStats {
    /// Rays traced.
    pub rays: RayCounts,
    /// Packets traced; 0 for the scalar engine.
    pub packets: u64,
    /// Hits on backs of single-sided materials, which rays passed.
    pub unseen_backs: u64,
}

impl RenderStats {
    /// Share of packet lanes that carried a ray, in \[0, 1\]; `None` for the scalar engine.
    pub fn occupancy(&self) -> Option<f64> {
        (self.packets > 0).then(|| self.rays.total() as f64 / (8 * self.packets) as f64)
    }

    /// Adds a worker's counters.
    pub fn add(&mut self, other: &RenderStats) {
        self.rays.add(&other.rays);
        self.packets += other.packets;
        self.unseen_backs += other.unseen_backs;
    }
}
