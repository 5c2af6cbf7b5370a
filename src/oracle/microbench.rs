//! Microbenchmarks: the oracle's tests in isolation, one ray at a time and without a tree, only for
//! benchmarks and instruction counts. They are the counterpart of `trace::traverse::microbench`,
//! and their results are the reference for those.

use super::intersect::{OracleHit, OracleRay, OracleRaySetup};
use phalanx_scene::{Bounds, Scene};

/// Number of pairs of a ray and a box that intersect.
pub fn boxes(rays: &[OracleRay], boxes: &[Bounds]) -> u64 {
    let mut met = 0;
    for ray in rays {
        let setup = OracleRaySetup::new(ray);
        for b in boxes {
            met += u64::from(setup.intersect_box(b).overlaps(f32::INFINITY));
        }
    }
    met
}

/// The closest hit of each ray on the stored primitives of a scene, without instances.
pub fn closest(scene: &Scene, rays: &[OracleRay], hits: &mut [Option<OracleHit>]) {
    for (ray, hit) in rays.iter().zip(hits) {
        let setup = OracleRaySetup::new(ray);
        *hit = None;
        for prim in 0..scene.prim_count() as u32 {
            setup.update_closest(scene, prim, hit);
        }
    }
}

/// Sets `blocked` for each ray that a stored primitive of a scene stops before `tmax`. Every
/// primitive is tested, whatever the result of the one before, as in a leaf of the packet engine's
/// tree.
pub fn occluded(scene: &Scene, rays: &[OracleRay], tmax: f32, blocked: &mut [bool]) {
    for (ray, blocked) in rays.iter().zip(blocked) {
        let setup = OracleRaySetup::new(ray);
        *blocked = false;
        for prim in 0..scene.prim_count() as u32 {
            let hit = setup.hit::<false>(scene, prim);
            *blocked |= hit.is_some_and(|hit| hit.t < tmax);
        }
    }
}
