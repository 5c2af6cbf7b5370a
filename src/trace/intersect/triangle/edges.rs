//! The edge functions of a triangle in the frames of rays.

use crate::simd::{Lanes, Vec3Lanes};

/// Projection of a triangle in the frames of rays: the positions of its vertices beside the rays,
/// and the edge functions, which weigh the vertices.
pub(super) struct EdgeFunctions<L: Lanes> {
    pub(super) x: [L; 3],
    pub(super) y: [L; 3],
    pub(super) u: L,
    pub(super) v: L,
    pub(super) w: L,
    /// Lanes whose ray is within all edges.
    pub(super) inside: L::Mask,
}

/// Computes the edge functions. The vertices are relative to the origin, in the order of the ray's
/// frame. A lane may be a ray against one triangle or a triangle against one ray.
#[inline(always)]
pub(super) fn edges<L: Lanes>(
    [a, b, c]: &[Vec3Lanes<L>; 3],
    [slope_x, slope_y, ..]: [L; 4],
) -> EdgeFunctions<L> {
    let (ax, ay) = (a.x - slope_x * a.z, a.y - slope_y * a.z);
    let (bx, by) = (b.x - slope_x * b.z, b.y - slope_y * b.z);
    let (cx, cy) = (c.x - slope_x * c.z, c.y - slope_y * c.z);
    let u = cx * by - cy * bx;
    let v = ax * cy - ay * cx;
    let w = bx * ay - by * ax;
    let inside = u.min(v).min(w).ge(L::ZERO) | u.max(v).max(w).le(L::ZERO);
    EdgeFunctions {
        x: [ax, bx, cx],
        y: [ay, by, cy],
        u,
        v,
        w,
        inside,
    }
}
