//! Eight rays against one sphere or ellipsoid: Haines, Günther and Akenine-Möller, "Precision Improvements for
//! Ray/Sphere Intersection", Ray Tracing Gems, 2019.
//!
//! The design document's quadratic, in the form that cancels neither when the sphere is small or far (the discriminant
//! from the distance between centre and ray) nor when b² ≫ ac (the second root from c/q). An ellipsoid is the unit
//! sphere met by the ray in object space; distances along the ray are the same there.

use super::aabb::{Slabs, Stay};
use super::packet::Best;
use crate::bvh::{EllipsoidSlot, SphereSlot};
use crate::lanes::{F32x8, Mask8, U32x8, Vec3x8};

/// Keeps what is closer than `best` on the sphere.
#[inline(always)]
pub(super) fn closest(org: Vec3x8, dir: Vec3x8, slabs: &Slabs, slot: &SphereSlot, best: &mut Best) {
    if let Some((meets, t)) = sphere(org, dir, slabs, slot) {
        best.take(meets, t, slot.prim_id);
    }
}

/// Keeps what is closer than `best` on the ellipsoid.
#[inline(always)]
pub(super) fn closest_ellipsoid(
    org: Vec3x8,
    dir: Vec3x8,
    slabs: &Slabs,
    slot: &EllipsoidSlot,
    best: &mut Best,
) {
    if let Some((meets, t)) = ellipsoid(org, dir, slabs, slot) {
        best.take(meets, t, slot.prim_id);
    }
}

/// Lanes that the sphere stops before `tmax`.
#[inline(always)]
pub(super) fn occluded(
    org: Vec3x8,
    dir: Vec3x8,
    slabs: &Slabs,
    slot: &SphereSlot,
    tmax: F32x8,
) -> Mask8 {
    sphere(org, dir, slabs, slot).map_or_else(Mask8::none, |(meets, t)| meets & t.lt(tmax))
}

/// Lanes that the ellipsoid stops before `tmax`.
#[inline(always)]
pub(super) fn occluded_ellipsoid(
    org: Vec3x8,
    dir: Vec3x8,
    slabs: &Slabs,
    slot: &EllipsoidSlot,
    tmax: F32x8,
) -> Mask8 {
    ellipsoid(org, dir, slabs, slot).map_or_else(Mask8::none, |(meets, t)| meets & t.lt(tmax))
}

#[inline(always)]
fn sphere(org: Vec3x8, dir: Vec3x8, slabs: &Slabs, slot: &SphereSlot) -> Option<(Mask8, F32x8)> {
    let [x, y, z] = slot.center;
    let from_center = org - Vec3x8::splat(x, y, z);
    let roots = roots(from_center, dir, F32x8::splat(slot.radius))?;
    Some(nearest(roots, slabs.stay(&slot.own_box)))
}

#[inline(always)]
fn ellipsoid(
    org: Vec3x8,
    dir: Vec3x8,
    slabs: &Slabs,
    slot: &EllipsoidSlot,
) -> Option<(Mask8, F32x8)> {
    let [x, y, z, shift] = slot.to_object.map(|c| Vec3x8::splat(c[0], c[1], c[2]));
    let rotate = |v: Vec3x8| (x.scale(v.x) + y.scale(v.y)) + z.scale(v.z);
    let roots = roots(rotate(org) + shift, rotate(dir), F32x8::ONE)?;
    Some(nearest(roots, slabs.stay(&slot.own_box)))
}

/// Both roots, smaller first, and the lanes that have any. `from_center` is origin − centre.
#[inline(always)]
fn roots(from_center: Vec3x8, dir: Vec3x8, radius: F32x8) -> Option<(Mask8, F32x8, F32x8)> {
    let f = from_center;
    let a = dir.dot(dir);
    let b = -f.dot(dir);
    let rr = radius * radius;
    // From the centre to the point of the ray closest to it.
    let l = f + dir.scale(b / a);
    let gap = rr - l.dot(l);
    let meets = gap.ge(F32x8::ZERO);
    if !meets.any() {
        return None;
    }
    let c = f.dot(f) - rr;
    let root = (a * gap).sqrt();
    let q = b.lt(F32x8::ZERO).select(b - root, b + root);
    let (t0, t1) = (c / q, q / a);
    Some((meets, t0.min(t1), t0.max(t1)))
}

/// The smallest root above zero, clamped to the stay in the own box.
#[inline(always)]
fn nearest((meets, near, far): (Mask8, F32x8, F32x8), stay: Stay) -> (Mask8, F32x8) {
    let raw = near.gt(F32x8::ZERO).select(near, far);
    let t = raw.max(stay.enter).min(stay.leave);
    let ahead = raw.gt(F32x8::ZERO) & t.gt(F32x8::ZERO);
    (meets & ahead & stay.enter.le(stay.leave), t)
}

impl Best {
    /// Takes a hit without barycentric weights where it is closer, or as close with a smaller number.
    #[inline(always)]
    fn take(&mut self, valid: Mask8, t: F32x8, prim_id: u32) {
        let id = U32x8::splat(prim_id);
        let take = valid & (t.lt(self.t) | (t.eq(self.t) & id.lt(self.prim_id)));
        self.t = take.select(t, self.t);
        self.u = take.select(F32x8::ZERO, self.u);
        self.v = take.select(F32x8::ZERO, self.v);
        self.prim_id = take.select_u32(id, self.prim_id);
    }
}
