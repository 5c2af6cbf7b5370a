//! The slab test (Kay and Kajiya 1986; Williams et al., "An Efficient and Robust Ray-Box Intersection Algorithm",
//! 2005), rays against one box.
//!
//! Departures: the reciprocal of a (nearly) zero component is a large finite number, so that no NaN arises from
//! 0 · ∞; and each ray's origin is an interval, grown by [`PAD`] of its largest coordinate, because the rounding of
//! vertex − origin depends on the origin's size. Both keep the test monotone in the box (see [`crate::trace`]).

use crate::lanes::{LaneMask, Lanes, Vec3Lanes};
use crate::scene::PAD;

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
        let [lo, hi] = Slabs::moved(org, 1.0);
        [rdir, lo, hi]
    }

    /// An origin moved down and up, by so many paddings.
    #[inline(always)]
    pub(super) fn moved(org: Vec3Lanes<L>, pads: f32) -> [Vec3Lanes<L>; 2] {
        let pad = org.largest() * L::splat(pads * PAD);
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

    /// For rays whose direction signs agree: no min and max of plane distances, and the same numbers, because
    /// rounding keeps their order.
    #[inline(always)]
    pub(super) fn stay_ordered(&self, corners: &[[f32; 3]; 2], near: [usize; 3]) -> Stay<L> {
        let [first, last] = &self.org;
        let [i, j, k] = near.map(|n| n & 1);
        let x0 = (L::splat(corners[i][0]) - first.x) * self.rdir.x;
        let x1 = (L::splat(corners[1 - i][0]) - last.x) * self.rdir.x;
        let y0 = (L::splat(corners[j][1]) - first.y) * self.rdir.y;
        let y1 = (L::splat(corners[1 - j][1]) - last.y) * self.rdir.y;
        let z0 = (L::splat(corners[k][2]) - first.z) * self.rdir.z;
        let z1 = (L::splat(corners[1 - k][2]) - last.z) * self.rdir.z;
        Stay {
            enter: x0.max(y0).max(z0).max(L::ZERO),
            leave: x1.min(y1).min(z1),
        }
    }

    /// For rays that go either way along an axis.
    #[inline(always)]
    pub(super) fn stay_mixed(&self, corners: &[[f32; 3]; 2]) -> Stay<L> {
        let [lo, hi] = corners;
        let [for_lo, for_hi] = &self.org;
        let x0 = (L::splat(lo[0]) - for_lo.x) * self.rdir.x;
        let x1 = (L::splat(hi[0]) - for_hi.x) * self.rdir.x;
        let y0 = (L::splat(lo[1]) - for_lo.y) * self.rdir.y;
        let y1 = (L::splat(hi[1]) - for_hi.y) * self.rdir.y;
        let z0 = (L::splat(lo[2]) - for_lo.z) * self.rdir.z;
        let z1 = (L::splat(hi[2]) - for_hi.z) * self.rdir.z;
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
