//! Queries of single rays: the closest hit, any hit or every hit.

use super::ray_state::{RayState, SingleHit};
use crate::bvh::LeafKind;
use crate::intersect::hit::{HitCandidate, inactive_t};
use crate::intersect::ray_setup::RaySetup;
use crate::simd::{F32x8, LaneMask, Lanes, Mask8, NATIVE, Native};
use crate::traverse::counters::Counters;
use crate::traverse::every_hit::{EveryHit, FoundHit, FoundHits};
use crate::traverse::filtered_hit::{FilteredHit, HitFilter};
use crate::traverse::packet::PacketKernel;
use crate::traverse::query::{AnyHit, ClosestHit, Query};
use std::ops::Range;

/// Query of a ray.
pub(super) trait SingleQuery: Copy {
    /// True if near nodes should be visited first.
    const FRONT_TO_BACK: bool;
    /// True if the far side of a sphere may count where the near side is hit.
    const FAR_SIDES: bool = false;

    /// Accepts the hits of a block's primitives; true if the ray's limit is nearer than before.
    fn update(self, state: &mut RayState, hit: &HitCandidate<Native>, ids: &[u32; NATIVE]) -> bool;

    /// Accepts the packet tests' hits in a leaf without blocks, for a ray in the first lane; true
    /// as above.
    fn other<T: Counters>(self, state: &mut RayState, leaf: LoneLeaf<'_, '_, T>) -> bool;
}

/// A leaf without blocks, and a ray in the first lane.
pub(super) struct LoneLeaf<'k, 'a, T> {
    pub(super) packets: &'k mut PacketKernel<'a, F32x8, T>,
    pub(super) ray: RaySetup<F32x8>,
    pub(super) kind: LeafKind,
    pub(super) slots: Range<usize>,
}

impl<T: Counters> LoneLeaf<'_, '_, T> {
    fn test(self, query: &mut impl Query<F32x8>) {
        self.packets
            .intersect_leaf(&self.ray, query, self.kind, self.slots, 0);
    }
}

/// The lane of the ray.
fn first_lane() -> Mask8 {
    Mask8::first(1)
}

/// The ray's limit in its lane.
fn limit(state: &RayState) -> F32x8 {
    first_lane().select(F32x8::splat(state.best.t), inactive_t())
}

/// Passes `take` each hit of a block that precedes the ray's best, by (t, prim_id), and the number
/// of the ray; the hit that it returns, if any, becomes the best. Returns false if no hit is near.
#[inline(always)]
fn take_nearer(
    state: &mut RayState,
    hit: &HitCandidate<Native>,
    ids: &[u32; NATIVE],
    take: impl Fn(usize, SingleHit) -> Option<SingleHit>,
) -> bool {
    let near = hit.valid & hit.t.le(Native::splat(state.best.t));
    if !near.any() {
        return false;
    }
    let [t, v, w, det] = [hit.t, hit.v, hit.w, hit.det].map(Native::to_array);
    for lane in near.lanes() {
        let id = ids[lane];
        if t[lane] < state.best.t || (t[lane] == state.best.t && id < state.best.prim_id) {
            let nearer = SingleHit {
                t: t[lane],
                v: v[lane],
                w: w[lane],
                det: det[lane],
                prim_id: id,
            };
            state.best = take(state.number, nearer).unwrap_or(state.best);
        }
    }
    true
}

/// The closest hit; among equally close ones, the one with the smallest number.
#[derive(Clone, Copy)]
pub(super) struct SingleClosest;

impl SingleQuery for SingleClosest {
    const FRONT_TO_BACK: bool = true;

    #[inline(always)]
    fn update(self, state: &mut RayState, hit: &HitCandidate<Native>, ids: &[u32; NATIVE]) -> bool {
        take_nearer(state, hit, ids, |_, nearer| Some(nearer))
    }

    #[inline(always)]
    fn other<T: Counters>(self, state: &mut RayState, leaf: LoneLeaf<'_, '_, T>) -> bool {
        let mut query = ClosestHit {
            best: state.best.spread(limit(state)),
        };
        leaf.test(&mut query);
        state.best = SingleHit::of(&query.best);
        true
    }
}

/// Any hit.
#[derive(Clone, Copy)]
pub(super) struct SingleAny;

impl SingleQuery for SingleAny {
    const FRONT_TO_BACK: bool = false;

    #[inline(always)]
    fn update(self, state: &mut RayState, hit: &HitCandidate<Native>, _: &[u32; NATIVE]) -> bool {
        if (hit.valid & hit.t.lt(Native::splat(state.best.t))).any() {
            state.mark_occluded();
        }
        false
    }

    #[inline(always)]
    fn other<T: Counters>(self, state: &mut RayState, leaf: LoneLeaf<'_, '_, T>) -> bool {
        let mut query = AnyHit::new(limit(state), first_lane());
        leaf.test(&mut query);
        if query.occluded().any() {
            state.mark_occluded();
        }
        false
    }
}

/// The closest hit that a filter accepts.
#[derive(Clone, Copy)]
pub(super) struct SingleFiltered<'f>(pub(super) &'f HitFilter<'f>);

impl SingleQuery for SingleFiltered<'_> {
    const FRONT_TO_BACK: bool = true;
    const FAR_SIDES: bool = true;

    #[inline(always)]
    fn update(self, state: &mut RayState, hit: &HitCandidate<Native>, ids: &[u32; NATIVE]) -> bool {
        take_nearer(state, hit, ids, |ray, nearer| {
            let accepted = (self.0.accept)(ray, nearer.weights(), nearer.prim_id);
            accepted.then(|| SingleHit {
                t: self.0.limit_after(nearer.t),
                ..nearer
            })
        })
    }

    #[inline(always)]
    fn other<T: Counters>(self, state: &mut RayState, leaf: LoneLeaf<'_, '_, T>) -> bool {
        let best = state.best.spread(limit(state));
        let mut query = FilteredHit::new(best, state.number, self.0);
        leaf.test(&mut query);
        state.best = SingleHit::of(&query.best());
        true
    }
}

/// Every hit.
#[derive(Clone, Copy)]
pub(super) struct SingleEvery<'f>(pub(super) &'f FoundHits);

impl SingleQuery for SingleEvery<'_> {
    const FRONT_TO_BACK: bool = false;

    #[inline(always)]
    fn update(self, state: &mut RayState, hit: &HitCandidate<Native>, ids: &[u32; NATIVE]) -> bool {
        let counts = hit.valid & hit.t.lt(Native::splat(state.best.t));
        if counts.any() {
            let weights = [hit.v / hit.det, hit.w / hit.det];
            let (t, [u, v]) = (hit.t.to_array(), weights.map(Native::to_array));
            let hits = counts.lanes().map(|lane| FoundHit {
                ray: state.number as u32,
                t: t[lane],
                u: u[lane],
                v: v[lane],
                prim_id: ids[lane],
            });
            self.0.borrow_mut().extend(hits);
        }
        false
    }

    #[inline(always)]
    fn other<T: Counters>(self, state: &mut RayState, leaf: LoneLeaf<'_, '_, T>) -> bool {
        leaf.test(&mut EveryHit::new(limit(state), state.number, self.0));
        false
    }
}
