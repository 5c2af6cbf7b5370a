//! The query for all hits of a ray, in one traversal.
//!
//! Nothing ends the search before the limit, so the order of nodes does not matter, and every box
//! along the ray is entered once. Each primitive is in one leaf of its tree, so it is tested once.
//! [`instance`] documents which hits count within instances.

use super::query::Query;
use crate::intersect::aabb::TInterval;
use crate::intersect::hit::{HitCandidate, inactive_t};
use crate::intersect::instance;
use crate::simd::{LANES, LaneMask, Lanes};
use std::cell::RefCell;

/// One of a ray's hits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FoundHit {
    /// Number of the ray in its queue.
    pub(crate) ray: u32,
    pub(crate) t: f32,
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) prim_id: u32,
}

impl FoundHit {
    /// A key that sorts the hits of a ray by (t, prim_id): positive floats sort like their bits.
    pub(crate) fn key(&self) -> u64 {
        FoundHit::key_of(self.t, self.prim_id)
    }

    /// The key of a hit by its distance and its primitive.
    pub(crate) fn key_of(t: f32, prim_id: u32) -> u64 {
        u64::from(t.to_bits()) << 32 | u64::from(prim_id)
    }
}

/// Unordered hits of a queue's rays, shared by copies of a query.
pub(super) type FoundHits = RefCell<Vec<FoundHit>>;

/// All hits before a limit, in the order of discovery. Distances and numbers are those in the
/// world, also within an instance.
#[derive(Clone, Copy)]
pub(super) struct EveryHit<'f, L: Lanes> {
    limit: L,
    /// Interval in the box of the instance whose mesh is searched.
    interval: TInterval<L>,
    /// Offset of the numbers of the instance's primitives.
    id_offset: u32,
    /// Number of the ray in the first lane.
    first_ray: usize,
    hit_list: &'f FoundHits,
}

impl<'f, L: Lanes> EveryHit<'f, L> {
    /// A query for hits before `limit`, in lanes that are not inactive, of rays that are numbered
    /// from `first_ray` on.
    pub(super) fn new(limit: L, first_ray: usize, hit_list: &'f FoundHits) -> EveryHit<'f, L> {
        EveryHit {
            limit,
            interval: TInterval::everywhere(),
            id_offset: 0,
            first_ray,
            hit_list,
        }
    }

    #[inline(never)]
    fn push(&self, lanes: L::Mask, t: L, [u, v]: [L; 2], prim_id: u32) {
        let mut hit_list = self.hit_list.borrow_mut();
        for k in 0..L::PACKETS {
            let [t, u, v] = [t, u, v].map(|lanes| lanes.octet(k));
            let octet = lanes.bits() >> (k * LANES) & 0xff;
            let hits = (0..LANES).filter(|lane| octet >> lane & 1 == 1);
            hit_list.extend(hits.map(|lane| FoundHit {
                ray: (self.first_ray + k * LANES + lane) as u32,
                t: t.lane(lane),
                u: u.lane(lane),
                v: v.lane(lane),
                prim_id,
            }));
        }
    }
}

impl<L: Lanes> Query<L> for EveryHit<'_, L> {
    const FRONT_TO_BACK: bool = false;

    #[inline(always)]
    fn limit(&self) -> L {
        instance::unclamped_limit(self.limit, &self.interval)
    }

    #[inline(always)]
    fn enter_instance(&self, interval: &TInterval<L>, id_offset: u32) -> Option<Self> {
        let reached = instance::closest_limit(self.limit, interval).gt(inactive_t());
        reached.any().then(|| EveryHit {
            limit: reached.select(self.limit, inactive_t()),
            interval: *interval,
            id_offset,
            ..*self
        })
    }

    #[inline(always)]
    fn update(&mut self, hit: &HitCandidate<L>, id: u32) -> bool {
        let t = hit.t.max(self.interval.tnear).min(self.interval.tfar);
        let counts = hit.valid & t.gt(L::ZERO) & t.lt(self.limit);
        if counts.any() {
            let weights = [hit.v / hit.det, hit.w / hit.det];
            self.push(counts, t, weights, id.wrapping_add(self.id_offset));
        }
        false
    }

    /// Hits are already in the world's distances and numbers.
    #[inline(always)]
    fn exit_instance(&mut self, _: Self, _: &TInterval<L>, _: u32) -> bool {
        false
    }
}
