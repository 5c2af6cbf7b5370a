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
    let slope = F32x8::splat(camera.slope);
    let alpha = (column - F32x8::splat(camera.half_width)) * slope;
    let beta = (F32x8::splat(camera.half_height) - row) * slope;
    let (right, up) = (wide(camera.right), wide(camera.up));
    let d = (right.scale(alpha) + up.scale(beta)) - wide(camera.back);
    d.normalized()
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
    let [slope, radius, spread] = [camera.slope, radius, spread].map(F32x8::splat);
    let alpha = (column - F32x8::splat(camera.half_width)) * slope - x * spread;
    let beta = (F32x8::splat(camera.half_height) - row) * slope - y * spread;
    let (right, up) = (wide(camera.right), wide(camera.up));
    let d = (right.scale(alpha) + up.scale(beta)) - wide(camera.back);
    let org = (wide(camera.eye) + right.scale(x * radius)) + up.scale(y * radius);
    (org, d.normalized())
}
