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
    let slope = F32x8::splat(camera.slope);
    let (right, up) = (wide(camera.right), wide(camera.up));
    let right = right.scale((column - F32x8::splat(camera.half_width)) * slope);
    let up = up.scale((F32x8::splat(camera.half_height) - row) * slope);
    ((wide(camera.eye) + right) + up, wide(-camera.back))
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
    let slope = F32x8::splat(camera.slope);
    let alpha = (column - F32x8::splat(camera.half_width)) * slope - less[0];
    let beta = (F32x8::splat(camera.half_height) - row) * slope - less[1];
    let (right, up) = (wide(camera.right), wide(camera.up));
    let d = (right.scale(alpha) + up.scale(beta)) - wide(camera.back);
    d.normalized()
}
