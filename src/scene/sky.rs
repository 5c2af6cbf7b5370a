//! A sky for mirrors: light that differs by direction.

use glam::Vec3;

/// Radiance that changes evenly from one colour below to another above. Without it, a mirror in
/// front of a uniform background would be invisible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Unit vector to the zenith.
    pub up: Vec3,
    /// Radiance from straight below.
    pub nadir: Vec3,
    /// Radiance from straight above.
    pub zenith: Vec3,
}

impl Sky {
    /// Radiance along a unit direction: nadir + (zenith − nadir)·(½ d·up + ½).
    #[inline]
    pub fn radiance(&self, dir: Vec3) -> Vec3 {
        let height = dir.dot(self.up) * 0.5 + 0.5;
        self.nadir + (self.zenith - self.nadir) * height
    }
}
