//! Axis-aligned boxes.

use glam::{BVec3, Vec3};

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub lo: Vec3,
    /// Upper corner.
    pub hi: Vec3,
}

impl Default for Bounds {
    /// [`Bounds::EMPTY`].
    fn default() -> Self {
        Bounds::EMPTY
    }
}

impl Bounds {
    /// The empty box: the neutral element of [`Bounds::union`].
    pub const EMPTY: Bounds = Bounds {
        lo: Vec3::INFINITY,
        hi: Vec3::NEG_INFINITY,
    };

    /// A box from its corners.
    #[inline]
    pub fn new(lo: Vec3, hi: Vec3) -> Self {
        Bounds { lo, hi }
    }

    /// Returns true if the box is empty.
    #[inline]
    pub fn is_empty(self) -> bool {
        !self.lo.cmple(self.hi).all()
    }

    /// All eight corners.
    #[inline]
    pub fn corners(self) -> [Vec3; 8] {
        std::array::from_fn(|k| {
            let upper = BVec3::from_array([0, 1, 2].map(|axis| k >> axis & 1 == 1));
            Vec3::select(upper, self.hi, self.lo)
        })
    }

    /// The smallest box around both boxes.
    #[inline]
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds::new(self.lo.min(other.lo), self.hi.max(other.hi))
    }

    /// Half the surface area, the measure of the surface area heuristic; 0 for the empty box.
    #[inline]
    pub fn half_area(self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.hi - self.lo;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// The padded box. A hit on the boxed primitive must pass it, and every node of every tree is
    /// made from such boxes.
    ///
    /// It is grown on all sides by [`PAD`] times its largest coordinate. That covers the rounding
    /// error of the hit point: see `trace::intersect`, "Why no tree can lose a hit".
    #[inline]
    pub fn padded(self) -> Bounds {
        let pad = Vec3::splat(PAD * self.lo.abs().max(self.hi.abs()).max_element());
        Bounds::new(self.lo - pad, self.hi + pad)
    }
}

/// Relative outward padding of boxes and of ray origins in the slab test: 2⁻¹⁹ ≈ 1.9e-6, 32 units
/// in the last place.
///
/// A ray that passes a triangle's edges as computed is within some 8 units in the last place of
/// |vertex − origin| of it. The box is padded by 32 units of its own largest coordinate, the origin
/// by 32 of its own.
pub const PAD: f32 = 1.0 / 524_288.0;

/// Offset that moves a point off a plane along its normal, as a share of |n|·|p|, the sizes of the
/// products of normal and point. It is 4u with u = 2⁻²⁴. Rounding the point to `f32` costs u of
/// that, and adding the offset costs another u (pbrt's γ₁, Pharr, Jakob and Humphreys, "Managing
/// Rounding Error"). So a point of the plane ends up at least 2u off it.
pub const PLANE_ROUNDING: f32 = 1.0 / 4_194_304.0;

/// Second part of that offset, as a share of the triangle's edges, for earlier errors in `f64`:
/// 2⁻⁴⁰, some 4,000 roundings, to which a needle may amplify a single one. This part matters where
/// the plane passes near the origin, so that |n|·|p| is uninformative.
pub const DOUBLE_ROUNDING: f32 = 1.0 / 1_099_511_627_776.0;

/// Preferred offset of a ray that leaves a triangle, as a share of the point's largest coordinate.
/// It lies beyond the paddings of the triangle's box and of the next ray's origin. So a ray that
/// leaves a wall along an axis begins outside the wall's boxes and need not test their contents
/// (`perf/notes/leaving-surfaces.md`).
pub const OFFSET_PER_COORDINATE: f32 = 4.0 * PAD;

/// Smallest and largest offset of a ray that leaves a triangle, as shares of the triangle's edges.
/// From the first on, the `f32` distance shows for most rays that the triangle is behind them
/// (`trace::intersect`, distances). The second is too small to be visible.
pub const OFFSET_PER_EDGE: [f32; 2] = [1.0 / 16_384.0, 1.0 / 1024.0];

/// Largest offset as a share of the distance to the origin of the arriving ray, regardless of the
/// coordinates and the triangle's size: a quarter of a pixel's width in a picture of 4,000 pixels
/// across 40 degrees.
pub const MAX_OFFSET_PER_DISTANCE: f32 = 1.0 / 16_384.0;
