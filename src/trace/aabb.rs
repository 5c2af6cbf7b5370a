//! The slab test (Kay and Kajiya 1986; Williams et al., "An Efficient and Robust Ray-Box Intersection Algorithm",
//! 2005), eight rays against one box.
//!
//! Departures: the reciprocal of a (nearly) zero component is a large finite number, so that no NaN arises from
//! 0 · ∞; and each ray's origin is an interval, grown by [`PAD`] of its largest coordinate, because the rounding of
//! vertex − origin depends on the origin's size. Both keep the test monotone in the box (see [`crate::trace`]).

use crate::lanes::{F32x8, Mask8, Vec3x8};
use crate::scene::PAD;

/// Components smaller than this count as this when inverted: 2⁻⁸⁰. With coordinates below 2²⁹ no product overflows.
const SMALLEST: f32 = f32::from_bits((127 - 80) << 23);

/// What the slab test needs of eight rays.
#[derive(Clone, Copy)]
pub(super) struct Slabs {
    rdir: Vec3x8,
    /// Origin, lowered and raised by the padding.
    org_lo: Vec3x8,
    org_hi: Vec3x8,
}

/// Where eight rays enter and leave a box, and which of them do so within \[0, `best`\].
pub(super) struct Stay {
    pub(super) enter: F32x8,
    pub(super) leave: F32x8,
}

impl Slabs {
    #[inline(always)]
    pub(super) fn new(org: Vec3x8, dir: Vec3x8) -> Slabs {
        let size = org.abs();
        let pad = size.x.max(size.y).max(size.z) * F32x8::splat(PAD);
        let pad = Vec3x8::new(pad, pad, pad);
        Slabs {
            rdir: Vec3x8::new(reciprocal(dir.x), reciprocal(dir.y), reciprocal(dir.z)),
            org_lo: org - pad,
            org_hi: org + pad,
        }
    }

    /// Entry (not before 0) and exit distances.
    #[inline(always)]
    pub(super) fn stay(&self, corners: &[[f32; 3]; 2]) -> Stay {
        let [lo, hi] = corners;
        let x0 = (F32x8::splat(lo[0]) - self.org_hi.x) * self.rdir.x;
        let x1 = (F32x8::splat(hi[0]) - self.org_lo.x) * self.rdir.x;
        let y0 = (F32x8::splat(lo[1]) - self.org_hi.y) * self.rdir.y;
        let y1 = (F32x8::splat(hi[1]) - self.org_lo.y) * self.rdir.y;
        let z0 = (F32x8::splat(lo[2]) - self.org_hi.z) * self.rdir.z;
        let z1 = (F32x8::splat(hi[2]) - self.org_lo.z) * self.rdir.z;
        Stay {
            enter: x0.min(x1).max(y0.min(y1)).max(z0.min(z1)).max(F32x8::ZERO),
            leave: x0.max(x1).min(y0.max(y1)).min(z0.max(z1)),
        }
    }
}

impl Stay {
    /// Lanes whose ray is in the box somewhere between 0 and `best`.
    #[inline(always)]
    pub(super) fn within(&self, best: F32x8) -> Mask8 {
        self.enter.le(self.leave.min(best))
    }
}

/// 1/x, with x no closer to zero than [`SMALLEST`] and its sign kept.
#[inline(always)]
fn reciprocal(x: F32x8) -> F32x8 {
    let tiny = x.abs().lt(F32x8::splat(SMALLEST));
    let negative = x.lt(F32x8::ZERO);
    let signed = negative.select(F32x8::splat(-SMALLEST), F32x8::splat(SMALLEST));
    F32x8::ONE / tiny.select(signed, x)
}
