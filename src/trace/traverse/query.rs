//! Queries of a traversal, the closest hit or any hit, and their work in a leaf.

use super::leaf_slots::slots_of;
use crate::bvh::leaf::LeafTriangle;
use crate::bvh::{Bvh, LeafKind};
use crate::intersect::aabb::{REACH, TInterval};
use crate::intersect::hit::{HitCandidate, HitRecord, inactive_t};
use crate::intersect::instance;
use crate::intersect::leaf_prim::LeafPrim;
use crate::intersect::ray_setup::RaySetup;
use crate::intersect::shear::MIXED;
use crate::intersect::triangle::TriangleAlong;
use crate::packet::{HitPacket, NO_PRIM};
use crate::simd::{LaneMask, LaneU32, Lanes};
use bytemuck::TransparentWrapper;
use phalanx_scene::PrimKind;
use std::ops::Range;

/// Query of a traversal.
pub(super) trait Query<L: Lanes>: Copy {
    /// True if near leaves should be visited first; not needed for any hit.
    const FRONT_TO_BACK: bool;
    /// True if meshes of instances have inlined traversals, too; not needed for what is rare.
    const OFTEN: bool = false;
    /// True if the far side of a primitive may count where the near side is hit.
    const FAR_SIDES: bool = false;
    /// Limit of each ray's search.
    fn limit(&self) -> L;
    /// Distance up to which each ray enters boxes.
    #[inline(always)]
    fn reach(&self) -> L {
        self.limit() * L::splat(REACH)
    }
    /// Lanes whose ray may find something in a box that it crosses in `interval`.
    #[inline(always)]
    fn overlaps(&self, interval: &TInterval<L>) -> L::Mask {
        interval.overlaps(self.reach())
    }
    /// The query within an instance, whose box the rays cross in `interval`, and whose primitives'
    /// numbers are larger by `id_offset`; none if nothing inside can matter.
    fn enter_instance(&self, interval: &TInterval<L>, id_offset: u32) -> Option<Self>
    where
        Self: Sized;
    /// Accepts a hit in the lanes in which it counts; returns true if there is any.
    fn update(&mut self, hit: &HitCandidate<L>, id: u32) -> bool;
    /// Takes over the result of the query within an instance; true ends the traversal.
    fn exit_instance(&mut self, inner: Self, interval: &TInterval<L>, id_offset: u32) -> bool;
    /// The best hits before an instance that has been searched with this result, if the result is
    /// clamped. Others may tie with it then, which shows in distances of the world.
    #[inline(always)]
    fn tied(&self, _: &Self, _: &TInterval<L>) -> Option<HitRecord<L>> {
        None
    }
    /// Takes over the best hits by those distances.
    #[inline(always)]
    fn take_tied(&mut self, _: HitRecord<L>) {}
    /// Tests primitives; true ends the traversal.
    #[inline(always)]
    fn test_each<P: LeafPrim>(&mut self, rays: &RaySetup<L>, prims: &[P]) -> bool {
        for prim in prims {
            if let Some(hit) = prim.intersect::<L, false>(rays, self.limit()) {
                self.update(&hit, prim.prim_id());
                if Self::FAR_SIDES
                    && let Some(hit) = prim.intersect::<L, true>(rays, self.limit())
                {
                    self.update(&hit, prim.prim_id());
                }
            }
        }
        false
    }

    /// Tests triangles by the axis of the rays; true ends the traversal.
    #[inline(always)]
    fn test_triangles(&mut self, rays: &RaySetup<L>, prims: &[LeafTriangle]) -> bool {
        match rays.shear.axis {
            0 => self.test_each(rays, TriangleAlong::<0>::wrap_slice(prims)),
            1 => self.test_each(rays, TriangleAlong::<1>::wrap_slice(prims)),
            2 => self.test_each(rays, TriangleAlong::<2>::wrap_slice(prims)),
            _ => self.test_each(rays, TriangleAlong::<MIXED>::wrap_slice(prims)),
        }
    }

    /// Tests the primitives of a leaf; true ends the traversal.
    #[inline(always)]
    fn intersect_leaf<const NO_CONES_OR_INSTANCES: bool>(
        &mut self,
        bvh: &Bvh,
        rays: &RaySetup<L>,
        kind: LeafKind,
        slots: Range<usize>,
    ) -> bool {
        match kind {
            LeafKind::Prim(PrimKind::Triangle) => {
                self.test_triangles(rays, slots_of(&bvh.leaf_prims().triangles, slots))
            }
            LeafKind::Prim(PrimKind::Sphere) => {
                self.test_each(rays, slots_of(&bvh.leaf_prims().spheres, slots))
            }
            LeafKind::Prim(PrimKind::Ellipsoid) => {
                self.test_each(rays, slots_of(&bvh.leaf_prims().ellipsoids, slots))
            }
            LeafKind::Prim(PrimKind::Cone) if !NO_CONES_OR_INSTANCES => {
                // A copy: a value whose address is passed to a call no longer stays in registers.
                let mut query = *self;
                let done = query.call_leaf(bvh, rays, PrimKind::Cone, slots);
                *self = query;
                done
            }
            // The traversal itself enters instances.
            LeafKind::Prim(PrimKind::Cone) | LeafKind::Instance => false,
        }
    }

    /// As [`Query::intersect_leaf`], in any tree, by a call.
    #[inline(never)]
    fn call_leaf(
        &mut self,
        bvh: &Bvh,
        rays: &RaySetup<L>,
        kind: PrimKind,
        slots: Range<usize>,
    ) -> bool {
        let prims = bvh.leaf_prims();
        match kind {
            PrimKind::Triangle => self.test_each(rays, slots_of(&prims.triangles, slots)),
            PrimKind::Sphere => self.test_each(rays, slots_of(&prims.spheres, slots)),
            PrimKind::Ellipsoid => self.test_each(rays, slots_of(&prims.ellipsoids, slots)),
            PrimKind::Cone => self.test_each(rays, slots_of(&prims.cones, slots)),
        }
    }
}

