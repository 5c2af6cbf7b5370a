//! Rays against one triangle, watertight: Woop, Benthin and Wald, "Watertight Ray/Triangle
//! Intersection", JCGT 2013.
//!
//! The vertices are moved into a frame in which the ray is the z axis, and three 2D edge functions
//! decide. A vertex's 2D position depends on the ray and the vertex alone, and the sign of a
//! difference of two rounded products is never wrong, at worst zero. Zeros are accepted, so a
//! closed mesh has no gap, vertices included.
//!
//! Departures:
//!
//! - There is no double precision fallback of the edge functions; zeros are accepted on both sides
//!   instead.
//! - There is no culling, and no swap of axes for winding.
//! - Slopes are products with the reciprocal that the distance needs anyway.
//! - The distance is that to the plane if the edge functions give no accurate one (see
//!   [`distance`]). It is clamped to the ray's interval in the triangle's own box (see
//!   [`crate::traverse`]), if that may change it.
//!
//! The design notes asked for edge functions (a − o) × (b − o) · d. Those have exact signs along an
//! edge. But at a vertex shared by n triangles their n rounding errors are independent, and all can
//! fall on the same side. Of 20,000 rays aimed at the vertices of a sphere mesh that form lost 521,
//! this one none.

mod distance;

use super::aabb::TInterval;
use super::query::{HitCandidate, HitRecord, RaySetup};
use crate::bvh::{LeafTriangle, TriangleBlock};
use crate::simd::{LaneMask, LaneU32, Lanes, NATIVE, Native, Vec3Lanes, Vec3Native};
use distance::EdgeDistance;
use glam::Vec3;
use phalanx_scene::{Bounds, PAD};

/// The frame in which the rays are the z axis: the dominant axis of the direction, and the slopes
/// against it.
#[derive(Clone, Copy)]
pub(super) struct Shear<L: Lanes> {
    /// Lanes whose dominant axis is x, and lanes where it is y; elsewhere it is z.
    x_major: L::Mask,
    y_major: L::Mask,
    /// The dominant axis if all lanes share it, else [`MIXED`].
    pub(super) axis: usize,
    /// True if every ray is within [`SAFE_RANGE`]: else every distance is clamped.
    pub(super) in_safe_range: bool,
    /// Origin with its components in the order of the frame.
    org: Vec3Lanes<L>,
    /// Slopes d_kx · scale and d_ky · scale, and scale = 1/d_kz.
    slope_x: L,
    slope_y: L,
    scale: L,
}

/// The triangles of a block by vertex, by axis; the fourth axis makes an index check unnecessary.
pub(super) type VertexColumns = [[Native; 4]; 3];

/// Access to the vertices of one or several triangles.
pub(super) trait Vertices {
    /// A coordinate of a vertex of the triangle in a lane.
    fn coordinate(&self, corner: usize, axis: usize, lane: usize) -> f32;
}

impl Vertices for VertexColumns {
    #[inline(always)]
    fn coordinate(&self, corner: usize, axis: usize, lane: usize) -> f32 {
        self[corner][axis & 3].lane(lane % NATIVE)
    }
}

impl Vertices for TriangleBlock {
    #[inline(always)]
    fn coordinate(&self, corner: usize, axis: usize, lane: usize) -> f32 {
        self.vertices[corner][axis.min(2)][lane % NATIVE]
    }
}

impl Vertices for LeafTriangle {
    #[inline(always)]
    fn coordinate(&self, corner: usize, axis: usize, _: usize) -> f32 {
        self.vertices[corner][axis.min(2)]
    }
}

/// A triangle of a block in every lane, with its axes in this order.
#[inline(always)]
fn in_frame<L: Lanes>(
    block: &impl Vertices,
    lane: usize,
    [x, y, z]: [usize; 3],
) -> [Vec3Lanes<L>; 3] {
    let one = |corner: usize, axis: usize| L::splat(block.coordinate(corner, axis, lane));
    let corner = |k: usize| Vec3Lanes::new(one(k, x), one(k, y), one(k, z));
    [corner(0), corner(1), corner(2)]
}

/// Orders (kx, ky, kz) by dominant axis; x, y, z if the lanes' axes differ.
const FRAMES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// Stands for "the lanes' dominant axes differ" in [`Shear::axis`].
pub(super) const MIXED: usize = 3;

