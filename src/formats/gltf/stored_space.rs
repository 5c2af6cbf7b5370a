//! Spaces of meshes that are stored once for several placements.

use super::geometry::PrimitiveGeometry;
use super::mesh_instances::MAX_COPIED_TRIANGLES;
use glam::{DAffine3, DVec3};
use phalanx_scene::Bounds;

/// Extents of meshes that are instanced as they are. Beyond this range the stored mesh could not be
/// intersected in single precision.
const SAFE_EXTENTS: std::ops::RangeInclusive<f32> = 1.0 / 268_435_456.0..=268_435_456.0;

/// The map from a mesh's own space to the one in which it is stored, and the map back. The mesh is
/// moved to an origin, and then scaled.
pub(super) fn stored_space(origin: Option<DVec3>, scale: f64) -> [DAffine3; 2] {
    let origin = origin.unwrap_or_default();
    let scaled = |factor: f64| DAffine3::from_scale(DVec3::splat(factor));
    [
        scaled(scale) * DAffine3::from_translation(-origin),
        DAffine3::from_translation(origin) * scaled(1.0 / scale),
    ]
}

/// Factor of shapes that are stored once for several placements; `None` if they must be baked into
/// each of them.
pub(super) fn stored_size(
    shapes: &[PrimitiveGeometry],
    bounds: Bounds,
    placements: usize,
) -> Option<f64> {
    let extent = bounds.lo.abs().max(bounds.hi.abs()).max_element();
    let triangles: u64 = shapes.iter().map(|shape| shape.len() as u64).sum();
    let copied = triangles.saturating_mul(placements as u64 - 1);
    if SAFE_EXTENTS.contains(&extent) {
        return Some(1.0);
    }
    (copied > MAX_COPIED_TRIANGLES).then(|| power_of_two_into_range(extent))
}

/// The power of two that brings an extent to the nearer end of [`SAFE_EXTENTS`]. A power of two
/// does not round anything.
fn power_of_two_into_range(extent: f32) -> f64 {
    let nearest = extent.clamp(*SAFE_EXTENTS.start(), *SAFE_EXTENTS.end());
    if extent > 0.0 && extent.is_finite() {
        libm::ldexp(
            1.0,
            libm::ilogb(f64::from(nearest)) - libm::ilogb(f64::from(extent)),
        )
    } else {
        1.0
    }
}
