//! Rays against one sphere or ellipsoid: Haines, Günther and Akenine-Möller, "Precision
//! Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019.
//!
//! This is the design document's quadratic, in a form that does not cancel. If the sphere is small
//! or far, the discriminant comes from the distance between centre and ray. If b² ≫ ac, the second
//! root comes from c/q. An ellipsoid is the unit sphere hit by the ray in object space; distances
//! along the ray are the same there.

use super::aabb::{RaySlabs, TInterval};
use super::hit::HitRecord;
use crate::bvh::{LeafEllipsoid, LeafSphere};
use crate::simd::{LaneMask, Lanes, Vec3Lanes};

/// Updates `best` with a closer hit on the sphere.
#[inline(always)]
pub(crate) fn closest<L: Lanes>(
    org: Vec3Lanes<L>,
    dir: Vec3Lanes<L>,
    slabs: &RaySlabs<L>,
    slot: &LeafSphere,
    best: &mut HitRecord<L>,
) {
    if let Some((meets, t)) = sphere(
        org,
        dir,
        slabs,
        (&slot.center, slot.radius),
        &slot.prim_aabb,
    ) {
        best.update_t(meets, t, slot.prim_id);
    }
}

/// Updates `best` with a closer hit on the ellipsoid.
#[inline(always)]
pub(crate) fn closest_ellipsoid<L: Lanes>(
    org: Vec3Lanes<L>,
    dir: Vec3Lanes<L>,
    slabs: &RaySlabs<L>,
    slot: &LeafEllipsoid,
    best: &mut HitRecord<L>,
) {
    if let Some((meets, t)) = ellipsoid(org, dir, slabs, slot) {
        best.update_t(meets, t, slot.prim_id);
    }
}

/// Lanes that the sphere stops before `tmax`.
#[inline(always)]
pub(crate) fn occluded<L: Lanes>(
    org: Vec3Lanes<L>,
    dir: Vec3Lanes<L>,
    slabs: &RaySlabs<L>,
    slot: &LeafSphere,
    tmax: L,
) -> L::Mask {
    sphere(
        org,
        dir,
        slabs,
        (&slot.center, slot.radius),
        &slot.prim_aabb,
    )
    .map_or_else(L::Mask::none, |(meets, t)| meets & t.lt(tmax))
}

/// Lanes that the ellipsoid stops before `tmax`.
#[inline(always)]
pub(crate) fn occluded_ellipsoid<L: Lanes>(
    org: Vec3Lanes<L>,
    dir: Vec3Lanes<L>,
    slabs: &RaySlabs<L>,
    slot: &LeafEllipsoid,
    tmax: L,
) -> L::Mask {
    ellipsoid(org, dir, slabs, slot).map_or_else(L::Mask::none, |(meets, t)| meets & t.lt(tmax))
}

/// Lanes that hit the sphere at a positive distance, and the distances.
#[inline(always)]
pub(crate) fn sphere<L: Lanes>(
    org: Vec3Lanes<L>,
    dir: Vec3Lanes<L>,
    slabs: &RaySlabs<L>,
    (center, radius): (&[f32; 3], f32),
    prim_aabb: &[[f32; 3]; 2],
) -> Option<(L::Mask, L)> {
    let [x, y, z] = *center;
    let from_center = org - Vec3Lanes::splat(x, y, z);
    let roots = roots(from_center, dir, L::splat(radius))?;
    Some(nearest(roots, slabs.intersect_box(prim_aabb)))
}

#[inline(always)]
fn ellipsoid<L: Lanes>(
    org: Vec3Lanes<L>,
    dir: Vec3Lanes<L>,
    slabs: &RaySlabs<L>,
    slot: &LeafEllipsoid,
) -> Option<(L::Mask, L)> {
    let [x, y, z, shift] = slot.to_object.map(|c| Vec3Lanes::splat(c[0], c[1], c[2]));
    let rotate = |v: Vec3Lanes<L>| (x.scale(v.x) + y.scale(v.y)) + z.scale(v.z);
    let roots = roots(rotate(org) + shift, rotate(dir), L::ONE)?;
    Some(nearest(roots, slabs.intersect_box(&slot.prim_aabb)))
}

/// Both roots, smaller first, and the lanes that have any. `from_center` is origin − centre.
#[inline(always)]
pub(crate) fn roots<L: Lanes>(
    from_center: Vec3Lanes<L>,
    dir: Vec3Lanes<L>,
    radius: L,
) -> Option<(L::Mask, L, L)> {
    let f = from_center;
    let a = dir.dot(dir);
    let b = -f.dot(dir);
    let rr = radius * radius;
    // From the centre to the point of the ray closest to it.
    let l = f + dir.scale(b / a);
    let gap = rr - l.dot(l);
    let meets = gap.ge(L::ZERO);
    if !meets.any() {
        return None;
    }
    let c = f.dot(f) - rr;
    let root = (a * gap).sqrt();
    let q = b.lt(L::ZERO).select(b - root, b + root);
    let (t0, t1) = (c / q, q / a);
    Some((meets, t0.min(t1), t0.max(t1)))
}

/// The smallest root above zero, clamped to the interval of the own box.
#[inline(always)]
pub(crate) fn nearest<L: Lanes>(
    (meets, near, far): (L::Mask, L, L),
    interval: TInterval<L>,
) -> (L::Mask, L) {
    let raw = near.gt(L::ZERO).select(near, far);
    let (ahead, t) = interval.clamp(raw);
    (meets & ahead, t)
}