impl<L: Lanes> Shear<L> {
    #[inline(always)]
    pub(super) fn new(org: Vec3Lanes<L>, dir: Vec3Lanes<L>, active: L::Mask) -> Shear<L> {
        let size = dir.abs();
        let x_major = size.x.ge(size.y) & size.x.ge(size.z);
        let y_major = !x_major & size.y.ge(size.z);
        let (x, y, live) = (x_major.bits(), y_major.bits(), active.bits());
        let axis = if x & live == live {
            0
        } else if y & live == live {
            1
        } else if (x | y) & live == 0 {
            2
        } else {
            MIXED
        };
        let frame = |v: Vec3Lanes<L>| match axis {
            0 => Vec3Lanes::new(v.y, v.z, v.x),
            1 => Vec3Lanes::new(v.z, v.x, v.y),
            2 => v,
            _ => permute(x_major, y_major, v),
        };
        let d = frame(dir);
        let scale = L::ONE / d.z;
        Shear {
            x_major,
            y_major,
            axis,
            in_safe_range: usual(org, d.z).bits() & live == live,
            org: frame(org),
            slope_x: d.x * scale,
            slope_y: d.y * scale,
            scale,
        }
    }

    /// The axes in the order of the frame, by lane; and the origins in that order, with slopes and
    /// scale.
    #[inline(always)]
    pub(super) fn columns(&self) -> ([L::U32; 3], [Vec3Lanes<L>; 2]) {
        let [by_x, by_y, by_z] = [0, 1, 2].map(|major| FRAMES[major]);
        let axis = |k: usize| {
            let [x, y, z] = [by_x[k], by_y[k], by_z[k]].map(|axis| L::U32::splat(axis as u32));
            self.x_major.select_u32(x, self.y_major.select_u32(y, z))
        };
        let slopes = Vec3Lanes::new(self.slope_x, self.slope_y, self.scale);
        ([axis(0), axis(1), axis(2)], [self.org, slopes])
    }

    /// A triangle's vertices, with their components in the order of the frames. `APART` is true if
    /// the rays' dominant axes differ.
    #[inline(always)]
    pub(super) fn in_order<const APART: bool>(
        &self,
        block: &impl Vertices,
        lane: usize,
    ) -> [Vec3Lanes<L>; 3] {
        if APART {
            in_frame(block, lane, [0, 1, 2]).map(|corner| self.turn(corner))
        } else {
            in_frame(block, lane, FRAMES[self.axis & 3])
        }
    }

    /// A triangle's vertices relative to the rays' origins, with their components in the order of
    /// the frames.
    #[inline(always)]
    pub(super) fn less_origins<const APART: bool>(
        &self,
        block: &impl Vertices,
        lane: usize,
    ) -> [Vec3Lanes<L>; 3] {
        let [a, b, c] = self.in_order::<APART>(block, lane);
        [a - self.org, b - self.org, c - self.org]
    }

    #[inline(always)]
    fn turn(&self, v: Vec3Lanes<L>) -> Vec3Lanes<L> {
        permute(self.x_major, self.y_major, v)
    }

    /// Slopes and scale, as [`intersect`] takes them.
    #[inline(always)]
    pub(super) fn slopes(&self) -> [L; 3] {
        [self.slope_x, self.slope_y, self.scale]
    }

    /// A vertex relative to the origin, with its components in the order of the frame whose z is
    /// `AXIS`.
    #[inline(always)]
    fn relative<const AXIS: usize>(&self, corner: &[f32; 3]) -> Vec3Lanes<L> {
        let wide = |k: usize| L::splat(corner[k]);
        let ordered = match AXIS {
            0 => Vec3Lanes::new(wide(1), wide(2), wide(0)),
            1 => Vec3Lanes::new(wide(2), wide(0), wide(1)),
            2 => Vec3Lanes::new(wide(0), wide(1), wide(2)),
            _ => permute(
                self.x_major,
                self.y_major,
                Vec3Lanes::new(wide(0), wide(1), wide(2)),
            ),
        };
        ordered - self.org
    }
}

/// Orders components (kx, ky, kz) = (y, z, x), (z, x, y) or (x, y, z) by dominant axis.
#[inline(always)]
fn permute<L: Lanes>(x_major: L::Mask, y_major: L::Mask, v: Vec3Lanes<L>) -> Vec3Lanes<L> {
    let pick = |by_x, by_y, by_z| x_major.select(by_x, y_major.select(by_y, by_z));
    Vec3Lanes::new(
        pick(v.y, v.z, v.x),
        pick(v.z, v.x, v.y),
        pick(v.x, v.y, v.z),
    )
}

