//! Camera rays, eight at a time: the operations of [`Camera`], in the same order.

use crate::simd::{F32x8, Lanes, Vec3x8};
use glam::Vec3;
use phalanx_scene::camera::{Camera, LensDisk};

fn wide(v: Vec3) -> Vec3x8 {
    Vec3x8::splat(v.x, v.y, v.z)
}

/// Unit directions, as [`Camera::direction`].
#[inline]
pub fn directions(camera: &Camera, row: F32x8, column: F32x8) -> Vec3x8 {
    directions_with(camera, row, column, [F32x8::ZERO; 2])
}

/// Origins and unit directions, as [`Camera::ray`].
#[inline]
pub fn rays(camera: &Camera, row: F32x8, column: F32x8) -> (Vec3x8, Vec3x8) {
    if !camera.parallel {
        return (wide(camera.eye), directions(camera, row, column));
    }
    let [alpha, beta] = slopes(camera, row, column);
    let (right, up) = (wide(camera.right), wide(camera.up));
    let org = (wide(camera.eye) + right.scale(alpha)) + up.scale(beta);
    (org, wide(-camera.back))
}

/// Slopes to the right and up; for parallel rays, distances.
#[inline]
fn slopes(camera: &Camera, row: F32x8, column: F32x8) -> [F32x8; 2] {
    let slope = F32x8::splat(camera.slope);
    [
        (column - F32x8::splat(camera.half_width)) * slope,
        (F32x8::splat(camera.half_height) - row) * slope,
    ]
}

/// Origins and unit directions, as [`Camera::through_lens`].
#[inline]
pub fn through_lens(
    camera: &Camera,
    row: F32x8,
    column: F32x8,
    [x, y]: [F32x8; 2],
) -> (Vec3x8, Vec3x8) {
    let LensDisk { radius, spread } = camera.lens();
    let [radius, spread] = [radius, spread].map(F32x8::splat);
    let (right, up) = (wide(camera.right), wide(camera.up));
    let org = (wide(camera.eye) + right.scale(x * radius)) + up.scale(y * radius);
    let less = [x * spread, y * spread];
    (org, directions_with(camera, row, column, less))
}

/// Unit directions whose slopes are smaller by `less` than those of [`directions`].
#[inline]
fn directions_with(camera: &Camera, row: F32x8, column: F32x8, less: [F32x8; 2]) -> Vec3x8 {
    let [alpha, beta] = slopes(camera, row, column);
    let (alpha, beta) = (alpha - less[0], beta - less[1]);
    let (right, up) = (wide(camera.right), wide(camera.up));
    let d = (right.scale(alpha) + up.scale(beta)) - wide(camera.back);
    d.normalized()
}
