//! Microbenchmarks: tests in isolation, without a tree, only for benchmarks and instruction counts.
//!
//! Each function prepares packets as a traversal does, and then does the work of a traversal in a
//! node or in a leaf. It uses the same functions, but over all boxes, or over all primitives of a
//! kind as one leaf. Every lane carries a ray. `benches/kernels.rs` compares the results with those
//! of the oracle (`oracle::microbench`).

use crate::bvh::{Bvh, LeafKind};
use crate::intersect::aabb::SlabTest;
use crate::intersect::ray_setup::RaySetup;
use crate::intersect::slab_conservative::ConservativeSlabs;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{LaneMask, Lanes};
use crate::traverse::query::{AnyHit, ClosestHit, Query};
use phalanx_scene::PrimKind;
use std::ops::Range;

/// Number of pairs of a ray and a box (lower and upper corner) that intersect before the ray's
/// `tmax`.
///
/// Packets whose directions agree in sign take the same-octant test and others the mixed one.
pub(super) fn boxes<L: Lanes>(rays: &[RayPacket<L>], boxes: &[[[f32; 3]; 2]]) -> u64 {
    let mut met = 0;
    for rays in rays {
        let slabs = RaySetup::new(rays, all_lanes::<L>()).slabs;
        let cull = ConservativeSlabs::new(rays, &slabs);
        met += match slabs.octant {
            Some(near) => count_hits::<L>(boxes, |b| {
                cull.intersect_box_same_octant(b, near).overlaps(rays.tmax)
            }),
            None => count_hits::<L>(boxes, |b| cull.intersect_box_mixed(b).overlaps(rays.tmax)),
        };
    }
    met
}

/// The closest hit below `tmax` of each ray on a tree's primitives of one kind; `hits` takes a
/// packet for each of `rays`.
pub(super) fn closest<L: Lanes>(
    bvh: &Bvh,
    kind: PrimKind,
    rays: &[RayPacket<L>],
    hits: &mut [HitPacket<L>],
) {
    match kind {
        PrimKind::Sphere => closest_in::<L, SPHERE, true>(bvh, rays, hits),
        PrimKind::Ellipsoid => closest_in::<L, ELLIPSOID, true>(bvh, rays, hits),
        PrimKind::Triangle => closest_in::<L, TRIANGLE, true>(bvh, rays, hits),
        PrimKind::Cone => closest_in::<L, CONE, false>(bvh, rays, hits),
    }
}

/// Rays (lanes as bits, a word for each packet) that one of a tree's primitives of one kind stops
/// before their `tmax`.
pub(super) fn occluded<L: Lanes>(
    bvh: &Bvh,
    kind: PrimKind,
    rays: &[RayPacket<L>],
    blocked: &mut [u32],
) {
    match kind {
        PrimKind::Sphere => occluded_in::<L, SPHERE, true>(bvh, rays, blocked),
        PrimKind::Ellipsoid => occluded_in::<L, ELLIPSOID, true>(bvh, rays, blocked),
        PrimKind::Triangle => occluded_in::<L, TRIANGLE, true>(bvh, rays, blocked),
        PrimKind::Cone => occluded_in::<L, CONE, false>(bvh, rays, blocked),
    }
}

const SPHERE: u32 = PrimKind::Sphere as u32;
const ELLIPSOID: u32 = PrimKind::Ellipsoid as u32;
const TRIANGLE: u32 = PrimKind::Triangle as u32;
const CONE: u32 = PrimKind::Cone as u32;

/// The closest hit of each ray on a tree's primitives of kind `KIND`. The kind is a parameter and
/// the function is never inlined, so that every test is compiled by itself: within one function a
/// change of one kind's test changes the register allocation of the others. `NO_CONES_OR_INSTANCES`
/// means the same as in a traversal: no cones.
#[inline(never)]
fn closest_in<L: Lanes, const KIND: u32, const NO_CONES_OR_INSTANCES: bool>(
    bvh: &Bvh,
    rays: &[RayPacket<L>],
    hits: &mut [HitPacket<L>],
) {
    let (kind, all) = leaf_of_all::<KIND>(bvh);
    for (rays, hits) in rays.iter().zip(hits) {
        let prepared = RaySetup::new(rays, all_lanes::<L>());
        let mut query = ClosestHit::new(rays.tmax);
        query.intersect_leaf::<NO_CONES_OR_INSTANCES>(bvh, &prepared, kind, all.clone());
        *hits = query.hits(rays.tmax, all_lanes::<L>());
    }
}

/// Occlusion of each ray by a tree's primitives of kind `KIND`; as [`closest_in`].
#[inline(never)]
fn occluded_in<L: Lanes, const KIND: u32, const NO_CONES_OR_INSTANCES: bool>(
    bvh: &Bvh,
    rays: &[RayPacket<L>],
    blocked: &mut [u32],
) {
    let (kind, all) = leaf_of_all::<KIND>(bvh);
    for (rays, blocked) in rays.iter().zip(blocked) {
        let prepared = RaySetup::new(rays, all_lanes::<L>());
        let mut query = AnyHit::new(rays.tmax, all_lanes::<L>());
        query.intersect_leaf::<NO_CONES_OR_INSTANCES>(bvh, &prepared, kind, all.clone());
        *blocked = query.occluded().bits();
    }
}

/// All primitives of a kind as one leaf.
#[inline(always)]
fn leaf_of_all<const KIND: u32>(bvh: &Bvh) -> (LeafKind, Range<usize>) {
    let kind = PrimKind::from_number(KIND);
    let kind = LeafKind::Prim(kind);
    (kind, 0..bvh.count(kind))
}

/// Every lane.
#[inline(always)]
fn all_lanes<L: Lanes>() -> L::Mask {
    L::Mask::splat(true)
}

#[inline(always)]
fn count_hits<L: Lanes>(
    boxes: &[[[f32; 3]; 2]],
    within: impl Fn(&[[f32; 3]; 2]) -> L::Mask,
) -> u64 {
    let mut met = 0;
    for corners in boxes {
        met += u64::from(within(corners).bits().count_ones());
    }
    met
}
