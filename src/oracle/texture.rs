//! The colour of texture and vertices at one hit, and the maps of its material; explained in
//! `shade`, which computes eight at a time.

use super::intersect::OracleHit;
use super::primitives::unit_or;
use glam::{Vec2, Vec3};
use phalanx_scene::{MapTarget, NO_TEXTURE, PrimKind, Scene, TextureMap};

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
    if texture == NO_TEXTURE {
        return Vec3::ONE;
    }
    uv_at(scene, 0, prim, hit).map_or(Vec3::ONE, |uv| {
        scene.textures[texture as usize].color_at(uv.x, uv.y)
    })
}

/// Texture coordinates of a layer, where the primitive has them.
fn uv_at(scene: &Scene, layer: u32, prim: u32, hit: &OracleHit) -> Option<Vec2> {
    let prim = scene.prims[prim as usize];
    if prim.kind() != PrimKind::Triangle {
        return None;
    }
    let [a, b, c] = scene.triangles.corner_uvs(prim.index(), layer)?;
    let (beta, gamma) = (hit.u, hit.v);
    let alpha = (1.0 - beta) - gamma;
    Some((a * alpha + b * beta) + c * gamma)
}

/// Value of a map's picture; `None` without texture coordinates.
pub(super) fn map_value(
    scene: &Scene,
    map: &TextureMap,
    prim: u32,
    hit: &OracleHit,
) -> Option<Vec3> {
    let Vec2 { x, y } = uv_at(scene, map.uv_layer, prim, hit)?;
    let texture = &scene.textures[map.texture as usize];
    Some(match map.target {
        MapTarget::Emission | MapTarget::Specular => texture.color_at(x, y),
        _ => texture.value_at(x, y),
    })
}

/// The shading normal `ns`, of unit length, turned by the material's normal map.
pub(super) fn mapped_normal(scene: &Scene, prim: u32, hit: &OracleHit, ns: Vec3) -> Vec3 {
    let turned = || {
        let map = scene.normal_map(scene.prim_material(prim))?;
        let value = map_value(scene, &map, prim, hit)?;
        let row = scene.prims[prim as usize].index();
        let ([a, b, c], sign) = scene.triangles.corner_tangents(row)?;
        let (beta, gamma) = (hit.u, hit.v);
        let alpha = (1.0 - beta) - gamma;
        let along = (a * alpha + b * beta) + c * gamma;
        let across = along - ns * ns.dot(along);
        let tangent = unit_or(across, Vec3::ZERO);
        let bitangent = ns.cross(tangent) * sign;
        let [x, y, z] = (value * 2.0 - Vec3::ONE).to_array();
        let normal = (tangent * (x * map.scale) + bitangent * (y * map.scale)) + ns * z;
        Some(unit_or(normal, ns))
    };
    turned().unwrap_or(ns)
}
