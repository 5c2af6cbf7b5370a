//! The oracle's tests alone, one ray at a time and without a tree: for benchmarks and instruction counts, and for nothing
//! else. The counterpart of `trace::isolated`, and what its answers are held against.

use super::intersect::{Hit, Probe, Ray};
use phalanx_scene::{Bounds, Scene};

/// How many pairs of a ray and a box meet.
pub fn boxes(rays: &[Ray], boxes: &[Bounds]) -> u64 {
    let mut met = 0;
    for ray in rays {
        let probe = Probe::new(ray);
        for b in boxes {
            met += u64::from(probe.stay(b).within(f32::INFINITY));
        }
    }
    met
}

/// The closest hit of each ray on the stored primitives of a scene; instances are left out.
pub fn closest(scene: &Scene, rays: &[Ray], hits: &mut [Option<Hit>]) {
    for (ray, hit) in rays.iter().zip(hits) {
        let probe = Probe::new(ray);
        *hit = None;
        for prim in 0..scene.prim_count() as u32 {
            probe.closer(scene, prim, hit);
        }
    }
}

/// Whether a stored primitive of a scene stops each ray before `tmax`. Every primitive is tested, whatever the answer of
/// the one before, as in a leaf of the packet engine's.
pub fn occluded(scene: &Scene, rays: &[Ray], tmax: f32, blocked: &mut [bool]) {
    for (ray, blocked) in rays.iter().zip(blocked) {
        let probe = Probe::new(ray);
        *blocked = false;
        for prim in 0..scene.prim_count() as u32 {
            let hit = probe.hit(scene, prim);
            *blocked |= hit.is_some_and(|hit| hit.t < tmax);
        }
    }
}
