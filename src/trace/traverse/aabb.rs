//! The slab test (Kay and Kajiya 1986; Williams et al., "An Efficient and Robust Ray-Box Intersection Algorithm",
//! 2005), rays against one box.
//!
//! Departures: the reciprocal of a (nearly) zero component is a large finite number, so that no NaN arises from
//! 0 · ∞; and each ray's origin is an interval, grown by [`PAD`] of its largest coordinate, because the rounding of
//! vertex − origin depends on the origin's size. Both keep the test monotone in the box (see [`crate::traverse`]).

use crate::simd::{LaneMask, Lanes, Vec3Lanes};
use phalanx_scene::PAD;

/// Components smaller than this count as this when inverted: 2⁻⁸⁰. With coordinates below 2²⁹ no product overflows.
const SMALLEST: f32 = f32::from_bits((127 - 80) << 23);

/// What the slab test needs of the rays.
#[derive(Clone, Copy)]
pub(super) struct Slabs<L> {
    /// One over each component of the directions.
    pub(super) rdir: Vec3Lanes<L>,
    /// Origin for the planes a ray meets first, and for those it meets last: moved by the padding, away from the box
    /// in both cases. Where the rays' signs differ, for the lower and for the upper planes instead.
    pub(super) org: [Vec3Lanes<L>; 2],
    /// Per axis, which corner of a box (0 lower, 1 upper) is met first, if all rays agree.
    pub(super) near: Option<[usize; 3]>,
}

/// Where the rays enter and leave a box, and which of them do so within \[0, `best`\].
pub(super) struct Stay<L> {
    pub(super) enter: L,
    pub(super) leave: L,
}

impl<L: Lanes> Slabs<L> {
    #[inline(always)]
    pub(super) fn new(org: Vec3Lanes<L>, dir: Vec3Lanes<L>, active: L::Mask) -> Slabs<L> {
        let [rdir, lo, hi] = Slabs::columns(org, dir);
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
        Slabs {
            rdir,
            org: [first, last],
            near: agree.then_some(near),
        }
    }

    /// Reciprocal directions, and origins moved down and up: what [`Slabs::new`] picks from.
    #[inline(always)]
    pub(super) fn columns(org: Vec3Lanes<L>, dir: Vec3Lanes<L>) -> [Vec3Lanes<L>; 3] {
        let rdir = Vec3Lanes::new(reciprocal(dir.x), reciprocal(dir.y), reciprocal(dir.z));
        let [lo, hi] = Slabs::moved(org);
        [rdir, lo, hi]
    }

    /// An origin moved down and up.
    #[inline(always)]
    fn moved(org: Vec3Lanes<L>) -> [Vec3Lanes<L>; 2] {
        let pad = org.max_abs() * L::splat(PAD);
        let pad = Vec3Lanes::new(pad, pad, pad);
        [org - pad, org + pad]
    }

    /// Entry (not before 0) and exit distances, for any rays.
    #[inline(always)]
    pub(super) fn stay(&self, corners: &[[f32; 3]; 2]) -> Stay<L> {
        match self.near {
            Some(near) => self.stay_ordered(corners, near),
            None => self.stay_mixed(corners),
        }
    }
}

impl<L: Lanes> Planes<L> for Slabs<L> {
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

/// How far along rays planes are, and with that where rays are in a box. A trait and no closures, which would not be inlined.
pub(super) trait Planes<L: Lanes> {
    /// Distances of three planes, one across each axis, on the side of a box that rays meet first (0) or last (1); of lower and of
    /// upper planes, where the rays' signs differ.
    fn distances(&self, side: usize, planes: [f32; 3]) -> [L; 3];

    /// Entry (not before 0) and exit distances, for rays whose direction signs agree: no min and max of plane distances, and the
    /// same numbers, because rounding keeps their order. `near` is [`Slabs::near`].
    #[inline(always)]
    fn stay_ordered(&self, corners: &[[f32; 3]; 2], near: [usize; 3]) -> Stay<L> {
        let [i, j, k] = near.map(|n| n & 1);
        let first = [corners[i][0], corners[j][1], corners[k][2]];
        let last = [corners[1 - i][0], corners[1 - j][1], corners[1 - k][2]];
        let ([x0, y0, z0], [x1, y1, z1]) = (self.distances(0, first), self.distances(1, last));
        Stay {
            enter: x0.max(y0).max(z0).max(L::ZERO),
            leave: x1.min(y1).min(z1),
        }
    }

    /// The same for rays that go either way along an axis.
    #[inline(always)]
    fn stay_mixed(&self, [lo, hi]: &[[f32; 3]; 2]) -> Stay<L> {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.distances(0, *lo), self.distances(1, *hi));
        Stay {
            enter: x0.min(x1).max(y0.min(y1)).max(z0.min(z1)).max(L::ZERO),
            leave: x0.max(x1).min(y0.max(y1)).min(z0.max(z1)),
        }
    }
}

impl<L: Lanes> Stay<L> {
    /// Distances, clamped to this stay in the primitive's own box, and lanes where they are ahead of the origin.
    #[inline(always)]
    pub(super) fn clamp(&self, raw: L) -> (L::Mask, L) {
        let t = raw.max(self.enter).min(self.leave);
        let ahead = raw.gt(L::ZERO) & t.gt(L::ZERO);
        (ahead & self.enter.le(self.leave), t)
    }

    /// Lanes whose ray is in the box somewhere between 0 and `best`.
    #[inline(always)]
    pub(super) fn within(&self, best: L) -> L::Mask {
        self.enter.le(self.leave.min(best))
    }
}

/// 1/x, with x no closer to zero than [`SMALLEST`] and its sign kept.
#[inline(always)]
fn reciprocal<L: Lanes>(x: L) -> L {
    let tiny = x.abs().lt(L::splat(SMALLEST));
    let negative = x.lt(L::ZERO);
    let signed = negative.select(L::splat(-SMALLEST), L::splat(SMALLEST));
    L::ONE / tiny.select(signed, x)
}
