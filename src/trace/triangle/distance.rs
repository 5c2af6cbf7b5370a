//! How far along its ray a hit lies, within 10⁻⁵ of the truth.
//!
//! The edge functions weigh the corners' depths, as in Woop's test. That is as accurate as anything in `f32` where a triangle
//! is about as large as it is far; where it is long and near, what the weights lose is multiplied by its length. Where that may
//! matter, the distance is that to the triangle's plane, in `f64` and from the corners as they are stored.
//!
//! Let u = 2⁻²⁴, S the largest of the places beside the ray, Z the largest depth, H what the depths differ by, D the size of
//! the sum of the edge functions, and s the sum of the depths so weighed: the depth is s/D.
//!
//! | error | at most | because |
//! |---|---|---|
//! | of a corner relative to the origin | u(S + Z) | one subtraction; slopes are at most 1, so no component is larger |
//! | of a place beside the ray | 4u(S + Z) | that, slope and product |
//! | of an edge function | 20u(S + Z)S | two products of those, each other's errors included |
//! | of the depth from these, times D | 60u(S + Z)SH | what moves all depths alike divides out |
//! | of the depth from its own rounding, times D | 6uZD | weights are of one sign |
//!
//! With F = (S + Z)SH + ZD it is at most 60uF, or 2⁻¹⁸F. So s < −2⁻¹⁷F is behind the origin for certain, and the relative error
//! is below 24 · 60u = 9·10⁻⁵ where F < 24|s|. The bound is for errors that all add up: the worst that is measured there is
//! 3·10⁻⁶ (tests/distance.rs, `perf/notes/distances.md`).

use super::{Corners, Edges, FRAMES};
use crate::lanes::{LANES, LaneMask, Lanes, Vec3Lanes};
use glam::{DVec3, Vec3};

/// F may be this many times |s| where the depth is ahead of the origin, and this many where it is behind.
const AHEAD: f32 = 24.0;
const BEHIND: f32 = 131_072.0;

/// Added to what |s| must be larger than, so that what is lost below the smallest numbers does not matter: 2⁻⁷⁵.
const TINY: f32 = f32::from_bits((127 - 75) << 23);

/// A distance by the edge functions.
pub(super) struct ByEdges<L: Lanes> {
    pub(super) t: L,
    /// The sum of the edge functions.
    pub(super) det: L,
    /// Lanes whose distance is accurate or behind the origin for certain; and, if it is ahead and the ray is
    /// [`usual`](super::usual), known to be within the ray's stay in the triangle's own box: clamping it would leave it as it is.
    pub(super) settled: L::Mask,
}

impl<L: Lanes> ByEdges<L> {
    /// By the corners' depths; `scale` is one over the direction's largest component.
    ///
    /// # Why what is settled need not be clamped
    ///
    /// Let R be the largest component of a corner less the origin, and K the sum of the largest coordinates of the own box
    /// and of the origin. Padding leaves 27uK between the box as it is and what the slab test takes it for. The weights w_i,
    /// as computed, are of one sign, so P = Σ w_i corner_i / Σ w_i is in the triangle; what is computed as the distance t is
    /// that of P along the dominant axis, within 10uR. Along another axis the ray at t and P are apart by 18uR from rounding,
    /// and by Σ w_i x_i / Σ w_i, which would be 0 for weights without error. Theirs are below 4uS², so it is at most
    /// 12uS³ / D. That is below 9uR ≤ 9uK where 1.34 S³ < RD, so where 36 S³ < 24|s|, as |s| ≤ RD.
    #[inline(always)]
    pub(super) fn new(edges: &Edges<L>, [a, b, c]: [L; 3], scale: L) -> ByEdges<L> {
        let Edges { u, v, w, .. } = *edges;
        let det = (u + v) + w;
        let sum = (u * a + v * b) + w * c;
        let t = (sum * scale) / det;
        let most = |[a, b, c]: [L; 3]| a.abs().max(b.abs()).max(c.abs());
        let size = most(edges.x).max(most(edges.y));
        let (far, near) = (a.max(b).max(c), a.min(b).min(c));
        let (depth, spread) = (far.abs().max(near.abs()), far - near);
        // As in `accurate`, with a larger spread: so it gives no smaller number, whatever is rounded.
        let more = spread + size * L::splat(36.0);
        let bound = size * (size * more + depth * spread) + depth * det.abs();
        let times = t.gt(L::ZERO).select(L::splat(AHEAD), L::splat(BEHIND));
        // A NaN is not less; a product that overflowed is no distance yet.
        let settled = (bound + L::splat(TINY)).lt(times * sum.abs());
        let settled = settled & t.lt(L::splat(f32::INFINITY));
        ByEdges { t, det, settled }
    }
}

