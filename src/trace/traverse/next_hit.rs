//! The query for the next hit of a ray after another: how rays go on through surfaces that are only
//! partly there.
//!
//! Hits have an order, that of (t, prim_id), where the distance of a hit on an instance is the one
//! in the world (see [`instance`]). So the hits of a ray are met one after another, each primitive
//! once, whatever the tree: also those that share a distance.
//!
//! Boxes that a ray has left before the hit `after` are not entered: each box is left no earlier
//! than the hits in it are met ([`slab_conservative`](crate::intersect::slab_conservative)).

use super::query::Query;
use crate::intersect::aabb::TInterval;
use crate::intersect::hit::{HitCandidate, HitRecord, inactive_t};
use crate::intersect::instance;
use crate::packet::HitPacket;
use crate::simd::{LaneMask, LaneU32, Lanes};

/// The closest hit after `after`, by (t, prim_id). Distances and numbers are those in the world,
/// within an instance, too.
#[derive(Clone, Copy)]
pub(super) struct NextHit<L: Lanes> {
    best: HitRecord<L>,
    after_t: L,
    after_id: L::U32,
    /// Distance before which a ray has left the boxes that hold nothing any more.
    near: L,
    /// Interval in the box of the instance whose mesh is searched; all distances in the world.
    interval: TInterval<L>,
    /// Offset of the numbers of the instance's primitives.
    id_offset: u32,
}

impl<L: Lanes> NextHit<L> {
    /// A query for hits before `limit`, in lanes that are not inactive.
    #[inline(always)]
    pub(super) fn new(limit: L, after_t: L, after_id: L::U32) -> NextHit<L> {
        NextHit {
            best: HitRecord::before(limit),
            after_t,
            after_id,
            near: after_t,
            interval: TInterval::everywhere(),
            id_offset: 0,
        }
    }

    /// The hits below `tmax`.
    #[inline(always)]
    pub(super) fn hits(&self, tmax: L, active: L::Mask) -> HitPacket<L> {
        self.best.hits(tmax, active)
    }
}

impl<L: Lanes> Query<L> for NextHit<L> {
    const FRONT_TO_BACK: bool = true;

    #[inline(always)]
    fn limit(&self) -> L {
        instance::unclamped_limit(self.best.t, &self.interval)
    }

    #[inline(always)]
    fn overlaps(&self, interval: &TInterval<L>) -> L::Mask {
        interval.overlaps(self.limit()) & !interval.tfar.lt(self.near)
    }

    #[inline(always)]
    fn enter_instance(&self, interval: &TInterval<L>, id_offset: u32) -> Option<NextHit<L>> {
        let reached = instance::closest_limit(self.best.t, interval).gt(inactive_t())
            & !interval.tfar.lt(self.after_t);
        reached.any().then(|| NextHit {
            best: HitRecord {
                t: reached.select(self.best.t, inactive_t()),
                ..self.best
            },
            // A hit before the instance's box counts as one where the ray enters it.
            near: interval
                .tnear
                .lt(self.after_t)
                .select(self.after_t, L::splat(f32::NEG_INFINITY)),
            interval: *interval,
            id_offset,
            ..*self
        })
    }

    #[inline(always)]
    fn update(&mut self, hit: &HitCandidate<L>, id: u32) -> bool {
        let t = hit.t.max(self.interval.tnear).min(self.interval.tfar);
        let id = L::U32::splat(id.wrapping_add(self.id_offset));
        let later = t.gt(self.after_t) | (t.eq(self.after_t) & self.after_id.lt(id));
        let valid = hit.valid & t.gt(L::ZERO) & later;
        self.best.update(&HitCandidate { valid, t, ..*hit }, id);
        false
    }

    #[inline(always)]
    fn exit_instance(&mut self, inner: NextHit<L>, _: &TInterval<L>, _: u32) -> bool {
        // In the world's distances and numbers already; no closer where nothing was found.
        let found = inner.best;
        self.best.update(
            &HitCandidate {
                valid: found.t.gt(inactive_t()),
                t: found.t,
                v: found.v,
                w: found.w,
                det: found.det,
            },
            found.prim_id,
        );
        false
    }
}
