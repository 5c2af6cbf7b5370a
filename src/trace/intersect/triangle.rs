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
//! - The edge functions have no double-precision fallback; zeros are accepted on both sides
//!   instead.
//! - There is no culling, and no swap of axes for winding.
//! - Slopes are products with the reciprocal that the distance needs anyway.
//! - Where the edge functions are not accurate enough, the distance is that to the plane, and where
//!   that may be far from the triangle's own box, it is clamped to the ray's interval in it (see
//!   [`distance`]).
//!
//! The design notes proposed edge functions (a − o) × (b − o) · d. Those have exact signs along an
//! edge. But at a vertex shared by n triangles their n rounding errors are independent, and all can
//! fall on the same side. Of 20,000 rays aimed at the vertices of a sphere mesh, that form lost
//! 521, this one none.

mod distance;
mod edges;

use super::aabb::TInterval;
use super::hit::HitCandidate;
use super::leaf_prim::{Candidates, LeafPrim};
use super::ray_setup::RaySetup;
use super::shear::{MIXED, Vertices};
use crate::bvh::leaf::LeafTriangle;
use crate::simd::{LaneMask, Lanes, Native, Vec3Lanes, Vec3Native};
use bytemuck::TransparentWrapper;
use distance::EdgeDistance;
pub(crate) use distance::to_own_planes;
use edges::{EdgeFunctions, edges};
use glam::Vec3;
use phalanx_scene::{Bounds, PAD};

/// A triangle for rays whose dominant axis is `AXIS`, or [`MIXED`].
#[derive(Clone, Copy, TransparentWrapper)]
#[repr(transparent)]
pub(crate) struct TriangleAlong<const AXIS: usize>(LeafTriangle);

impl<const AXIS: usize> LeafPrim for TriangleAlong<AXIS> {
    #[inline(always)]
    fn prim_id(&self) -> u32 {
        self.0.prim_id
    }

    #[inline(always)]
    fn intersect<L: Lanes, const FAR: bool>(&self, rays: &RaySetup<L>, _: L) -> Candidates<L> {
        if FAR {
            return None;
        }
        let slot = &self.0;
        let corners = slot.vertices.each_ref();
        let corners = corners.map(|corner| rays.shear.relative::<AXIS>(corner));
        intersect(corners, rays.shear.slopes(), &RaysAndSlot { rays, slot })
    }
}

/// A triangle for any rays.
impl LeafPrim for LeafTriangle {
    #[inline(always)]
    fn prim_id(&self) -> u32 {
        self.prim_id
    }

    #[inline(always)]
    fn intersect<L: Lanes, const FAR: bool>(&self, rays: &RaySetup<L>, _: L) -> Candidates<L> {
        if FAR {
            return None;
        }
        let (shear, slot) = (&rays.shear, self);
        let corners = match shear.axis {
            MIXED => shear.less_origins::<true>(slot, 0),
            _ => shear.less_origins::<false>(slot, 0),
        };
        intersect(corners, shear.slopes(), &RaysAndSlot { rays, slot })
    }
}

/// The triangle's own padded box.
#[inline(always)]
pub(crate) fn prim_aabb(corners: &[[f32; 3]; 3]) -> [[f32; 3]; 2] {
    let [a, b, c] = corners.map(Vec3::from_array);
    let own = Bounds::new(a.min(b).min(c), a.max(b).max(c)).padded();
    [own.lo.to_array(), own.hi.to_array()]
}

/// The padded boxes of the triangles of a block: the arithmetic of
/// [`phalanx_scene::Bounds::padded`].
#[inline(always)]
pub(crate) fn prim_aabbs([a, b, c]: [Vec3Native; 3]) -> [Vec3Native; 2] {
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

/// Rays and the triangles against which they are tested, one pair per lane: the data needed if the
/// edge functions do not suffice. A trait, because closures would not be inlined.
pub(crate) trait Pairing<L: Lanes> {
    /// Entry into and exit from the triangle's own box.
    fn interval(&self) -> TInterval<L>;
    /// Origins and directions.
    fn rays(&self) -> [Vec3Lanes<L>; 2];
    /// The stored triangles, and the index of the triangle if all lanes share one.
    fn stored(&self) -> (&impl Vertices, Option<usize>);
    /// `raw`, replaced in `vague` lanes by the distances to the planes of the stored triangles.
    #[inline(always)]
    fn to_planes(&self, raw: L, vague: L::Mask) -> L {
        let (stored, only) = self.stored();
        let planes = distance::to_planes(raw, vague, self.rays(), stored, only);
        vague.select(planes, raw)
    }
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
    fn rays(&self) -> [Vec3Lanes<L>; 2] {
        [self.rays.rays.org, self.rays.rays.dir]
    }

    #[inline(always)]
    fn stored(&self) -> (&impl Vertices, Option<usize>) {
        (self.slot, Some(0))
    }
}

/// Lanes in which a ray hits a triangle at a positive distance, and the hits. The vertices are
/// relative to the origin, in the order of the ray's frame, and its
/// [slopes](super::shear::Shear::slopes) are given.
#[inline(always)]
pub(crate) fn intersect<L: Lanes>(
    corners: [Vec3Lanes<L>; 3],
    slopes: [L; 4],
    pairs: &impl Pairing<L>,
) -> Option<HitCandidate<L>> {
    let edges = edges(&corners, slopes);
    if !edges.inside.any() {
        return None;
    }
    Some(resolve_hit(edges, corners, slopes, pairs))
}

/// The hits of [`intersect`], without a branch on whether any ray is within all edges, for
/// triangles that are likely hit.
#[inline(always)]
pub(crate) fn intersect_branchless<L: Lanes>(
    corners: [Vec3Lanes<L>; 3],
    slopes: [L; 4],
    pairs: &impl Pairing<L>,
) -> HitCandidate<L> {
    resolve_hit(edges(&corners, slopes), corners, slopes, pairs)
}

/// Computes the distances of rays within all edges.
#[inline(always)]
fn resolve_hit<L: Lanes>(
    edges: EdgeFunctions<L>,
    corners: [Vec3Lanes<L>; 3],
    slopes: [L; 4],
    pairs: &impl Pairing<L>,
) -> HitCandidate<L> {
    let [a, b, c] = corners;
    let by_edges = EdgeDistance::new(&edges, [a.z, b.z, c.z], slopes);
    let (raw, det) = (by_edges.t, by_edges.det);
    // A NaN anywhere above leaves the sum NaN and fails here; so does a triangle seen edge-on.
    let solid = det.lt(L::ZERO) | det.gt(L::ZERO);
    let within = edges.inside & solid;
    let candidate = HitCandidate {
        valid: within & raw.gt(L::ZERO),
        t: raw,
        v: edges.v,
        w: edges.w,
        det,
    };
    let vague = within & !by_edges.accurate;
    if !vague.any() {
        return candidate;
    }
    let t = pairs.to_planes(raw, vague);
    let candidate = HitCandidate {
        valid: within & t.gt(L::ZERO) & t.lt(L::splat(f32::INFINITY)),
        t,
        ..candidate
    };
    let far = vague & !by_edges.in_box();
    if !far.any() {
        return candidate;
    }
    let (ahead, t) = pairs.interval().clamp(t);
    HitCandidate {
        valid: (far & ahead) | (candidate.valid & !far),
        t: far.select(t, candidate.t),
        ..candidate
    }
}

#[cfg(test)]
mod tests;
