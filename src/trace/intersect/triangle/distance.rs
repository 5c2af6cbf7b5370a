//! Distance of a hit along its ray, within 10⁻⁵ of the truth.
//!
//! The edge functions weigh the vertices' depths, as in Woop's test. That is as accurate as `f32`
//! allows if a triangle's size is similar to its distance. If it is long and near, the error of the
//! weights is multiplied by its length. If that may matter, the distance is that to the triangle's
//! plane, in `f64` and from the stored vertices.
//!
//! | symbol | meaning |
//! |---|---|
//! | u | 2⁻²⁴ |
//! | S | the largest of the positions beside the ray |
//! | Z | the largest depth |
//! | H | the largest difference between depths |
//! | D | the magnitude of the sum of the edge functions |
//! | s | the sum of the depths weighted by them: the depth is s/D |
//!
//! | error | at most | because |
//! |---|---|---|
//! | of a vertex relative to the origin | u(S + Z) | one subtraction (1) |
//! | of a position beside the ray | 4u(S + Z) | that, slope and product |
//! | of an edge function | 20u(S + Z)S | two products of those (2) |
//! | of the depth from these, times D | 60u(S + Z)SH | a common shift of all depths divides out |
//! | of the depth from its own rounding, times D | 6uZD | weights are of one sign |
//!
//! (1) Slopes are at most 1, so no component is larger. (2) Each other's errors are included.
//!
//! With F = (S + Z)SH + ZD the error is at most 60uF, or 2⁻¹⁸F. So s < −2⁻¹⁸F is behind the origin
//! for certain, and the relative error is below 24 · 60u = 9·10⁻⁵ if F < 24|s|. The bound is for
//! errors that all add up: the worst measured is 4·10⁻⁶ (tests/engine/distance.rs,
//! `perf/notes/distances.md`).

use super::edges::EdgeFunctions;
use crate::intersect::shear::Vertices;
use crate::simd::{LANES, LaneMask, Lanes, Vec3Lanes};
use glam::{DVec3, Vec3};

/// Largest F, in units of |s|: for a depth ahead of the origin, and for one behind it.
const MAX_DEPTH_RATIO_AHEAD: f32 = 24.0;
const MAX_DEPTH_RATIO_BEHIND: f32 = 262_144.0;

/// Smallest ZD, in units of S³, of a hit that is certainly in its triangle's own box: 1.34, plus an
/// eighth for rounding.
const MIN_DEPTH_RATIO: f32 = 1.5;

/// Term added to the bound that |s| must exceed, and to the one that ZD must, so that losses below
/// the smallest numbers do not matter: 2⁻⁷⁵.
const MIN_DETERMINANT: f32 = f32::from_bits((127 - 75) << 23);

/// A distance by the edge functions, with the data that bound its error.
pub(crate) struct EdgeDistance<L: Lanes> {
    pub(crate) t: L,
    /// The sum of the edge functions.
    pub(crate) det: L,
    /// Largest allowed F: |s| times [`MAX_DEPTH_RATIO_AHEAD`] or [`MAX_DEPTH_RATIO_BEHIND`].
    reach: L,
    /// The terms S, H, Z · H and Z · D of F.
    size: L,
    spread: L,
    depth_by_spread: L,
    depth_by_det: L,
}

impl<L: Lanes> EdgeDistance<L> {
    /// Computes distances by the vertices' depths; `scale` is one over the direction's largest
    /// component.
    #[inline(always)]
    pub(crate) fn new(edges: &EdgeFunctions<L>, [a, b, c]: [L; 3], scale: L) -> EdgeDistance<L> {
        let EdgeFunctions { u, v, w, .. } = *edges;
        let det = (u + v) + w;
        let sum = (u * a + v * b) + w * c;
        let t = (sum * scale) / det;
        let most = |[a, b, c]: [L; 3]| a.abs().max(b.abs()).max(c.abs());
        let (far, near) = (a.max(b).max(c), a.min(b).min(c));
        let (depth, spread) = (far.abs().max(near.abs()), far - near);
        let times = t.gt(L::ZERO).select(
            L::splat(MAX_DEPTH_RATIO_AHEAD),
            L::splat(MAX_DEPTH_RATIO_BEHIND),
        );
        EdgeDistance {
            t,
            det,
            reach: times * sum.abs(),
            size: most(edges.x).max(most(edges.y)),
            spread,
            depth_by_spread: depth * spread,
            depth_by_det: depth * det.abs(),
        }
    }

    /// Lanes whose distance is accurate, or certainly behind the origin: F is within its limit.
    #[inline(always)]
    pub(crate) fn accurate(&self) -> L::Mask {
        let bound =
            self.size * (self.size * self.spread + self.depth_by_spread) + self.depth_by_det;
        // A NaN compares false; a product that overflowed is not a distance.
        (bound + L::splat(MIN_DETERMINANT)).lt(self.reach) & self.t.lt(L::splat(f32::INFINITY))
    }