/// Tests one triangle and updates `best` with a closer hit.
#[inline(always)]
pub(super) fn closest<L: Lanes, const AXIS: usize>(
    rays: &RaySetup<L>,
    slot: &LeafTriangle,
    best: &mut HitRecord<L>,
) {
    let Some(hit) = intersect_packet::<L, AXIS>(rays, slot) else {
        return;
    };
    best.update(&hit, L::U32::splat(slot.prim_id));
}

/// Lanes that the triangle stops before `tmax`.
#[inline(always)]
pub(super) fn occluded<L: Lanes, const AXIS: usize>(
    rays: &RaySetup<L>,
    slot: &LeafTriangle,
    tmax: L,
) -> L::Mask {
    match intersect_packet::<L, AXIS>(rays, slot) {
        Some(hit) => hit.valid & hit.t.lt(tmax),
        None => L::Mask::none(),
    }
}

/// The triangle's own padded box.
#[inline(always)]
pub(super) fn prim_aabb(corners: &[[f32; 3]; 3]) -> [[f32; 3]; 2] {
    let [a, b, c] = corners.map(Vec3::from_array);
    let own = Bounds::new(a.min(b).min(c), a.max(b).max(c)).padded();
    [own.lo.to_array(), own.hi.to_array()]
}

/// The padded boxes of the triangles of a block: the arithmetic of
/// [`phalanx_scene::Bounds::padded`].
#[inline(always)]
pub(super) fn prim_aabbs([a, b, c]: [Vec3Native; 3]) -> [Vec3Native; 2] {
    let least = |a: Native, b: Native, c: Native| a.min(b).min(c);
    let most = |a: Native, b: Native, c: Native| a.max(b).max(c);
    let lo = Vec3Native::new(
        least(a.x, b.x, c.x),
        least(a.y, b.y, c.y),
        least(a.z, b.z, c.z),
    );
    let hi = Vec3Native::new(
        most(a.x, b.x, c.x),
        most(a.y, b.y, c.y),
        most(a.z, b.z, c.z),
    );
    let size = |lo: Native, hi: Native| lo.abs().max(hi.abs());
    let largest = size(lo.x, hi.x).max(size(lo.y, hi.y)).max(size(lo.z, hi.z));
    let pad = Native::splat(PAD) * largest;
    let pad = Vec3Native::new(pad, pad, pad);
    [lo - pad, hi + pad]
}

/// Lanes that hit the triangle at a positive distance, and the hits.
#[inline(always)]
fn intersect_packet<L: Lanes, const AXIS: usize>(
    rays: &RaySetup<L>,
    slot: &LeafTriangle,
) -> Option<HitCandidate<L>> {
    let [a, b, c] = &slot.vertices;
    let corners = [
        rays.shear.relative::<AXIS>(a),
        rays.shear.relative::<AXIS>(b),
        rays.shear.relative::<AXIS>(c),
    ];
    intersect(corners, rays.shear.slopes(), &RaysAndSlot { rays, slot })
}

/// Rays and the triangles against which they are tested, a pair in every lane: the data that are
/// needed if the edge functions do not suffice. It is a trait, because closures would not be
/// inlined.
pub(super) trait Pairing<L: Lanes> {
    /// Entry into and exit from the triangle's own box.
    fn interval(&self) -> TInterval<L>;
    /// Returns true if every ray is within [`SAFE_RANGE`].
    fn in_safe_range(&self) -> bool;
    /// Origins and directions.
    fn rays(&self) -> [Vec3Lanes<L>; 2];
    /// The triangles, as they are stored; and the index of the triangle, if it is one for all
    /// lanes.
    fn stored(&self) -> (&impl Vertices, Option<usize>);
}

/// Greatest coordinate of an origin, greatest largest component of a direction, and greatest
/// reciprocal of that: 2⁴⁰. Beyond it, intermediate numbers of a distance may overflow or vanish,
/// and the reciprocals of the slab test are not those of the directions.
const SAFE_RANGE: f32 = (1u64 << 40) as f32;

