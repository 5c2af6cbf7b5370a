//! Eight hits of one kind and one material, ready for lighting.

use super::instance::InstanceTransforms;
use super::normal_map::{in_front, mapped_normals};
use super::surface_point::surface_point;
use phalanx_scene::{INWARD, PrimKind, SINGLE_SIDED, Scene};
use phalanx_trace::packet::{HitPacket, RayPacket};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};

/// Eight points on surfaces of one material.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The lanes that hold a hit.
    pub active: Mask8,
    /// Hit point.
    pub point: Vec3x8,
    /// Unit geometric normal, turned toward the viewer.
    pub ng: Vec3x8,
    /// Unit shading normal, turned with `ng`.
    pub ns: Vec3x8,
    /// Unit direction of the ray that hit.
    pub dir: Vec3x8,
    /// Distance along `ng` at which secondary rays start: a bound on the rounding error of the
    /// point and of the next test.
    pub offset: F32x8,
    /// Lanes whose ray came from outside, by the geometric normal.
    pub entering: Mask8,
    /// Lanes whose hit may be an invisible back: all for which [`Scene::is_unseen_back`] is true,
    /// and few others.
    pub maybe_unseen: Mask8,
    /// True if a normal map turned the shading normals.
    pub bumped: bool,
    /// Index of the ray in its wave.
    pub ray: [u32; LANES],
    /// Material of all eight.
    pub material: u32,
}

impl Surface {
    /// Index of the packet of the wave whose lanes these are, if it is a whole packet in its
    /// original order.
    pub fn whole_packet(&self) -> Option<usize> {
        let first = self.ray[0];
        let in_turn = self.ray == std::array::from_fn(|lane| first.wrapping_add(lane as u32));
        let is_full = in_turn && self.active.bits() == 0xff && first.is_multiple_of(LANES as u32);
        is_full.then_some(first as usize / LANES)
    }
}

/// Properties that eight hits must share to be shaded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadeGroup {
    /// Kind of primitive.
    pub kind: PrimKind,
    /// True if the hits are on instances.
    pub instanced: bool,
    /// Material.
    pub material: u32,
}

/// Evaluates eight hits of one batch. Lanes outside `active` repeat an active one.
pub fn surface(
    scene: &Scene,
    batch: ShadeGroup,
    rays: &RayPacket,
    hits: &HitPacket,
    active: Mask8,
    ray: [u32; LANES],
) -> Surface {
    let flags = scene.materials.flags[batch.material as usize];
    let single_sided = batch.kind == PrimKind::Triangle && flags & SINGLE_SIDED != 0;
    let maybe_unseen = |ng: Vec3x8, dir: Vec3x8| {
        if single_sided { active & may_point_along(ng, dir) } else { Mask8::none() }
    };
    let bumps = match batch.kind {
        PrimKind::Triangle => scene.normal_map(batch.material),
        _ => None,
    };
    let place_of = |rows: &[usize; LANES], rays: &RayPacket, back: Vec3x8| {
        let mut place = surface_point(scene, batch.kind, rows, rays, back, hits);
        if let Some(map) = &bumps {
            place.ns = mapped_normals(scene, map, rows, hits, place.ns);
        }
        place
    };
    let (mut place, maybe_unseen) = if batch.instanced {
        let placed = hits.prim_id.to_array().map(|id| scene.resolve(id));
        let rows = placed.map(|p| scene.prims[p.prim as usize].index());
        let instances = placed.map(|p| p.instance.unwrap_or_default() as usize);
        let map = InstanceTransforms::of(scene, &instances);
        let inside = map.to_object(rays);
        let back = -inside.dir.normalized();
        let seen = place_of(&rows, &inside, back);
        let maybe_unseen = maybe_unseen(seen.ng, inside.dir);
        (map.to_world(seen, rays), maybe_unseen)
    } else {
        let rows = hits.prim_id.to_array();
        let rows = rows.map(|id| scene.prims[id as usize].index());
        let seen = place_of(&rows, rays, -rays.dir);
        let maybe_unseen = maybe_unseen(seen.ng, rays.dir);
        (seen, maybe_unseen)
    };
    if batch.kind == PrimKind::Triangle && !scene.triangles.normals.is_empty() {
        // The normals of the file determine the outside of a triangle, regardless of winding.
        let inward = place.ng.dot(place.outward).lt(F32x8::splat(INWARD));
        place.ng = Vec3x8::select(inward, -place.ng, place.ng);
    }
    let away = rays.dir.dot(place.ng).gt(F32x8::ZERO);
    let [ng, mut ns] = [place.ng, place.ns].map(|n| Vec3x8::select(away, -n, n));
    if bumps.is_some() {
        ns = in_front(ns, ng);
    }
    Surface {
        active,
        point: place.point,
        ng,
        ns,
        dir: rays.dir,
        offset: place.offset,
        entering: !away,
        maybe_unseen,
        bumped: bumps.is_some(),
        ray,
        material: batch.material,
    }
}

/// Error of a direction's product with a unit normal, both of single precision, relative to the
/// direction: the normal's rounding, that of the products and that of two sums are 12 · 2⁻²⁴.
const SIDE_ROUNDING: f32 = 1.0 / 1_048_576.0;

/// Lanes in which a direction is on the side of a unit normal, or nearly between the sides.
pub(super) fn may_point_along(normal: Vec3x8, dir: Vec3x8) -> Mask8 {
    let error = dir.max_abs() * F32x8::splat(SIDE_ROUNDING) + F32x8::splat(f32::MIN_POSITIVE);
    !normal.dot(dir).lt(-error)
}
