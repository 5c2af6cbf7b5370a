//! Instances: their numbers and boxes as objects of the world, and rays in the space of their
//! meshes.

use super::intersect::OracleRay;
use glam::Vec3;
use phalanx_scene::{Bounds, Scene};

/// Numbers of the world's visible objects: see [`Scene::world_objects`].
pub(super) fn world_objects(scene: &Scene) -> impl Iterator<Item = u32> {
    scene.world_objects().into_iter().flatten()
}

/// Own padded boxes of all instances.
pub(super) fn instance_boxes(scene: &Scene) -> Vec<Bounds> {
    let meshes = scene.bounds_of_meshes();
    let bounds_of = |k: usize| {
        let mesh = scene.instances.mesh[k] as usize;
        scene.instances.bounds(k, meshes[mesh]).padded()
    };
    (0..scene.instances.len()).map(bounds_of).collect()
}

/// A ray in the space of an instance's mesh. Its direction is not normalized again there, so that
/// distances are the same.
pub(super) fn to_object(scene: &Scene, instance: usize, ray: &OracleRay) -> OracleRay {
    let [x, y, z, shift] = scene.instances.object_columns(instance);
    let turn = |v: Vec3| (x * v.x + y * v.y) + z * v.z;
    OracleRay::new(turn(ray.org) + shift, turn(ray.dir))
}