    /// Lanes whose distance is [`EdgeDistance::accurate`] and need not be clamped. If it is ahead
    /// and the ray is in the safe range ([`shear`](crate::intersect::shear)), it is known to be
    /// within the ray's interval in the triangle's own box: clamping would not change it.
    ///
    /// Let R be the largest component of a vertex less the origin, and K the sum of the largest
    /// coordinates of the own box and of the origin. Padding leaves 27uK between the exact box and
    /// the box of the slab test. The weights w_i, as computed, are of one sign, so P = Σ w_i
    /// vertex_i / Σ w_i is in the triangle. The computed distance t is that of P along the dominant
    /// axis, within 10uR. Along another axis the ray at t and P are apart by
    ///
    /// - 18uR from rounding, and
    /// - Σ w_i x_i / Σ w_i, which would be 0 for weights without error. Their errors are below
    ///   4uS², so it is at most 12uS³ / D.
    ///
    /// The latter is below 9uR ≤ 9uK if 1.34 S³ < RD, so if 1.5 S³ < ZD, as Z ≤ R.
    #[inline(always)]
    pub(crate) fn clamp_not_needed(&self) -> L::Mask {
        let cube = self.size * self.size * (self.size * L::splat(MIN_DEPTH_RATIO));
        let inside = (cube + L::splat(MIN_DETERMINANT)).lt(self.depth_by_det);
        self.accurate() & (inside | self.t.le(L::ZERO))
    }
}

/// The distances to the planes of triangles, which replace those by the edges; a ray in the plane
/// keeps the latter. `only` is the one triangle of `stored` against which all rays are tested.
/// Without it, each lane has its own triangle, and only those in `asked` lanes are computed.
/// Everything is passed by value: a value whose address is passed to a call would live in memory
/// elsewhere, too.
#[cold]
#[inline(never)]
pub(crate) fn to_planes<L: Lanes>(
    by_edges: L,
    asked: L::Mask,
    [org, dir]: [Vec3Lanes<L>; 2],
    stored: &impl Vertices,
    only: Option<usize>,
) -> L {
    let Some(one) = only else {
        return to_own_planes(by_edges, asked, |k| [org.lane(k), dir.lane(k)], stored);
    };
    let plane = Plane::of(stored, one);
    let mut distances = [0, 1].map(|k| by_edges.octet(k % L::PACKETS).to_array());
    for (k, t) in distances.iter_mut().enumerate().take(L::PACKETS) {
        let columns = |v: Vec3Lanes<L>| [v.x, v.y, v.z].map(|c| c.octet(k).to_array());
        plane.distances(columns(org), columns(dir), t);
    }
    L::from_octets(|k| distances[k % 2])
}

/// [`to_planes`] with a separate triangle in each lane: `ray` gives its origin and direction. More
/// than one lane is rarely asked for. Each is inserted into a register, because loading a whole
/// vector stalls on stores of its parts.
#[inline(always)]
pub(crate) fn to_own_planes<L: Lanes>(
    by_edges: L,
    asked: L::Mask,
    ray: impl Fn(usize) -> [Vec3; 2],
    stored: &impl Vertices,
) -> L {
    let distances = [0, 1].map(|k| by_edges.octet(k % L::PACKETS).to_array());
    asked.lanes().fold(by_edges, |all, lane| {
        let by_edges = distances[lane / LANES % 2][lane % LANES];
        let [org, dir] = ray(lane);
        let t = Plane::of(stored, lane).distance(org, dir, by_edges);
        L::Mask::from_bits(1 << lane).select(L::splat(t), all)
    })
}

/// The plane of a triangle: a vertex, and the cross product of the two shorter edges, which has the
/// smallest error.
struct Plane {
    corner: DVec3,
    normal: DVec3,
}

impl Plane {
    /// The plane of a stored triangle.
    #[inline(always)]
    fn of(stored: &impl Vertices, lane: usize) -> Plane {
        let corner = |k: usize| {
            let coordinate = |axis: usize| stored.coordinate(k, axis, lane);
            Vec3::new(coordinate(0), coordinate(1), coordinate(2)).as_dvec3()
        };
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        let (ab, bc, ca) = (b - a, c - b, a - c);
        let [across_ab, across_bc, across_ca] = [ab, bc, ca].map(DVec3::length_squared);
        let (corner, normal) = if across_bc >= across_ab && across_bc >= across_ca {
            (a, ca.cross(ab))
        } else if across_ca >= across_ab {
            (b, ab.cross(bc))
        } else {
            (c, bc.cross(ca))
        };
        Plane { corner, normal }
    }

    /// Distance of the plane from a ray's origin, in units of its direction; `otherwise` for a ray
    /// in the plane.
    #[inline(always)]
    fn distance(&self, org: Vec3, dir: Vec3, otherwise: f32) -> f32 {
        let height = self.normal.dot(self.corner - org.as_dvec3());
        let t = height / self.normal.dot(dir.as_dvec3());
        if t.is_finite() { t as f32 } else { otherwise }
    }

    /// Distances of the plane for eight rays in columns. These are arrays, which the compiler
    /// vectorises.
    #[inline(always)]
    fn distances(&self, org: [[f32; LANES]; 3], dir: [[f32; LANES]; 3], t: &mut [f32; LANES]) {
        for lane in 0..LANES {
            let org = Vec3::new(org[0][lane], org[1][lane], org[2][lane]);
            let dir = Vec3::new(dir[0][lane], dir[1][lane], dir[2][lane]);
            t[lane] = self.distance(org, dir, t[lane]);
        }
    }
}
