//! Instances, one ray at a time. The argument why no hit is lost stands in `trace`, in the file of
//! the same name.

use super::intersect::{OracleHit, OracleRay, OracleRaySetup, max, min};
use super::{Oracle, OracleSearch};
use glam::Vec3;
use phalanx_scene::{Bounds, Scene};

/// The objects of the world by number: primitives that belong to no mesh, then instances, from the
/// number of primitives on.
pub(super) fn world_objects(scene: &Scene) -> impl Iterator<Item = u32> {
    let prims = scene.prim_count() as u32;
    let instances = prims..prims + scene.instances.len() as u32;
    scene.world_runs().into_iter().flatten().chain(instances)
}

/// Own padded boxes of all instances.
pub(super) fn instance_boxes(scene: &Scene) -> Vec<Bounds> {
    let meshes = (0..scene.meshes.len()).map(|mesh| scene.mesh_bounds(mesh));
    let meshes: Vec<Bounds> = meshes.collect();
    let own = |k: usize| {
        let mesh = scene.instances.mesh[k] as usize;
        scene.instances.bounds(k, meshes[mesh]).padded()
    };
    (0..scene.instances.len()).map(own).collect()
}

/// A ray in the space of an instance's mesh. Its direction is not normalized again there, so that
/// distances are the same.
pub(super) fn to_object(scene: &Scene, instance: usize, ray: &OracleRay) -> OracleRay {
    let [x, y, z, shift] = scene.instances.object_columns(instance);
    let turn = |v: Vec3| (x * v.x + y * v.y) + z * v.z;
    OracleRay::new(turn(ray.org) + shift, turn(ray.dir))
}

impl Oracle<'_> {
    /// Replaces `best` if the object is hit closer, or as close with a smaller number.
    pub(super) fn update_closest(
        &self,
        setup: &OracleRaySetup,
        object: u32,
        best: &mut Option<OracleHit>,
    ) {
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
    pub(super) fn is_hit(&self, setup: &OracleRaySetup, object: u32, tmax: f32) -> bool {
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
