//! Random numbers for tests.

use glam::Vec3;

/// Source of pseudo-random numbers.
pub(crate) struct RandomSource(pub(crate) u64);

impl RandomSource {
    /// A number from −1 to 1.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    pub(crate) fn position(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }

    /// A power of two, with exponents up to `most`.
    pub(crate) fn scale(&mut self, most: f32) -> f32 {
        (self.unit() * most).round().exp2()
    }
}