/// The same distances, but those in `vague` lanes by the plane if they are not accurate. `only` is the one triangle of `stored`
/// that all rays are tested against; without, a lane's is the lane's. Everything is taken by value: what a call is given the
/// address of would stay in memory where it is rarely asked for, too.
#[cold]
#[inline(never)]
pub(super) fn refined<L: Lanes>(
    t: L,
    vague: L::Mask,
    [org, dir]: [Vec3Lanes<L>; 2],
    stored: &impl Corners,
    only: Option<usize>,
) -> L {
    let mut refined = [0, 1].map(|k| t.eight(k % L::PACKETS).to_array());
    for lane in vague.lanes() {
        let triangle = only.unwrap_or(lane);
        let coordinate = |corner| [0, 1, 2].map(|axis| stored.coordinate(corner, axis, triangle));
        let corners = [0, 1, 2].map(|corner| Vec3::from_array(coordinate(corner)));
        let t = &mut refined[lane / LANES % 2][lane % LANES];
        *t = distance(&corners, [org.lane(lane), dir.lane(lane)], *t);
    }
    L::from_eights(|k| refined[k % 2])
}

/// How far along a ray, given by origin and direction, a triangle is hit: by its edges, if that is accurate.
fn distance(corners: &[Vec3; 3], ray: [Vec3; 2], by_edges: f32) -> f32 {
    if accurate(corners, ray, by_edges) {
        by_edges
    } else {
        to_plane(corners, ray, by_edges)
    }
}

/// Whether F is within the reach of |s|.
fn accurate(corners: &[Vec3; 3], [org, dir]: [Vec3; 2], by_edges: f32) -> bool {
    let most = |[a, b, c]: [f32; 3]| a.abs().max(b.abs()).max(c.abs());
    let size = dir.abs();
    let axes = if size.x >= size.y && size.x >= size.z {
        FRAMES[0]
    } else if size.y >= size.z {
        FRAMES[1]
    } else {
        FRAMES[2]
    };
    let in_frame = |v: Vec3| Vec3::from_array(axes.map(|axis| v[axis]));
    let (org, dir) = (in_frame(org), in_frame(dir));
    let scale = 1.0 / dir.z;
    let slope = [dir.x * scale, dir.y * scale];
    let [a, b, c] = corners.map(|corner| in_frame(corner) - org);
    let [x, y] = [0, 1].map(|k| [a, b, c].map(|corner| corner[k] - slope[k] * corner.z));
    let u = x[2] * y[1] - y[2] * x[1];
    let v = x[0] * y[2] - y[0] * x[2];
    let w = x[1] * y[0] - y[1] * x[0];
    let det = (u + v) + w;
    let sum = (u * a.z + v * b.z) + w * c.z;
    let size = most(x).max(most(y));
    let (far, near) = (a.z.max(b.z).max(c.z), a.z.min(b.z).min(c.z));
    let (depth, spread) = (far.abs().max(near.abs()), far - near);
    let bound = size * (size * spread + depth * spread) + depth * det.abs();
    let times = if by_edges > 0.0 { AHEAD } else { BEHIND };
    bound + TINY < times * sum.abs() && by_edges < f32::INFINITY
}

/// The distance to the plane of a triangle. The normal is the product of the two shorter edges, whose error is least.
/// `otherwise` where the ray is in the plane.
fn to_plane(corners: &[Vec3; 3], [org, dir]: [Vec3; 2], otherwise: f32) -> f32 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - org.as_dvec3());
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let [across_ab, across_bc, across_ca] = [ab, bc, ca].map(DVec3::length_squared);
    let (place, normal) = if across_bc >= across_ab && across_bc >= across_ca {
        (a, ca.cross(ab))
    } else if across_ca >= across_ab {
        (b, ab.cross(bc))
    } else {
        (c, bc.cross(ca))
    };
    let t = normal.dot(place) / normal.dot(dir.as_dvec3());
    if t.is_finite() { t as f32 } else { otherwise }
}
