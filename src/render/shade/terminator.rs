//! The smooth surface that vertex normals describe above a hit, for lights that it faces: see
//! `scene::terminator`.

use super::instance::{InstanceTransforms, linear};
use super::surface::Surface;
use super::surface_point::{gather_column, unit_or};
use phalanx_scene::{NO_INDEX, PrimKind, SMOOTH_SLOPE, Scene};
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::{F32x8, LaneMask, LaneU32, Lanes, Mask8, U32x8, Vec3x8};

/// The smooth surface above eight hits, for lights.
#[derive(Clone, Copy, Debug)]
pub struct TerminatorShift {
    /// Lanes whose hits count as points of the smooth surface.
    pub smooth: Mask8,
    /// Vector from the hit point to the smooth surface.
    pub shift: Vec3x8,
    /// Unit normal of the smooth surface, turned toward the viewer, without normal maps.
    pub normal: Vec3x8,
}

impl TerminatorShift {
    /// The smooth surface above the hits of `surface`; `None` if light follows all of their
    /// triangles. Each hit point is raised to the tangent planes at the corners of its triangle,
    /// weighted by its barycentric coordinates, where those planes are above it. Vertex normals are
    /// turned as [`Surface::ng`] is, so that nothing is raised where the viewer sees a hollow. On
    /// instances, the shift is that of the mesh, transformed.
    pub fn of(scene: &Scene, surface: &Surface, hits: &HitPacket) -> Option<TerminatorShift> {
        let t = &scene.triangles;
        let placed = hits.prim_id.to_array().map(|id| scene.resolve(id));
        // A surface's hits are all of one kind, and all on instances or none.
        if scene.prims[placed[0].prim as usize].kind() != PrimKind::Triangle {
            return None;
        }
        let rows = placed.map(|placed| scene.prims[placed.prim as usize].index());
        let corners = rows.map(|row| t.normals[row]);
        let without = U32x8::new(corners.map(|corners| corners[0])).eq(U32x8::splat(NO_INDEX));
        let last = t.vertex_normals.len() - 1;
        let column = |k: usize| corners.map(|corners| last.min(corners[k] as usize));
        let normals = [0, 1, 2].map(|k| gather_column(&t.vertex_normals, &column(k)));
        let normals = normals.map(|n| Vec3x8::select(surface.entering, n, -n));
        let [na, nb, nc] = normals.map(|n| unit_or(n, Vec3x8::ZERO));
        let vertex = |k: usize| rows.map(|row| t.corners[row][k] as usize);
        let [a, b, c] = [0, 1, 2].map(|k| gather_column(&t.vertices, &vertex(k)));
        let (ab, ac, bc) = (b - a, c - a, c - b);
        // Depths of a triangle's corners below the tangent planes of the others: `depth_ab` is that
        // of b below the plane of a.
        let (depth_ab, depth_ac) = (-ab.dot(na), -ac.dot(na));
        let (depth_ba, depth_bc) = (ab.dot(nb), -bc.dot(nb));
        let (depth_ca, depth_cb) = (ac.dot(nc), bc.dot(nc));
        let depths = [depth_ac, depth_ba, depth_bc, depth_ca, depth_cb];
        let deepest = depths.into_iter().fold(depth_ab, F32x8::max);
        let least = ab.max_abs().max(ac.max_abs()) * F32x8::splat(SMOOTH_SLOPE);
        let smooth = surface.active & !without & deepest.gt(least);
        if !smooth.any() {
            return None;
        }
        let (beta, gamma) = (hits.u, hits.v);
        let alpha = (F32x8::ONE - beta) - gamma;
        let raise = |n: Vec3x8, weight, depth: F32x8| n.scale(weight * depth.max(F32x8::ZERO));
        let mut shift = (raise(na, alpha, beta * depth_ab + gamma * depth_ac)
            + raise(nb, beta, alpha * depth_ba + gamma * depth_bc))
            + raise(nc, gamma, alpha * depth_ca + beta * depth_cb);
        let [a, b, c] = normals;
        let mut normal = (a.scale(alpha) + b.scale(beta)) + c.scale(gamma);
        if placed[0].instance.is_some() {
            let instances = placed.map(|placed| placed.instance.unwrap_or_default() as usize);
            let map = InstanceTransforms::of(scene, &instances);
            shift = linear(&map.to_world, shift);
            normal = map.normal_to_world(unit_or(normal, Vec3x8::ZERO));
        }
        Some(TerminatorShift {
            smooth,
            shift,
            normal: unit_or(normal, surface.ng),
        })
    }
}
