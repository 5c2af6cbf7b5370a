//! SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014):
//! small, and the same numbers everywhere for a seed.

use glam::Vec3;

/// A stream of random numbers.
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Rng {
        Rng(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// A number in \[0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// A number in \[lo, hi).
    pub fn range(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * self.unit()
    }

    /// A number between 10^lo and 10^hi, with a uniform exponent.
    pub fn magnitude(&mut self, lo: f32, hi: f32) -> f32 {
        10f32.powf(self.range(lo, hi))
    }

    /// A point in the cube of half side `half` around the origin.
    pub fn point(&mut self, half: f32) -> Vec3 {
        let mut coordinate = || self.range(-half, half);
        Vec3::new(coordinate(), coordinate(), coordinate())
    }

    /// A unit vector, uniform over all directions.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.point(1.0);
            let squared = v.length_squared();
            if (0.01..=1.0).contains(&squared) {
                return v / squared.sqrt();
            }
        }
    }

    /// A colour in the unit cube, one in three black.
    pub fn color(&mut self) -> Vec3 {
        if self.once_in(3) {
            return Vec3::ZERO;
        }
        Vec3::new(self.unit(), self.unit(), self.unit())
    }

    pub fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }
}
