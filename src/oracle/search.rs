//! The search for hits among the objects of the world, instances included: through trees, or one
//! object after the other. `trace::intersect::instance` explains why no hit on an instance is lost.

use super::instance::{instance_boxes, to_object, world_objects};
use super::intersect::{
    OracleHit, OracleInterval, OracleRay, OracleRaySetup, is_after, max, min, update_next,
};
use super::tree::TwoLevelBvh;
use phalanx_scene::{Bounds, NO_PRIM, Scene};
use std::borrow::Cow;
use std::cell::Cell;

/// Search method of the oracle. Both give the same bits.
#[derive(Clone, Copy, Debug)]
pub enum OracleSearch<'a> {
    /// Search through trees.
    Tree(&'a TwoLevelBvh),
    /// Test of every primitive, for small scenes: the reference for any tree.
    BruteForce,
}

/// Before every hit: no number follows this one.
pub(super) const START: OracleHit = OracleHit {
    prim_id: NO_PRIM,
    t: 0.0,
    u: 0.0,
    v: 0.0,
};

/// A scene and its search method.
pub(super) struct SceneSearch<'a> {
    pub(super) scene: &'a Scene,
    search: OracleSearch<'a>,
    /// Padded boxes of the instances.
    instance_boxes: Cow<'a, [Bounds]>,
    /// True if the scene has surfaces that are partly transparent, invisible from behind, or let
    /// light through.
    pub(super) has_coverage: bool,
    pub(super) has_unseen_backs: bool,
    pub(super) has_clear_shadows: bool,
    /// Backs that rays have passed.
    pub(super) unseen_backs: Cell<u64>,
}

