//! Queries for a ray's next hit, or next few, after a given one: how rays pass through partly
//! transparent surfaces.
//!
//! Hits are ordered by (t, prim_id); the distance of a hit on an instance is the one in the world
//! (see [`instance`]). So the hits of a ray are found one after another, each primitive once, even
//! at equal distances and for any tree.
//!
//! Boxes that a ray has left well before the hit `after` are not entered: none is left before the
//! hits in it, but for [`ENTRY_SLACK`](crate::intersect::aabb::ENTRY_SLACK).

use super::every_hit::FoundHit;
use super::query::Query;
use crate::intersect::aabb::{REACH, TInterval};
use crate::intersect::hit::{HitCandidate, HitRecord, inactive_t};
use crate::intersect::instance;
use crate::packet::HitPacket;
use crate::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, U32x8};
use std::cell::RefCell;

/// The closest hit after `after`, by (t, prim_id). Distances and numbers are those in the world,
/// also within an instance.
#[derive(Clone, Copy)]
pub(super) struct NextHit<L: Lanes> {
    pub(super) best: HitRecord<L>,
    after_t: L,
    after_id: L::U32,
    /// Boxes that a ray leaves before this distance contain no further hits.
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

    /// A candidate in the world's distances, valid if it comes after `after`, and its number.
    #[inline(always)]
    pub(super) fn later(&self, hit: &HitCandidate<L>, id: u32) -> (HitCandidate<L>, L::U32) {
        let t = hit.t.max(self.interval.tnear).min(self.interval.tfar);
        let id = L::U32::splat(id.wrapping_add(self.id_offset));
        let later = t.gt(self.after_t) | (t.eq(self.after_t) & self.after_id.lt(id));
        let valid = hit.valid & t.gt(L::ZERO) & later;
        (HitCandidate { valid, t, ..*hit }, id)
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
        let left = (interval.tfar * L::splat(REACH)).lt(self.near);
        interval.overlaps(self.reach()) & !left
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
        let (hit, id) = self.later(hit, id);
        self.best.update(&hit, id);
        false
    }

    #[inline(always)]
    fn exit_instance(&mut self, inner: NextHit<L>, _: &TInterval<L>, _: u32) -> bool {
        // Already in the world's distances and numbers; no closer if nothing was found.
        let hits = inner.best;
        let hit = hits.candidate(hits.t.gt(inactive_t()), hits.t);
        self.best.update(&hit, hits.prim_id);
        false
    }
}

/// Hits of eight rays, one list each.
pub(super) type HitsByLane = [Vec<FoundHit>; LANES];

/// The closest hits after `after` of each of eight rays, at least `most` if that many exist. Lists
/// hold all hits before the limit, unordered; a list that grows to twice `most` is cut, and lowers
/// its ray's limit. Copies of a query share the lists.
#[derive(Clone, Copy)]
pub(super) struct NextHits<'f> {
    /// Its `best` is the limit: no hit found, but the last one that may be.
    next: NextHit<F32x8>,
    most: usize,
    hits: &'f RefCell<HitsByLane>,
}

impl<'f> NextHits<'f> {
    pub(super) fn new(
        next: NextHit<F32x8>,
        most: usize,
        hits: &'f RefCell<HitsByLane>,
    ) -> NextHits<'f> {
        NextHits { next, most, hits }
    }

    /// Adds hits to their lists, and returns the limits after it.
    #[inline(never)]
    fn push(
        &self,
        counts: Mask8,
        t: F32x8,
        [u, v]: [F32x8; 2],
        prim_id: U32x8,
    ) -> HitRecord<F32x8> {
        let mut best = self.next.best;
        for lane in counts.lanes() {
            let list = &mut self.hits.borrow_mut()[lane];
            list.push(FoundHit {
                ray: lane as u32,
                t: t.lane(lane),
                u: u.lane(lane),
                v: v.lane(lane),
                prim_id: prim_id.lane(lane),
            });
            if list.len() == 2 * self.most {
                let (_, last, _) = list.select_nth_unstable_by_key(self.most - 1, FoundHit::key);
                best.t.set_lane(lane, last.t);
                best.prim_id.set_lane(lane, last.prim_id);
                list.truncate(self.most);
            }
        }
        best
    }
}

impl Query<F32x8> for NextHits<'_> {
    const FRONT_TO_BACK: bool = true;

    #[inline(always)]
    fn limit(&self) -> F32x8 {
        self.next.limit()
    }

    #[inline(always)]
    fn overlaps(&self, interval: &TInterval<F32x8>) -> Mask8 {
        self.next.overlaps(interval)
    }

    #[inline(always)]
    fn enter_instance(&self, interval: &TInterval<F32x8>, id_offset: u32) -> Option<Self> {
        let next = self.next.enter_instance(interval, id_offset)?;
        Some(NextHits { next, ..*self })
    }

    #[inline(always)]
    fn update(&mut self, hit: &HitCandidate<F32x8>, id: u32) -> bool {
        let (hit, id) = self.next.later(hit, id);
        let counts = hit.valid & self.next.best.is_after(hit.t, id);
        if counts.any() {
            self.next.best = self.push(counts, hit.t, [hit.v / hit.det, hit.w / hit.det], id);
        }
        false
    }

    /// Hits and limits are already in the world's distances and numbers.
    #[inline(always)]
    fn exit_instance(&mut self, inner: Self, _: &TInterval<F32x8>, _: u32) -> bool {
        let (best, inside) = (&mut self.next.best, inner.next.best);
        let entered = inside.t.gt(inactive_t());
        best.t = entered.select(inside.t, best.t);
        best.prim_id = entered.select_u32(inside.prim_id, best.prim_id);
        false
    }
}
