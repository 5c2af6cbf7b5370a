//! Instances, one ray at a time; the argument why nothing is lost stands in `trace`, in the file of the same name.

use super::intersect::{Hit, Probe, Ray, max, min};
use super::{Oracle, Search};
use glam::Vec3;
use phalanx_scene::{Bounds, Scene};

/// The objects of the world by number: primitives that no mesh claims, then instances, from the number of primitives on.
pub(super) fn world(scene: &Scene) -> impl Iterator<Item = u32> {
    let prims = scene.prim_count() as u32;
    let instances = prims..prims + scene.instances.len() as u32;
    scene.world_runs().into_iter().flatten().chain(instances)
}

/// Own padded boxes of all instances.
pub(super) fn boxes(scene: &Scene) -> Vec<Bounds> {
    let meshes = (0..scene.meshes.len()).map(|mesh| scene.mesh_bounds(mesh));
    let meshes: Vec<Bounds> = meshes.collect();
    let own = |k: usize| {
        let mesh = scene.instances.mesh[k] as usize;
        scene.instances.bounds(k, meshes[mesh]).padded()
    };
    (0..scene.instances.len()).map(own).collect()
}

/// A ray in the space of an instance's mesh. Its direction keeps its length there, so that distances are the same.
pub(super) fn moved(scene: &Scene, instance: usize, ray: &Ray) -> Ray {
    let [x, y, z, shift] = scene.instances.object_columns(instance);
    let turn = |v: Vec3| (x * v.x + y * v.y) + z * v.z;
    Ray::new(turn(ray.org) + shift, turn(ray.dir))
}

impl Oracle<'_> {
    /// Replaces `best` if the object is hit closer, or as close with a smaller number.
    pub(super) fn closer(&self, probe: &Probe, object: u32, best: &mut Option<Hit>) {
        match object.checked_sub(self.scene.prim_count() as u32) {
            None => probe.closer(self.scene, object, best),
            Some(instance) => self.closer_in(instance as usize, probe, best),
        }
    }

    fn closer_in(&self, instance: usize, probe: &Probe, best: &mut Option<Hit>) {
        let stay = probe.stay(&self.instance_boxes[instance]);
        // As in `trace`: a stay that is no number holds nothing.
        if !(stay.enter <= stay.leave && stay.leave > 0.0) {
            return;
        }
        let mesh = self.scene.instances.mesh[instance] as usize;
        let inner = Probe::new(&moved(self.scene, instance, probe.ray()));
        let mut found = None;
        let closer = |prim, found: &mut Option<Hit>| inner.closer(self.scene, prim, found);
        match self.search {
            Search::Tree(forest) => {
                // A hit beyond the best so far matters only where the clamp may bring it back.
                let limit = best.map_or(f32::INFINITY, |b| b.t);
                let limit = if limit < stay.leave {
                    limit
                } else {
                    f32::INFINITY
                };
                forest.mesh(mesh).closest(&inner, limit, &mut found, closer);
            }
            Search::BruteForce => {
                for prim in self.scene.meshes.prims(mesh) {
                    closer(prim, &mut found);
                }
            }
        }
        let Some(found) = found else { return };
        let t = min(max(found.t, stay.enter), stay.leave);
        let local = found.prim_id - self.scene.meshes.first[mesh];
        let hit = Hit {
            t,
            prim_id: self.scene.instance_first_id(instance) + local,
            ..found
        };
        let wins = |b: &Hit| t < b.t || (t == b.t && hit.prim_id < b.prim_id);
        if t > 0.0 && t < f32::INFINITY && best.as_ref().is_none_or(wins) {
            *best = Some(hit);
        }
    }

    /// Whether the object is hit before `tmax`.
    pub(super) fn blocks(&self, probe: &Probe, object: u32, tmax: f32) -> bool {
        let Some(instance) = object.checked_sub(self.scene.prim_count() as u32) else {
            let hit = probe.hit(self.scene, object);
            return hit.is_some_and(|hit| hit.t < tmax);
        };
        let instance = instance as usize;
        let stay = probe.stay(&self.instance_boxes[instance]);
        if !(stay.enter <= stay.leave && stay.leave > 0.0 && stay.enter < tmax) {
            return false;
        }
        let mesh = self.scene.instances.mesh[instance] as usize;
        let inner = Probe::new(&moved(self.scene, instance, probe.ray()));
        // Beyond the stay a hit comes out as its end.
        let limit = if stay.leave < tmax {
            f32::INFINITY
        } else {
            tmax
        };
        let blocks = |prim| {
            let hit = inner.hit(self.scene, prim);
            hit.is_some_and(|hit| hit.t < limit)
        };
        match self.search {
            Search::Tree(forest) => forest.mesh(mesh).any(&inner, limit, blocks),
            Search::BruteForce => self.scene.meshes.prims(mesh).any(blocks),
        }
    }
}