impl<'a> SceneSearch<'a> {
    pub(super) fn new(scene: &'a Scene, search: OracleSearch<'a>) -> SceneSearch<'a> {
        let instance_boxes = match search {
            OracleSearch::Tree(bvh) => Cow::Borrowed(bvh.instance_boxes()),
            OracleSearch::BruteForce => Cow::Owned(instance_boxes(scene)),
        };
        SceneSearch {
            scene,
            search,
            instance_boxes,
            has_coverage: scene.has_coverage(),
            has_unseen_backs: scene.has_unseen_backs(),
            has_clear_shadows: scene.has_clear_shadows(),
            unseen_backs: Cell::new(0),
        }
    }

    /// The closest hit with 0 < t, ties going to the smaller prim_id.
    pub(super) fn closest(&self, ray: &OracleRay) -> Option<OracleHit> {
        let setup = OracleRaySetup::new(ray);
        self.closest_object(&setup, 0.0, |object, best| {
            self.update_closest(&setup, object, best);
        })
    }

    /// Passes `closer` the objects of the world that may be hit from a distance on, and before the
    /// best hit so far, which it sets; returns the last best.
    fn closest_object(
        &self,
        setup: &OracleRaySetup,
        from: f32,
        mut closer: impl FnMut(u32, &mut Option<OracleHit>),
    ) -> Option<OracleHit> {
        let mut best = None;
        match self.search {
            OracleSearch::Tree(bvh) => {
                (bvh.world()).closest(setup, from..f32::INFINITY, &mut best, closer);
            }
            OracleSearch::BruteForce => {
                world_objects(self.scene).for_each(|object| closer(object, &mut best));
            }
        }
        best
    }

    /// The first hit after another, by (t, prim_id).
    pub(super) fn closest_after(&self, ray: &OracleRay, after: &OracleHit) -> Option<OracleHit> {
        self.hits_after::<false>(ray, after, |hit, best| update_next(hit, after, best))
    }

    /// All hits after another, in the order of (t, prim_id); with `FAR_SIDES`, every point at which
    /// a ray crosses a surface: of curved primitives both sides.
    pub(super) fn all_after<const FAR_SIDES: bool>(
        &self,
        ray: &OracleRay,
        after: &OracleHit,
    ) -> Vec<OracleHit> {
        let mut all = Vec::new();
        // There is never a best hit, so that nothing ends the search early.
        self.hits_after::<FAR_SIDES>(ray, after, |hit, _| {
            all.extend(is_after(&hit, after).then_some(hit));
        });
        all.sort_unstable_by_key(|hit| (hit.t.to_bits(), hit.prim_id));
        all
    }

    /// Passes `take` the hits of which one may come after `after`, and before the best so far,
    /// which it sets; returns the last best. With `FAR_SIDES`, a curved primitive may be hit twice.
    fn hits_after<const FAR_SIDES: bool>(
        &self,
        ray: &OracleRay,
        after: &OracleHit,
        mut take: impl FnMut(OracleHit, &mut Option<OracleHit>),
    ) -> Option<OracleHit> {
        let setup = OracleRaySetup::new(ray);
        self.closest_object(&setup, after.t, |object, best| {
            self.object_hits_after::<FAR_SIDES>(&setup, object, after, best, &mut take);
        })
    }

    /// Passes `take` the hits of one object.
    fn object_hits_after<const FAR_SIDES: bool>(
        &self,
        setup: &OracleRaySetup,
        object: u32,
        after: &OracleHit,
        best: &mut Option<OracleHit>,
        mut take: impl FnMut(OracleHit, &mut Option<OracleHit>),
    ) {
        let Some(instance) = object.checked_sub(self.scene.prim_count() as u32) else {
            for hit in setup.hits::<FAR_SIDES>(self.scene, object) {
                take(hit, best);
            }
            return;
        };
        let instance = instance as usize;
        let Some(interval) = self.interval_in(instance, setup) else {
            return;
        };
        let (mesh, inner) = self.enter(instance, setup);
        let first_id = self.scene.instance_first_id(instance);
        let mut next = |prim: u32, best: &mut Option<OracleHit>| {
            let prim_id = first_id + (prim - self.scene.meshes.first[mesh]);
            for hit in inner.hits::<FAR_SIDES>(self.scene, prim) {
                let t = min(max(hit.t, interval.tnear), interval.tfar);
                if t > 0.0 && t < f32::INFINITY {
                    take(OracleHit { t, prim_id, ..hit }, best);
                }
            }
        };
        match self.search {
            OracleSearch::Tree(bvh) => {
                // Hits inside count by their clamped distances: beyond the end of the interval, any
                // of them may matter.
                let within = |best: &Option<OracleHit>| best.filter(|b| b.t < interval.tfar);
                let mut nearest = within(best);
                let limit = nearest.map_or(f32::INFINITY, |b| b.t);
                // A hit before the instance's box counts as one where the ray enters it.
                let near = if interval.tnear < after.t { after.t } else { f32::NEG_INFINITY };
                let tree = bvh.mesh(mesh);
                tree.closest(&inner, near..limit, &mut nearest, |prim, nearest| {
                    next(prim, best);
                    *nearest = within(best);
                });
            }
            OracleSearch::BruteForce => {
                for prim in self.scene.meshes.prims(mesh) {
                    next(prim, best);
                }
            }
        }
    }

    /// Returns true if anything is hit with 0 < t < `tmax`.
    pub(super) fn occluded(&self, ray: &OracleRay, tmax: f32) -> bool {
        let setup = OracleRaySetup::new(ray);
        let blocks = |object| self.is_hit(&setup, object, tmax);
        match self.search {
            OracleSearch::Tree(bvh) => bvh.world().any(&setup, tmax, blocks),
            OracleSearch::BruteForce => world_objects(self.scene).any(blocks),
        }
    }

    /// Replaces `best` if the hit on this object is closer, or equally close with a smaller number.
    fn update_closest(&self, setup: &OracleRaySetup, object: u32, best: &mut Option<OracleHit>) {
        match object.checked_sub(self.scene.prim_count() as u32) {
            None => setup.update_closest(self.scene, object, best),
            Some(_) => self.object_hits_after::<false>(setup, object, &START, best, |hit, best| {
                update_next(hit, &START, best);
            }),
        }
    }

    /// Interval of a ray in an instance's box; none if it does not cross it ahead of its origin.
    fn interval_in(&self, instance: usize, setup: &OracleRaySetup) -> Option<OracleInterval> {
        let interval = setup.intersect_box(&self.instance_boxes[instance]);
        // As in `trace`: an interval with a NaN is empty.
        (interval.tnear <= interval.tfar && interval.tfar > 0.0).then_some(interval)
    }

    /// The mesh of an instance, and the ray in its space.
    fn enter(&self, instance: usize, setup: &OracleRaySetup) -> (usize, OracleRaySetup) {
        let mesh = self.scene.instances.mesh[instance] as usize;
        let inner = OracleRaySetup::new(&to_object(self.scene, instance, &setup.ray));
        (mesh, inner)
    }

    /// Returns true if the object is hit before `tmax`.
    fn is_hit(&self, setup: &OracleRaySetup, object: u32, tmax: f32) -> bool {
        let Some(instance) = object.checked_sub(self.scene.prim_count() as u32) else {
            let hit = setup.hit::<false>(self.scene, object);
            return hit.is_some_and(|hit| hit.t < tmax);
        };
        let instance = instance as usize;
        let interval = self.interval_in(instance, setup);
        let Some(interval) = interval.filter(|interval| interval.tnear < tmax) else {
            return false;
        };
        let (mesh, inner) = self.enter(instance, setup);
        // Beyond the interval a hit is clamped to its end.
        let limit = if interval.tfar < tmax { f32::INFINITY } else { tmax };
        let blocks = |prim| {
            let hit = inner.hit::<false>(self.scene, prim);
            hit.is_some_and(|hit| hit.t < limit)
        };
        match self.search {
            OracleSearch::Tree(bvh) => bvh.mesh(mesh).any(&inner, limit, blocks),
            OracleSearch::BruteForce => self.scene.meshes.prims(mesh).any(blocks),
        }
    }
}
