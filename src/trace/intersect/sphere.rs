//! Rays against one sphere or ellipsoid: Haines, Günther and Akenine-Möller, "Precision
//! Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019.
//!
//! This is the design document's quadratic, in a form that does not cancel. If the sphere is small
//! or far, the discriminant comes from the distance between centre and ray. If b² ≫ ac, the second
//! root comes from c/q. An ellipsoid is the unit sphere hit by the ray in object space; distances
//! along the ray are the same there.

use super::aabb::TInterval;
use super::hit::HitCandidate;
use super::leaf_prim::{Candidates, LeafPrim};
use super::ray_setup::RaySetup;
use crate::bvh::leaf::{LeafEllipsoid, LeafSphere};
use crate::simd::{LaneMask, Lanes, Vec3Lanes};

impl LeafPrim for LeafSphere {
    #[inline(always)]
    fn prim_id(&self) -> u32 {
        self.prim_id
    }

    #[inline(always)]
    fn intersect<L: Lanes, const FAR: bool>(&self, rays: &RaySetup<L>, _: L) -> Candidates<L> {
        let [x, y, z] = self.center;
        let from_center = rays.rays.org - Vec3Lanes::splat(x, y, z);
        let roots = roots(from_center, rays.rays.dir, L::splat(self.radius))?;
        let interval = rays.slabs.intersect_box(&self.prim_aabb);
        let (valid, t) = root_ahead::<L, FAR>(roots, interval);
        Some(HitCandidate::without_uv(valid, t))
    }
}

impl LeafPrim for LeafEllipsoid {
    #[inline(always)]
    fn prim_id(&self) -> u32 {
        self.prim_id
    }

    #[inline(always)]
    fn intersect<L: Lanes, const FAR: bool>(&self, rays: &RaySetup<L>, _: L) -> Candidates<L> {
        let [x, y, z, shift] = self.to_object.map(|c| Vec3Lanes::splat(c[0], c[1], c[2]));
        let rotate = |v: Vec3Lanes<L>| (x.scale(v.x) + y.scale(v.y)) + z.scale(v.z);
        let (org, dir) = (rotate(rays.rays.org) + shift, rotate(rays.rays.dir));
        let roots = roots(org, dir, L::ONE)?;
        let interval = rays.slabs.intersect_box(&self.prim_aabb);
        let (valid, t) = root_ahead::<L, FAR>(roots, interval);
        Some(HitCandidate::without_uv(valid, t))
    }
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

/// The smallest root above zero, or with `FAR` the other one where that is above zero, too; clamped
/// to the interval of the own box.
#[inline(always)]
pub(crate) fn root_ahead<L: Lanes, const FAR: bool>(
    (meets, near, far): (L::Mask, L, L),
    interval: TInterval<L>,
) -> (L::Mask, L) {
    let enters = near.gt(L::ZERO);
    let (meets, raw) = if FAR { (meets & enters, far) } else { (meets, enters.select(near, far)) };
    let (ahead, t) = interval.clamp(raw);
    (meets & ahead, t)
}
