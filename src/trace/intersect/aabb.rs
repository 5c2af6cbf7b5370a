//! The slab test (Kay and Kajiya 1986; Williams et al., "An Efficient and Robust Ray-Box
//! Intersection Algorithm", 2005), rays against one box.
//!
//! There are two departures. The reciprocal of a (nearly) zero component is a large finite number,
//! so that no NaN arises from 0 · ∞. And each ray's origin is an interval, grown by [`PAD`] of its
//! largest coordinate, because the rounding of vertex − origin depends on the origin's size. Both
//! keep the test monotone in the box (see [`crate::traverse`]).

use crate::simd::{LaneMask, Lanes, Vec3Lanes};
use phalanx_scene::PAD;

/// Smallest magnitude of a component to be inverted; smaller ones are replaced by it: 2⁻⁸⁰. With
/// coordinates below 2²⁹ no product overflows.
const MIN_DIRECTION: f32 = f32::from_bits((127 - 80) << 23);

/// Share of a hit's distance by which its ray may at most enter the primitive's own box after it,
/// or leave it before: 2⁻¹³. Only triangles need it (`triangle/distance.rs`).
pub(crate) const ENTRY_SLACK: f32 = 1.0 / 8192.0;

/// Factor on the distance up to which hits count: boxes are entered up to there.
pub(crate) const REACH: f32 = 1.0 + 2.0 * ENTRY_SLACK;

/// Slab data of the rays.
#[derive(Clone, Copy)]
pub(crate) struct RaySlabs<L> {
    /// One over each component of the directions.
    pub(crate) rdir: Vec3Lanes<L>,
    /// Origins for the planes that a ray crosses first, and for those that it crosses last. Both
    /// are moved by the padding, away from the box. If the rays' signs differ, they are for the
    /// lower and the upper planes instead.
    pub(crate) org: [Vec3Lanes<L>; 2],
    /// Side of a box (0 lower, 1 upper) that is crossed first, per axis, if all rays agree.
    pub(crate) octant: Option<[usize; 3]>,
}

/// Distances at which the rays enter and leave a box.
#[derive(Clone, Copy)]
pub(crate) struct TInterval<L> {
    pub(crate) tnear: L,
    pub(crate) tfar: L,
}

impl<L: Lanes> TInterval<L> {
    /// The whole line.
    #[inline(always)]
    pub(crate) fn everywhere() -> TInterval<L> {
        TInterval {
            tnear: L::splat(f32::NEG_INFINITY),
            tfar: L::splat(f32::INFINITY),
        }
    }

    /// Clamps distances to this interval of the primitive's own box, and marks the lanes in which
    /// they are ahead of the origin.
    #[inline(always)]
    pub(crate) fn clamp(&self, raw: L) -> (L::Mask, L) {
        let t = raw.max(self.tnear).min(self.tfar);
        let ahead = raw.gt(L::ZERO) & t.gt(L::ZERO);
        (ahead & self.tnear.le(self.tfar), t)
    }

    /// Lanes whose ray is in the box somewhere between 0 and `best`.
    #[inline(always)]
    pub(crate) fn overlaps(&self, best: L) -> L::Mask {
        self.tnear.le(self.tfar.min(best))
    }
}

impl<L: Lanes> RaySlabs<L> {
    #[inline(always)]
    pub(crate) fn new(org: Vec3Lanes<L>, dir: Vec3Lanes<L>, active: L::Mask) -> RaySlabs<L> {
        let [rdir, lo, hi] = RaySlabs::columns(org, dir);
        let live = active.bits();
        let negative = [dir.x, dir.y, dir.z].map(|d| d.lt(L::ZERO).bits() & live);
        let agree = negative.iter().all(|&n| n == 0 || n == live);
        let near = negative.map(|n| usize::from(n != 0));
        let pick = |k: usize, a: L, b: L| if agree && near[k] == 1 { b } else { a };
        let first = Vec3Lanes::new(
            pick(0, hi.x, lo.x),
            pick(1, hi.y, lo.y),
            pick(2, hi.z, lo.z),
        );
        let last = Vec3Lanes::new(
            pick(0, lo.x, hi.x),
            pick(1, lo.y, hi.y),
            pick(2, lo.z, hi.z),
        );
        RaySlabs {
            rdir,
            org: [first, last],
            octant: agree.then_some(near),
        }
    }

