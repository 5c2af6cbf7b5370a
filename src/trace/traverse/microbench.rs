//! Microbenchmarks: tests in isolation, without a tree, only for benchmarks and instruction counts.
//!
//! Each function prepares packets as a traversal does, and then does the work of a traversal in a
//! node or in a leaf. It uses the same functions, but over all boxes, or over all primitives of a
//! kind as one leaf. Every lane carries a ray. `benches/kernels.rs` compares the results with those
//! of the oracle (`oracle::microbench`).

use crate::bvh::Bvh;
use crate::intersect::aabb::SlabTest;
use crate::intersect::ray_setup::RaySetup;
use crate::intersect::slab_conservative::ConservativeSlabs;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{LaneMask, Lanes};
use crate::traverse::query::{AnyHit, ClosestHit, Query};
use phalanx_scene::PrimKind;

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
    let prims = bvh.leaf_prims();
    match kind {
        PrimKind::Sphere => closest_in(rays, hits, |q, r| q.test_each(r, &prims.spheres)),
        PrimKind::Ellipsoid => closest_in(rays, hits, |q, r| q.test_each(r, &prims.ellipsoids)),
        PrimKind::Triangle => closest_in(rays, hits, |q, r| q.test_triangles(r, &prims.triangles)),
        PrimKind::Cone => closest_in(rays, hits, |q, r| q.test_each(r, &prims.cones)),
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
    let prims = bvh.leaf_prims();
    let triangles = &prims.triangles;
    match kind {
        PrimKind::Sphere => occluded_in(rays, blocked, |q, r| q.test_each(r, &prims.spheres)),
        PrimKind::Ellipsoid => occluded_in(rays, blocked, |q, r| q.test_each(r, &prims.ellipsoids)),
        PrimKind::Triangle => occluded_in(rays, blocked, |q, r| q.test_triangles(r, triangles)),
        PrimKind::Cone => occluded_in(rays, blocked, |q, r| q.test_each(r, &prims.cones)),
    }
}

/// The closest hit of each ray on what `test` tests. It is never inlined, so that every test is
/// compiled by itself: within one function a change of one kind's test changes the register
/// allocation of the others.
#[inline(never)]
fn closest_in<L: Lanes>(
    rays: &[RayPacket<L>],
    hits: &mut [HitPacket<L>],
    test: impl Fn(&mut ClosestHit<L>, &RaySetup<L>) -> bool,
) {
    for (rays, hits) in rays.iter().zip(hits) {
        let mut query = ClosestHit::new(rays.tmax);
        test(&mut query, &RaySetup::new(rays, all_lanes::<L>()));
        *hits = query.hits(rays.tmax, all_lanes::<L>());
    }
}

/// Occlusion of each ray by what `test` tests; as [`closest_in`].
#[inline(never)]
fn occluded_in<L: Lanes>(
    rays: &[RayPacket<L>],
    blocked: &mut [u32],
    test: impl Fn(&mut AnyHit<L>, &RaySetup<L>) -> bool,
) {
    for (rays, blocked) in rays.iter().zip(blocked) {
        let mut query = AnyHit::new(rays.tmax, all_lanes::<L>());
        test(&mut query, &RaySetup::new(rays, all_lanes::<L>()));
        *blocked = query.occluded().bits();
    }
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
