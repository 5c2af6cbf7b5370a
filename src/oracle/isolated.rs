//! The oracle's tests alone, one ray at a time and without a tree: for benchmarks and instruction
//! counts, and for nothing else. The counterpart of `trace::isolated`, and what its answers are
//! held against.

use super::intersect::{OracleHit, OracleRay, OracleRaySetup};
use phalanx_scene::{Bounds, Scene};

/// How many pairs of a ray and a box meet.
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

/// The closest hit of each ray on the stored primitives of a scene; instances are left out.
pub fn closest(scene: &Scene, rays: &[OracleRay], hits: &mut [Option<OracleHit>]) {
    for (ray, hit) in rays.iter().zip(hits) {
        let setup = OracleRaySetup::new(ray);
        *hit = None;
        for prim in 0..scene.prim_count() as u32 {
            setup.update_closest(scene, prim, hit);
        }
    }
}

/// Whether a stored primitive of a scene stops each ray before `tmax`. Every primitive is tested,
/// whatever the answer of the one before, as in a leaf of the packet engine's.
pub fn occluded(scene: &Scene, rays: &[OracleRay], tmax: f32, blocked: &mut [bool]) {
    for (ray, blocked) in rays.iter().zip(blocked) {
        let setup = OracleRaySetup::new(ray);
        *blocked = false;
        for prim in 0..scene.prim_count() as u32 {
            let hit = setup.hit(scene, prim);
            *blocked |= hit.is_some_and(|hit| hit.t < tmax);
        }
    }
}