    /// Reciprocal directions, and origins moved down and up by the padding, from which
    /// [`RaySlabs::new`] picks.
    #[inline(always)]
    pub(crate) fn columns(org: Vec3Lanes<L>, dir: Vec3Lanes<L>) -> [Vec3Lanes<L>; 3] {
        let rdir = Vec3Lanes::new(reciprocal(dir.x), reciprocal(dir.y), reciprocal(dir.z));
        let pad = org.max_abs() * L::splat(PAD);
        let pad = Vec3Lanes::new(pad, pad, pad);
        [rdir, org - pad, org + pad]
    }

    /// Entry (not before 0) and exit distances, for any rays.
    #[inline(always)]
    pub(crate) fn intersect_box(&self, corners: &[[f32; 3]; 2]) -> TInterval<L> {
        match self.octant {
            Some(near) => self.intersect_box_same_octant(corners, near),
            None => self.intersect_box_mixed(corners),
        }
    }
}

impl<L: Lanes> SlabTest<L> for RaySlabs<L> {
    #[inline(always)]
    fn distances(&self, side: usize, [x, y, z]: [f32; 3]) -> [L; 3] {
        let org = &self.org[side];
        [
            (L::splat(x) - org.x) * self.rdir.x,
            (L::splat(y) - org.y) * self.rdir.y,
            (L::splat(z) - org.z) * self.rdir.z,
        ]
    }
}

/// Distances of planes along rays, and from these the intervals of rays in boxes. A trait, because
/// closures would not be inlined.
pub(crate) trait SlabTest<L: Lanes> {
    /// Distances of three planes, one per axis, on the side of a box that rays cross first (0) or
    /// last (1). If the rays' signs differ, the sides are the lower and the upper planes.
    fn distances(&self, side: usize, planes: [f32; 3]) -> [L; 3];

    /// Entry (not before 0) and exit distances, for rays whose direction signs agree. No min and
    /// max of plane distances is needed, and the numbers are the same, because rounding preserves
    /// their order. `near` is [`RaySlabs::octant`].
    #[inline(always)]
    fn intersect_box_same_octant(&self, corners: &[[f32; 3]; 2], near: [usize; 3]) -> TInterval<L> {
        let [i, j, k] = near.map(|n| n & 1);
        let first = [corners[i][0], corners[j][1], corners[k][2]];
        let last = [corners[1 - i][0], corners[1 - j][1], corners[1 - k][2]];
        let ([x0, y0, z0], [x1, y1, z1]) = (self.distances(0, first), self.distances(1, last));
        TInterval {
            tnear: x0.max(y0).max(z0).max(L::ZERO),
            tfar: x1.min(y1).min(z1),
        }
    }

    /// Entry (not before 0) and exit distances, for rays that go either way along an axis.
    #[inline(always)]
    fn intersect_box_mixed(&self, [lo, hi]: &[[f32; 3]; 2]) -> TInterval<L> {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.distances(0, *lo), self.distances(1, *hi));
        TInterval {
            tnear: x0.min(x1).max(y0.min(y1)).max(z0.min(z1)).max(L::ZERO),
            tfar: x0.max(x1).min(y0.max(y1)).min(z0.max(z1)),
        }
    }
}

/// 1/x, with x no closer to zero than [`MIN_DIRECTION`] and with its sign kept.
#[inline(always)]
fn reciprocal<L: Lanes>(x: L) -> L {
    let tiny = x.abs().lt(L::splat(MIN_DIRECTION));
    let negative = x.lt(L::ZERO);
    let signed = negative.select(L::splat(-MIN_DIRECTION), L::splat(MIN_DIRECTION));
    L::ONE / tiny.select(signed, x)
}

/// [`reciprocal`] of one number.
#[inline(always)]
pub(crate) fn reciprocal_of_one(x: f32) -> f32 {
    let tiny = if x < 0.0 { -MIN_DIRECTION } else { MIN_DIRECTION };
    1.0 / if x.abs() < MIN_DIRECTION { tiny } else { x }
}
