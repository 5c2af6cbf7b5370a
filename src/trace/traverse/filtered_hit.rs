//! The query for the closest hit that a filter accepts, for a ray in the first lane.

use super::next_hit::NextHit;
use super::query::Query;
use crate::intersect::aabb::TInterval;
use crate::intersect::hit::{HitCandidate, HitRecord, inactive_t};
use crate::packet::NO_PRIM;
use crate::simd::{F32x8, LaneMask, LaneU32, Lanes, U32x8};

/// Filter of rays' hits.
#[derive(Clone, Copy)]
pub(crate) struct HitFilter<'f> {
    /// Decides by the number of the ray, and the distance, barycentric weights and number of the
    /// hit. Called only for hits that would be the closest so far, and for the far side of a curved
    /// primitive after the near side.
    pub(crate) accept: &'f dyn Fn(usize, [f32; 3], u32) -> bool,
    /// True if the first accepted hit ends the search.
    pub(crate) any: bool,
}

impl HitFilter<'_> {
    /// Limit of the search after an accepted hit at `t`.
    #[inline(always)]
    pub(super) fn limit_after(&self, t: f32) -> f32 {
        if self.any { f32::NEG_INFINITY } else { t }
    }
}

/// The closest accepted hit; distances and numbers are those in the world, also within an instance.
#[derive(Clone, Copy)]
pub(super) struct FilteredHit<'f> {
    next: NextHit<F32x8>,
    ray: usize,
    filter: &'f HitFilter<'f>,
}

impl<'f> FilteredHit<'f> {
    /// A query of one ray for hits before that of `best`, which is inactive in all lanes but the
    /// first.
    pub(super) fn new(
        best: HitRecord<F32x8>,
        ray: usize,
        filter: &'f HitFilter<'f>,
    ) -> FilteredHit<'f> {
        let mut next = NextHit::new(inactive_t(), F32x8::ZERO, U32x8::splat(NO_PRIM));
        next.best = best;
        FilteredHit { next, ray, filter }
    }

    /// The best hit so far.
    pub(super) fn best(&self) -> HitRecord<F32x8> {
        self.next.best
    }
}

impl Query<F32x8> for FilteredHit<'_> {
    const FRONT_TO_BACK: bool = true;
    const FAR_SIDES: bool = true;

    #[inline(always)]
    fn limit(&self) -> F32x8 {
        self.next.limit()
    }

    #[inline(always)]
    fn enter_instance(&self, interval: &TInterval<F32x8>, id_offset: u32) -> Option<Self> {
        let next = self.next.enter_instance(interval, id_offset)?;
        Some(FilteredHit { next, ..*self })
    }

    #[inline(always)]
    fn update(&mut self, hit: &HitCandidate<F32x8>, id: u32) -> bool {
        let (hit, id) = self.next.later(hit, id);
        let counts = hit.valid & self.next.best.is_after(hit.t, id);
        if counts.bits() & 1 == 1 {
            let weights = [hit.t, hit.v / hit.det, hit.w / hit.det].map(|lanes| lanes.lane(0));
            if (self.filter.accept)(self.ray, weights, id.lane(0)) {
                self.next.best.update(&hit, id);
                let limit = self.filter.limit_after(weights[0]);
                self.next.best.t.set_lane(0, limit);
            }
        }
        false
    }

    /// Hits are already in the world's distances and numbers.
    #[inline(always)]
    fn exit_instance(&mut self, inner: Self, _: &TInterval<F32x8>, _: u32) -> bool {
        self.next.best = inner.next.best;
        false
    }
}
