//! The colour of texture and vertices at one hit; explained in `shade`, which computes eight at a
//! time.

use super::intersect::OracleHit;
use glam::Vec3;
use phalanx_scene::{NO_TEXTURE, PrimKind, Scene};

/// The factor of Ka and Kd on a stored primitive.
pub(super) fn tint(scene: &Scene, texture: u32, prim: u32, hit: &OracleHit) -> Vec3 {
    texture_color(scene, texture, prim, hit) * vertex_color(scene, prim, hit)
}

fn vertex_color(scene: &Scene, prim: u32, hit: &OracleHit) -> Vec3 {
    let prim = scene.prims[prim as usize];
    if prim.kind() != PrimKind::Triangle {
        return Vec3::ONE;
    }
    let Some([a, b, c]) = scene.triangles.corner_colors(prim.index()) else {
        return Vec3::ONE;
    };
    let (beta, gamma) = (hit.u, hit.v);
    let alpha = (1.0 - beta) - gamma;
    (a * alpha + b * beta) + c * gamma
}

fn texture_color(scene: &Scene, texture: u32, prim: u32, hit: &OracleHit) -> Vec3 {
    let prim = scene.prims[prim as usize];
    if texture == NO_TEXTURE || prim.kind() != PrimKind::Triangle {
        return Vec3::ONE;
    }
    let Some([a, b, c]) = scene.triangles.corner_uvs(prim.index()) else {
        return Vec3::ONE;
    };
    let (beta, gamma) = (hit.u, hit.v);
    let alpha = (1.0 - beta) - gamma;
    let position = (a * alpha + b * beta) + c * gamma;
    scene.textures[texture as usize].color_at(position.x, position.y)
}
