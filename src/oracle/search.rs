//! The search for hits among the objects of the world, instances among them: through trees, or one
//! object after the other. The argument why no instance's hit is lost stands in
//! `trace::intersect::instance`.

use super::instance::{instance_boxes, to_object, world_objects};
use super::intersect::{OracleHit, OracleRay, OracleRaySetup, max, min};
use super::tree::TwoLevelBvh;
use phalanx_scene::{Bounds, Scene};
use std::borrow::Cow;

/// Search method of the oracle. Both give the same bits.
#[derive(Clone, Copy, Debug)]
pub enum OracleSearch<'a> {
    /// Search through trees.
    Tree(&'a TwoLevelBvh),
    /// Test of every primitive, for small scenes: the reference for any tree.
    BruteForce,
}

/// A scene with the method by which it is searched.
pub(super) struct SceneSearch<'a> {
    pub(super) scene: &'a Scene,
    search: OracleSearch<'a>,
    /// Padded boxes of the instances.
    instance_boxes: Cow<'a, [Bounds]>,
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
        }
    }

    /// The closest hit with 0 < t, ties going to the smaller prim_id.
    pub(super) fn closest(&self, ray: &OracleRay) -> Option<OracleHit> {
        let setup = OracleRaySetup::new(ray);
        let mut best = None;
        match self.search {
            OracleSearch::Tree(bvh) => {
                let closer = |object, best: &mut Option<OracleHit>| {
                    self.update_closest(&setup, object, best)
                };
                bvh.world()
                    .closest(&setup, f32::INFINITY, &mut best, closer);
            }
            OracleSearch::BruteForce => {
                for object in world_objects(self.scene) {
                    self.update_closest(&setup, object, &mut best);
                }
            }
        }
        best
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

    /// Replaces `best` if the object is hit closer, or as close with a smaller number.
    fn update_closest(&self, setup: &OracleRaySetup, object: u32, best: &mut Option<OracleHit>) {
        match object.checked_sub(self.scene.prim_count() as u32) {
            None => setup.update_closest(self.scene, object, best),
            Some(instance) => self.update_closest_in(instance as usize, setup, best),
        }
    }

    fn update_closest_in(
        &self,
        instance: usize,
        setup: &OracleRaySetup,
        best: &mut Option<OracleHit>,
    ) {
        let interval = setup.intersect_box(&self.instance_boxes[instance]);
        // As in `trace`: an interval with a NaN holds nothing.
        if !(interval.tnear <= interval.tfar && interval.tfar > 0.0) {
            return;
        }
        let mesh = self.scene.instances.mesh[instance] as usize;
        let inner = OracleRaySetup::new(&to_object(self.scene, instance, setup.ray()));
        let mut found = None;
        let closer =
            |prim, found: &mut Option<OracleHit>| inner.update_closest(self.scene, prim, found);
        match self.search {
            OracleSearch::Tree(bvh) => {
                // A hit beyond the best so far matters only if the clamp may bring it back.
                let limit = best.map_or(f32::INFINITY, |b| b.t);
                let limit = if limit < interval.tfar {
                    limit
                } else {
                    f32::INFINITY
                };
                bvh.mesh(mesh).closest(&inner, limit, &mut found, closer);
            }
            OracleSearch::BruteForce => {
                for prim in self.scene.meshes.prims(mesh) {
                    closer(prim, &mut found);
                }
            }
        }
        let Some(found) = found else { return };
        let t = min(max(found.t, interval.tnear), interval.tfar);
        let local = found.prim_id - self.scene.meshes.first[mesh];
        let hit = OracleHit {
            t,
            prim_id: self.scene.instance_first_id(instance) + local,
            ..found
        };
        let wins = |b: &OracleHit| t < b.t || (t == b.t && hit.prim_id < b.prim_id);
        if t > 0.0 && t < f32::INFINITY && best.as_ref().is_none_or(wins) {
            *best = Some(hit);
        }
    }

    /// Returns true if the object is hit before `tmax`.
    fn is_hit(&self, setup: &OracleRaySetup, object: u32, tmax: f32) -> bool {
        let Some(instance) = object.checked_sub(self.scene.prim_count() as u32) else {
            let hit = setup.hit(self.scene, object);
            return hit.is_some_and(|hit| hit.t < tmax);
        };
        let instance = instance as usize;
        let interval = setup.intersect_box(&self.instance_boxes[instance]);
        if !(interval.tnear <= interval.tfar && interval.tfar > 0.0 && interval.tnear < tmax) {
            return false;
        }
        let mesh = self.scene.instances.mesh[instance] as usize;
        let inner = OracleRaySetup::new(&to_object(self.scene, instance, setup.ray()));
        // Beyond the interval a hit is clamped to its end.
        let limit = if interval.tfar < tmax {
            f32::INFINITY
        } else {
            tmax
        };
        let blocks = |prim| {
            let hit = inner.hit(self.scene, prim);
            hit.is_some_and(|hit| hit.t < limit)
        };
        match self.search {
            OracleSearch::Tree(bvh) => bvh.mesh(mesh).any(&inner, limit, blocks),
            OracleSearch::BruteForce => self.scene.meshes.prims(mesh).any(blocks),
        }
    }
}
