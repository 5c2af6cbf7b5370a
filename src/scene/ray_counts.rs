//! Numbers of rays that a tracer has traced, by kind.

/// Rays traced, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Camera rays.
    pub primary: u64,
    /// Rays toward lights.
    pub shadow: u64,
    /// Mirror rays.
    pub reflection: u64,
    /// Refracted rays.
    pub refraction: u64,
}

impl RayCounts {
    /// Sum over all kinds.
    #[inline]
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.reflection + self.refraction
    }

    /// The counts with the names of their kinds, as documents and tables have them.
    pub fn by_kind(&self) -> [(&'static str, u64); 4] {
        [
            ("primary", self.primary),
            ("shadow", self.shadow),
            ("reflection", self.reflection),
            ("refraction", self.refraction),
        ]
    }

    /// Adds another count.
    #[inline]
    pub fn add(&mut self, other: &RayCounts) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.reflection += other.reflection;
        self.refraction += other.refraction;
    }
}
