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
//! | Q | the largest \|x\| and the largest \|y\| of the vertices beside the ray, added up |
//! | Z | the largest depth |
//! | H | the largest difference between depths |
//! | σ | the ray's larger slope, `steepness` |
//! | R | the largest component of a vertex less the origin |
//! | D | the magnitude of the sum of the edge functions |
//! | s | the sum of the depths weighted by them: the depth is s/D |
//! | F | (Q + σZ)·Q·(H + 2⁻¹⁰Z) + ZD |
//!
//! | condition | distance |
//! |---|---|
//! | F < 32\|s\| | accurate: by the edge functions |
//! | F < 128\|s\| | to the plane |
//! | else | to the plane, clamped to the ray's interval in the triangle's own box |
//!
//! # How accurate
//!
//! Relative to the origin, a component of a vertex is wrong by u of itself, and beside the ray by
//! 2uQ + 5uσZ: one subtraction, slope and product. The depth of the plane changes by that times its
//! gradient, and |n_x| + |n_y| ≤ 2QH of the normal: (4Q + 10σZ)uQH/D in all. The products of an
//! edge function are at most Q²/4. So rounding makes it wrong by uQ²/2, and the depth by 1.5uQ²H/D.
//! The weighted sum and the quotient add 8uZ. So the error is below 10uF/D. If F < 2²⁰|s|, that is
//! less than the depth, and a depth behind the origin certainly is. If F < 32|s|, it is a share of
//! at most 1.9·10⁻⁵. The bound is for errors that all add up: the worst measured is 3.9·10⁻⁶
//! (tests/engine/distance.rs, `perf/notes/distances.md`).
//!
//! # Why a hit is in the triangle's own box without a clamp
//!
//! Let F < 128|s|. As |s| ≤ ZD, D > 128u(Q + σZ)Q. Take the vertices beside the ray as they were
//! computed. The origin is in that triangle if the edge functions agree in sign. A computed sign is
//! never wrong, at worst zero; then the exact function is below u times the product of the
//! distances of the edge's ends from the origin. Say that the origin is outside.
//!
//! - If an edge is nearest, the origin is within 1.1u of the edge's length of it; or the edge is
//!   below 1.1u of the distance, so that D < 3uQ².
//! - If a vertex is nearest, the edges that meet there and have the origin outside point away from
//!   it, within an angle of u(1 + distance/length). Then D < 12uQ².
//!
//! So the origin is inside or within 1.1u of an edge's length. The point of the stored triangle
//! that has the weights of the nearest point, P, is beside the ray by no more: 6.3uR, and 7uR for
//! the vertices. Padding leaves 27uK between the exact box and that of the slab test, where K ≥ R
//! is the sum of the largest coordinates of box and origin. So the ray passes the slab test of the
//! triangle's own box, and is in it at the depth of P. The distance is that of P but for
//!
//! - 8uF/D by the edge functions: the weights differ by rounding, and by 1.1u of a length;
//! - 13uF/D to the plane: its gradient, times the way from P to the ray. D is wrong by a sixth at
//!   most.
//!
//! That is a share of 13u · 128 = 10⁻⁴, less than
//! [`ENTRY_SLACK`](crate::intersect::aabb::ENTRY_SLACK).

use super::edges::EdgeFunctions;
use crate::intersect::shear::Vertices;
use crate::simd::{LANES, LaneMask, Lanes, Vec3Lanes};
use glam::{DVec3, Vec3};

/// Largest F, in units of |s|, of a distance that is accurate, of one in the triangle's own box,
/// and of one that is certainly behind the origin.
const ACCURATE: f32 = 32.0;
const IN_BOX: f32 = 128.0;
const BEHIND: f32 = 1_048_576.0;

/// Share of Z that is added to H: 2⁻¹⁰.
const MIN_SPREAD: f32 = 1.0 / 1024.0;

/// Term added to the bound that |s| must exceed, so that losses below the smallest numbers do not
/// matter: 2⁻⁷⁵.
const MIN_DETERMINANT: f32 = f32::from_bits((127 - 75) << 23);

/// A distance by the edge functions, with the data that bound its error.
pub(crate) struct EdgeDistance<L: Lanes> {
    pub(crate) t: L,
    /// The sum of the edge functions.
    pub(crate) det: L,
    /// Lanes whose distance is accurate, or certainly behind the origin.
    pub(crate) accurate: L::Mask,
    /// F, and |s|.
    bound: L,
    weight: L,
}

impl<L: Lanes> EdgeDistance<L> {
    /// Computes distances by the vertices' depths, and the rays'
    /// [slopes](crate::intersect::shear::Shear::slopes).
    #[inline(always)]
    pub(crate) fn new(
        edges: &EdgeFunctions<L>,
        [a, b, c]: [L; 3],
        [_, _, scale, steepness]: [L; 4],
    ) -> EdgeDistance<L> {
        let EdgeFunctions { u, v, w, .. } = *edges;
        let det = (u + v) + w;
        let sum = (u * a + v * b) + w * c;
        let t = (sum * scale) / det;
        let most = |[a, b, c]: [L; 3]| a.abs().max(b.abs()).max(c.abs());
        let (far, near) = (a.max(b).max(c), a.min(b).min(c));
        let (depth, spread) = (far.abs().max(near.abs()), far - near);
        let margin = most(edges.x) + most(edges.y);
        let bound = (margin + steepness * depth)
            * (margin * (spread + depth * L::splat(MIN_SPREAD)))
            + (depth * det.abs() + L::splat(MIN_DETERMINANT));
        let weight = sum.abs();
        let times = (t.gt(L::ZERO)).select(L::splat(ACCURATE), L::splat(BEHIND));
        // A NaN compares false; a product that overflowed is not a distance.
        let accurate = bound.lt(weight * times) & t.lt(L::splat(f32::INFINITY));
        EdgeDistance {
            t,
            det,
            accurate,
            bound,
            weight,
        }
    }

    /// Lanes in which the distance to the plane is in the triangle's own box.
    #[inline(always)]
    pub(crate) fn in_box(&self) -> L::Mask {
        self.bound.lt(self.weight * L::splat(IN_BOX))
    }
}

/// The distances to the planes of triangles, which replace those by the edges; a ray in the plane
/// keeps the latter. `only` is the one triangle of `stored` against which all rays are tested.
/// Without it, each lane has its own triangle, and only those in `vague` lanes are computed.
/// Everything is passed by value: a value whose address is passed to a call would live in memory
/// elsewhere, too.
#[cold]
#[inline(never)]
pub(crate) fn to_planes<L: Lanes>(
    by_edges: L,
    vague: L::Mask,
    [org, dir]: [Vec3Lanes<L>; 2],
    stored: &impl Vertices,
    only: Option<usize>,
) -> L {
    let Some(one) = only else {
        return to_own_planes(by_edges, vague, |k| [org.lane(k), dir.lane(k)], stored);
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
    vague: L::Mask,
    ray: impl Fn(usize) -> [Vec3; 2],
    stored: &impl Vertices,
) -> L {
    let distances = [0, 1].map(|k| by_edges.octet(k % L::PACKETS).to_array());
    vague.lanes().fold(by_edges, |all, lane| {
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