#[inline(always)]
fn usual<L: Lanes>(org: Vec3Lanes<L>, along: L) -> L::Mask {
    let (most, least) = (L::splat(SAFE_RANGE), L::splat(1.0 / SAFE_RANGE));
    let size = along.abs();
    org.max_abs().le(most) & size.le(most) & size.ge(least)
}

/// A packet and a triangle in leaf order.
struct RaysAndSlot<'a, L: Lanes> {
    rays: &'a RaySetup<L>,
    slot: &'a LeafTriangle,
}

impl<L: Lanes> Pairing<L> for RaysAndSlot<'_, L> {
    #[inline(always)]
    fn interval(&self) -> TInterval<L> {
        self.rays
            .slabs
            .intersect_box(&prim_aabb(&self.slot.vertices))
    }

    #[inline(always)]
    fn in_safe_range(&self) -> bool {
        self.rays.shear.in_safe_range
    }

    #[inline(always)]
    fn rays(&self) -> [Vec3Lanes<L>; 2] {
        [self.rays.rays.org, self.rays.rays.dir]
    }

    #[inline(always)]
    fn stored(&self) -> (&impl Vertices, Option<usize>) {
        (self.slot, Some(0))
    }
}

/// Projection of a triangle in the frames of rays: the positions of its vertices beside the rays,
/// and the edge functions, which weigh the vertices.
struct EdgeFunctions<L: Lanes> {
    x: [L; 3],
    y: [L; 3],
    u: L,
    v: L,
    w: L,
    /// Lanes whose ray is within all edges.
    inside: L::Mask,
}

/// Computes the edge functions. The vertices are relative to the origin, in the order of the ray's
/// frame. A lane may be a ray against one triangle or a triangle against one ray.
#[inline(always)]
fn edges<L: Lanes>(
    [a, b, c]: &[Vec3Lanes<L>; 3],
    [slope_x, slope_y, _]: [L; 3],
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

/// Lanes in which a ray hits a triangle at a positive distance, and the hits. The vertices are
/// relative to the origin, in the order of the ray's frame, and its slopes and scale are given.
#[inline(always)]
pub(super) fn intersect<L: Lanes>(
    corners: [Vec3Lanes<L>; 3],
    slopes: [L; 3],
    pairs: &impl Pairing<L>,
) -> Option<HitCandidate<L>> {
    let edges = edges(&corners, slopes);
    if !edges.inside.any() {
        return None;
    }
    Some(resolve_hit(edges, corners, slopes, pairs))
}

/// The hits of [`intersect`] without a branch on whether any ray is within all edges, for triangles
/// that most likely are hit.
#[inline(always)]
pub(super) fn intersect_branchless<L: Lanes>(
    corners: [Vec3Lanes<L>; 3],
    slopes: [L; 3],
    pairs: &impl Pairing<L>,
) -> HitCandidate<L> {
    resolve_hit(edges(&corners, slopes), corners, slopes, pairs)
}

/// Computes the distances of rays within all edges.
#[inline(always)]
fn resolve_hit<L: Lanes>(
    edges: EdgeFunctions<L>,
    corners: [Vec3Lanes<L>; 3],
    slopes: [L; 3],
    pairs: &impl Pairing<L>,
) -> HitCandidate<L> {
    let [a, b, c] = corners;
    let by_edges = EdgeDistance::new(&edges, [a.z, b.z, c.z], slopes[2]);
    let (raw, det) = (by_edges.t, by_edges.det);
    // A NaN anywhere above leaves the sum NaN and fails here; so does a triangle seen edge-on.
    let solid = det.lt(L::ZERO) | det.gt(L::ZERO);
    let within = edges.inside & solid;
    let found = HitCandidate {
        valid: within & raw.gt(L::ZERO),
        t: raw,
        v: edges.v,
        w: edges.w,
        det,
    };
    if pairs.in_safe_range() && !(within & !by_edges.clamp_not_needed()).any() {
        return found;
    }
    let vague = within & !by_edges.accurate();
    let t = if vague.any() {
        let (stored, only) = pairs.stored();
        let planes = distance::to_planes(raw, vague, pairs.rays(), stored, only);
        vague.select(planes, raw)
    } else {
        raw
    };
    let (ahead, t) = pairs.interval().clamp(t);
    let valid = within & ahead;
    HitCandidate { valid, t, ..found }
}

#[cfg(test)]
mod tests;