#[derive(Clone, Copy)]
pub(super) struct ClosestHit<L: Lanes> {
    pub(super) best: HitRecord<L>,
}

#[derive(Clone, Copy)]
pub(super) struct AnyHit<L: Lanes> {
    limit: L,
    occluded: L::Mask,
    active: u32,
}

impl<L: Lanes> ClosestHit<L> {
    /// A query for hits closer than `limit`.
    #[inline(always)]
    pub(super) fn new(limit: L) -> ClosestHit<L> {
        ClosestHit {
            best: HitRecord::before(limit),
        }
    }

    /// Returns true if there is any hit, for a query without a limit.
    #[inline(always)]
    pub(super) fn has_hit(&self) -> bool {
        let t = self.best.t;
        (t.gt(inactive_t()) & t.lt(L::splat(f32::INFINITY))).any()
    }

    /// The hits below `tmax`.
    #[inline(always)]
    pub(super) fn hits(&self, tmax: L, active: L::Mask) -> HitPacket<L> {
        self.best.hits(tmax, active)
    }
}

impl<L: Lanes> Query<L> for ClosestHit<L> {
    const FRONT_TO_BACK: bool = true;
    const OFTEN: bool = true;
    #[inline(always)]
    fn limit(&self) -> L {
        self.best.t
    }

    #[inline(always)]
    fn enter_instance(&self, interval: &TInterval<L>, _: u32) -> Option<ClosestHit<L>> {
        let limit = instance::closest_limit(self.best.t, interval);
        limit.gt(inactive_t()).any().then(|| ClosestHit {
            best: HitRecord {
                t: limit,
                // The smallest number wins a tie, so this one loses it: a hit at the limit may win
                // outside.
                prim_id: L::U32::splat(NO_PRIM),
                ..self.best
            },
        })
    }

    #[inline(always)]
    fn tied(&self, inner: &Self, interval: &TInterval<L>) -> Option<HitRecord<L>> {
        let ClosestHit { best: hits } = inner;
        let clamped = hits.t.lt(interval.tnear) | !hits.t.lt(interval.tfar);
        let met = clamped & !hits.prim_id.eq(L::U32::splat(NO_PRIM));
        met.any().then_some(self.best)
    }

    #[inline(always)]
    fn take_tied(&mut self, best: HitRecord<L>) {
        self.best = best;
    }

    #[inline(always)]
    fn update(&mut self, hit: &HitCandidate<L>, id: u32) -> bool {
        self.best.update(hit, L::U32::splat(id)).any()
    }

    #[inline(always)]
    fn exit_instance(
        &mut self,
        inner: ClosestHit<L>,
        interval: &TInterval<L>,
        id_offset: u32,
    ) -> bool {
        let hits = inner.best;
        let id = hits.prim_id.wrapping_add(L::U32::splat(id_offset));
        let (met, t) = instance::to_world(hits.t, interval);
        let hit = met & !hits.prim_id.eq(L::U32::splat(NO_PRIM));
        self.best.update(&hits.candidate(hit, t), id);
        false
    }
}

impl<L: Lanes> Query<L> for AnyHit<L> {
    const FRONT_TO_BACK: bool = false;
    const OFTEN: bool = true;
    #[inline(always)]
    fn limit(&self) -> L {
        self.limit
    }

    #[inline(always)]
    fn enter_instance(&self, interval: &TInterval<L>, _: u32) -> Option<AnyHit<L>> {
        let limit = instance::any_hit_limit(self.limit, interval);
        let live = limit.gt(inactive_t()).bits();
        (live != 0).then(|| AnyHit {
            limit,
            occluded: L::Mask::none(),
            active: live,
        })
    }

    #[inline(always)]
    fn update(&mut self, hit: &HitCandidate<L>, _: u32) -> bool {
        let hits = hit.valid & hit.t.lt(self.limit);
        self.mark_occluded(hits);
        hits.any()
    }

    #[inline(always)]
    fn exit_instance(&mut self, inner: AnyHit<L>, _: &TInterval<L>, _: u32) -> bool {
        self.mark_occluded(inner.occluded)
    }

    #[inline(always)]
    fn test_each<P: LeafPrim>(&mut self, rays: &RaySetup<L>, prims: &[P]) -> bool {
        let mut hits = L::Mask::none();
        for prim in prims {
            if let Some(hit) = prim.intersect::<L, false>(rays, self.limit) {
                hits = hits | (hit.valid & hit.t.lt(self.limit));
            }
        }
        self.mark_occluded(hits)
    }
}

impl<L: Lanes> AnyHit<L> {
    #[inline(always)]
    pub(super) fn new(limit: L, active: L::Mask) -> AnyHit<L> {
        AnyHit {
            limit,
            occluded: L::Mask::none(),
            active: active.bits(),
        }
    }

    /// Lanes that hit anything.
    #[inline(always)]
    pub(super) fn occluded(&self) -> L::Mask {
        self.occluded
    }

    /// Lanes that hit nothing.
    #[inline(always)]
    pub(super) fn unoccluded(&self) -> L::Mask {
        L::Mask::from_bits(self.active) & !self.occluded
    }

    /// Marks occluded lanes as done, like lanes without a ray; returns true if all are.
    #[inline(always)]
    fn mark_occluded(&mut self, hits: L::Mask) -> bool {
        self.occluded = self.occluded | hits;
        self.limit = hits.select(inactive_t(), self.limit);
        self.occluded.bits() == self.active
    }
}
