//! Vectors in lanes.

use super::{F32x8, F64x8, LANES, LaneMask, Lanes};
use glam::Vec3;
use std::ops::{Add, Mul, Neg, Sub};

/// Eight vectors.
pub type Vec3x8 = Vec3Lanes<F32x8>;

/// Vectors as three columns of lanes.
#[derive(Clone, Copy, Debug)]
pub struct Vec3Lanes<L> {
    /// x components.
    pub x: L,
    /// y components.
    pub y: L,
    /// z components.
    pub z: L,
}

impl<L> Vec3Lanes<L> {
    /// A vector from three columns.
    #[inline(always)]
    pub const fn new(x: L, y: L, z: L) -> Vec3Lanes<L> {
        Vec3Lanes { x, y, z }
    }
}

/// Operations that single and double precision share.
impl<L: Copy + Add<Output = L> + Sub<Output = L> + Mul<Output = L>> Vec3Lanes<L> {
    /// (x·x' + y·y') + z·z', in the order of glam's `Vec3::dot`.
    #[inline]
    pub fn dot(self, o: Vec3Lanes<L>) -> L {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// The cross product, in the order of glam's `Vec3::cross`.
    #[inline]
    pub fn cross(self, o: Vec3Lanes<L>) -> Vec3Lanes<L> {
        Vec3Lanes::new(
            self.y * o.z - o.y * self.z,
            self.z * o.x - o.z * self.x,
            self.x * o.y - o.x * self.y,
        )
    }

    /// Every component times `s`.
    #[inline]
    pub fn scale(self, s: L) -> Vec3Lanes<L> {
        Vec3Lanes::new(self.x * s, self.y * s, self.z * s)
    }
}

impl<L: Lanes> Vec3Lanes<L> {
    /// Lanes that hold the same bits in both vectors.
    #[inline(always)]
    pub fn bits_eq(self, o: Vec3Lanes<L>) -> L::Mask {
        self.x.bits_eq(o.x) & self.y.bits_eq(o.y) & self.z.bits_eq(o.z)
    }

    /// The zero vector.
    pub const ZERO: Vec3Lanes<L> = Vec3Lanes::new(L::ZERO, L::ZERO, L::ZERO);

    /// The components starting at an axis: its own, the next one's and the last one's. An index
    /// would pass them through memory, where the load of the whole waits for the stores of its
    /// halves.
    #[inline(always)]
    pub fn from_axis(self, axis: usize) -> [L; 3] {
        match axis {
            0 => [self.x, self.y, self.z],
            1 => [self.y, self.z, self.x],
            _ => [self.z, self.x, self.y],
        }
    }

    /// The vector in a lane.
    #[inline]
    pub fn lane(&self, k: usize) -> Vec3 {
        let one = |column: &L| column.octet(k / LANES).lane(k % LANES);
        Vec3::new(one(&self.x), one(&self.y), one(&self.z))
    }

    /// Lanes of `yes` where the mask is set, of `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: L::Mask, yes: Vec3Lanes<L>, no: Vec3Lanes<L>) -> Vec3Lanes<L> {
        Vec3Lanes::new(
            mask.select(yes.x, no.x),
            mask.select(yes.y, no.y),
            mask.select(yes.z, no.z),
        )
    }

    /// Largest absolute component.
    #[inline(always)]
    pub fn max_abs(self) -> L {
        let size = self.abs();
        size.x.max(size.y).max(size.z)
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(x: f32, y: f32, z: f32) -> Vec3Lanes<L> {
        Vec3Lanes::new(L::splat(x), L::splat(y), L::splat(z))
    }

    /// Componentwise product.
    #[inline]
    pub fn mul_elementwise(self, o: Vec3Lanes<L>) -> Vec3Lanes<L> {
        Vec3Lanes::new(self.x * o.x, self.y * o.y, self.z * o.z)
    }

    /// v · (1/|v|): one division, three products; NaN for the zero vector.
    #[inline(always)]
    pub fn normalized(self) -> Vec3Lanes<L> {
        self.scale(L::ONE / self.dot(self).sqrt())
    }

    /// Componentwise absolute value.
    #[inline(always)]
    pub fn abs(self) -> Vec3Lanes<L> {
        Vec3Lanes::new(self.x.abs(), self.y.abs(), self.z.abs())
    }
}

impl Vec3Lanes<F64x8> {
    /// Every component rounded to `f32`.
    #[inline(always)]
    pub fn rounded(self) -> Vec3x8 {
        Vec3x8::new(self.x.rounded(), self.y.rounded(), self.z.rounded())
    }
}

impl From<Vec3x8> for Vec3Lanes<F64x8> {
    #[inline(always)]
    fn from(v: Vec3x8) -> Vec3Lanes<F64x8> {
        Vec3Lanes::new(v.x.into(), v.y.into(), v.z.into())
    }
}

impl<L: Add<Output = L>> Add for Vec3Lanes<L> {
    type Output = Vec3Lanes<L>;
    #[inline]
    fn add(self, o: Vec3Lanes<L>) -> Vec3Lanes<L> {
        Vec3Lanes::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl<L: Sub<Output = L>> Sub for Vec3Lanes<L> {
    type Output = Vec3Lanes<L>;
    #[inline]
    fn sub(self, o: Vec3Lanes<L>) -> Vec3Lanes<L> {
        Vec3Lanes::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl<L: Lanes> Neg for Vec3Lanes<L> {
    type Output = Vec3Lanes<L>;
    #[inline(always)]
    fn neg(self) -> Vec3Lanes<L> {
        Vec3Lanes::new(-self.x, -self.y, -self.z)
    }
}
