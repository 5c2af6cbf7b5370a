//! Shading normals turned by a normal map, in the space where the triangles are stored: relief is
//! mirrored, sheared and scaled with its instance.

use super::surface_point::{corner_columns, unit_or};
use super::texture::{lanes_with, map_value};
use glam::Vec3;
use phalanx_scene::{Scene, TextureMap};
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::{F32x8, LANES, Lanes, Vec3x8};

/// Turns the unit normals `ns` of hits on triangles in these rows: x along the tangent, made
/// perpendicular to the normal, y along their cross product times the sign, z along the normal
/// (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008). Lanes without texture
/// coordinates or tangents keep theirs.
pub(super) fn mapped_normals(
    scene: &Scene,
    map: &TextureMap,
    rows: &[usize; LANES],
    hits: &HitPacket,
    ns: Vec3x8,
) -> Vec3x8 {
    let Some((given, value)) = map_value(scene, map, hits) else {
        return ns;
    };
    let tangents_of_rows = rows.map(|row| scene.triangles.corner_tangents(row));
    let with = lanes_with(&tangents_of_rows);
    let tangents_of_rows =
        tangents_of_rows.map(|tangents| tangents.unwrap_or(([Vec3::ZERO; 3], 1.0)));
    let [a, b, c] = corner_columns(tangents_of_rows.map(|(tangents, _)| tangents));
    let (beta, gamma) = (hits.u, hits.v);
    let alpha = (F32x8::ONE - beta) - gamma;
    let along = (a.scale(alpha) + b.scale(beta)) + c.scale(gamma);
    let across = along - ns.scale(ns.dot(along));
    let tangent = unit_or(across, Vec3x8::ZERO);
    let sign = F32x8::new(tangents_of_rows.map(|(_, sign)| sign));
    let bitangent = ns.cross(tangent).scale(sign);
    let [x, y, z] = [value.x, value.y, value.z].map(|c| c * F32x8::splat(2.0) - F32x8::ONE);
    let scale = F32x8::splat(map.scale);
    let normal = (tangent.scale(x * scale) + bitangent.scale(y * scale)) + ns.scale(z);
    Vec3x8::select(given & with, unit_or(normal, ns), ns)
}

/// Vectors on the side of the unit normal `ng`; those on the other side are mirrored.
pub(super) fn in_front(v: Vec3x8, ng: Vec3x8) -> Vec3x8 {
    let along = v.dot(ng);
    let turned = v - ng.scale(F32x8::splat(2.0) * along);
    Vec3x8::select(along.ge(F32x8::ZERO), v, turned)
}
