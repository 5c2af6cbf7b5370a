//! Rays of shadows.

use crate::rays;
use phalanx::{Bvh, Ray, Scene};

/// Rays from where the camera's hit to points above the scene, which they end at.
pub fn shadow_rays(scene: &Scene, bvh: &Bvh, camera: &[Ray]) -> Vec<Ray> {
    let bounds = scene.bounds();
    let size = bounds.hi - bounds.lo;
    let light = bounds.lo + size * rays::glam(0.7, 1.5, 0.6);
    let from = camera
        .iter()
        .filter_map(|ray| rays::surface((scene, size.length()), bvh, ray));
    from.map(|(point, _)| Ray {
        tmax: 1.0,
        ..Ray::new(point, light - point)
    })
    .collect()
}
