//! Axis-aligned boxes.

use glam::Vec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub lo: Vec3,
    /// Upper corner.
    pub hi: Vec3,
}

impl Bounds {
    /// The box of nothing: the neutral element of [`Bounds::union`].
    pub const EMPTY: Bounds = Bounds {
        lo: Vec3::INFINITY,
        hi: Vec3::NEG_INFINITY,
    };

    /// A box from its corners.
    #[inline]
    pub fn new(lo: Vec3, hi: Vec3) -> Self {
        Bounds { lo, hi }
    }

    /// Whether it holds nothing.
    #[inline]
    pub fn is_empty(self) -> bool {
        !self.lo.cmple(self.hi).all()
    }

    /// The smallest box around both.
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

    /// The box that a hit on the boxed primitive must pass, and from which every node of every tree
    /// is made.
    ///
    /// Grown on all sides by [`PAD`] times its largest coordinate, which covers the rounding error
    /// of the hit point: see `trace::traverse`, "Why no tree can lose a hit".
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
/// |vertex − origin| of it; the box carries 32 of its own largest coordinate and the origin 32 of
/// its own.
pub const PAD: f32 = 1.0 / 524_288.0;

/// How far along its normal a point is moved off a plane, as a share of |n|·|p|, the sizes of the
/// products of normal and point: 4u with u = 2⁻²⁴. Rounding the point to `f32` costs u of that,
/// adding the offset another (pbrt's γ₁, Pharr, Jakob and Humphreys, "Managing Rounding Error"), so
/// a point of the plane is off it by 2u at least.
pub const PLANE_ROUNDING: f32 = 1.0 / 4_194_304.0;

/// And as a share of the triangle's edges, for what is lost before that, in `f64`: 2⁻⁴⁰, some 4,000
/// roundings, which is as much as a needle turns one into. It matters where the plane passes near
/// the origin, so that |n|·|p| says nothing.
pub const DOUBLE_ROUNDING: f32 = 1.0 / 1_099_511_627_776.0;

/// How far a ray that leaves a triangle likes to start off it, as a share of the point's largest
/// coordinate: beyond the paddings of the triangle's box and of the next ray's origin, so that a
/// ray that leaves a wall along an axis begins outside the wall's boxes and need not look into them
/// (`perf/notes/leaving-surfaces.md`).
pub const OFFSET_PER_COORDINATE: f32 = 4.0 * PAD;

/// And as shares of the triangle's edges, at least and at most: from the first on, `f32` tells most
/// rays that the triangle is behind them (`trace::traverse`, distances); the second is nothing that
/// one sees.
pub const OFFSET_PER_EDGE: [f32; 2] = [1.0 / 16_384.0, 1.0 / 1024.0];

/// But no farther than this share of the way to where the ray came from, whatever the coordinates
/// and the triangle's size: a quarter of a pixel's width in a picture of 4,000 pixels across 40
/// degrees.
pub const MAX_OFFSET_PER_DISTANCE: f32 = 1.0 / 16_384.0;
