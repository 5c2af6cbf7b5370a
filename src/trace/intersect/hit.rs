//! Hits: candidates of a test, and the record of the closest.

use crate::packet::{HitPacket, NO_PRIM};
use crate::simd::{LaneMask, LaneU32, Lanes};

/// The closest hits so far. Inactive lanes hold t = −∞.
#[derive(Clone, Copy)]
pub(crate) struct HitRecord<L: Lanes> {
    pub(crate) t: L,
    /// Barycentric weights of a triangle's second and third vertex, times `det`: divided once, at
    /// the end.
    pub(crate) v: L,
    pub(crate) w: L,
    pub(crate) det: L,
    pub(crate) prim_id: L::U32,
}

/// Lanes that hit a primitive, the distances, and the weights: a triangle's `v` and `w` are the
/// edge functions that weigh vertices b and c, `det` their sum with the third.
pub(crate) struct HitCandidate<L: Lanes> {
    pub(crate) valid: L::Mask,
    pub(crate) t: L,
    pub(crate) v: L,
    pub(crate) w: L,
    pub(crate) det: L,
}

impl<L: Lanes> HitCandidate<L> {
    /// A hit without barycentric weights.
    #[inline(always)]
    pub(crate) fn without_uv(valid: L::Mask, t: L) -> HitCandidate<L> {
        HitCandidate {
            valid,
            t,
            v: L::ZERO,
            w: L::ZERO,
            det: L::ONE,
        }
    }
}

impl<L: Lanes> HitRecord<L> {
    /// A record replaced only by hits closer than `limit`.
    #[inline(always)]
    pub(crate) fn before(limit: L) -> HitRecord<L> {
        HitRecord {
            t: limit,
            v: L::ZERO,
            w: L::ZERO,
            det: L::ONE,
            // The smallest number, so that a hit at the limit itself does not win the tie.
            prim_id: L::U32::splat(0),
        }
    }

    /// The hits below `tmax`.
    #[inline(always)]
    pub(crate) fn hits(&self, tmax: L, active: L::Mask) -> HitPacket<L> {
        let nearer = active & self.t.lt(tmax);
        HitPacket {
            t: nearer.select(self.t, tmax),
            u: self.v / self.det,
            v: self.w / self.det,
            prim_id: nearer.select_u32(self.prim_id, L::U32::splat(NO_PRIM)),
        }
    }

    /// The recorded hit as a candidate of these lanes, at these distances.
    #[inline(always)]
    pub(crate) fn candidate(&self, valid: L::Mask, t: L) -> HitCandidate<L> {
        HitCandidate {
            valid,
            t,
            v: self.v,
            w: self.w,
            det: self.det,
        }
    }

    /// Lanes whose record comes after a hit, by (t, prim_id).
    #[inline(always)]
    pub(crate) fn is_after(&self, t: L, id: L::U32) -> L::Mask {
        t.lt(self.t) | (t.eq(self.t) & id.lt(self.prim_id))
    }

    /// Replaces the record by a hit that is closer, or equally close with a smaller number.
    #[inline(always)]
    pub(crate) fn update(&mut self, hit: &HitCandidate<L>, id: L::U32) -> L::Mask {
        let take = hit.valid & self.is_after(hit.t, id);
        self.t = take.select(hit.t, self.t);
        self.v = take.select(hit.v, self.v);
        self.w = take.select(hit.w, self.w);
        self.det = take.select(hit.det, self.det);
        self.prim_id = take.select_u32(id, self.prim_id);
        take
    }
}

/// The limit of a lane without a ray, or with nothing left to find.
#[inline(always)]
pub(crate) fn inactive_t<L: Lanes>() -> L {
    L::splat(f32::NEG_INFINITY)
}
