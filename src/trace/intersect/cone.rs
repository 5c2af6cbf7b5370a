//! Rays against one truncated cone or cylinder, open at both ends.
//!
//! In the cone's own coordinates ([`ConeFrame`](phalanx_scene::ConeFrame)), with p = (x, y) and
//! ρ(z) = radius + sin·z, the cone is cos²·p² = ρ². A ray p + s·p', z + s·z' meets it where a·s² +
//! 2b·s + c = 0, with
//!
//! - a = cos²·p'·p' − ρ'², b = cos²·p·p' − ρ·ρ', c = cos²·p·p − ρ²,
//! - b² − a·c = cos²·(|ρ·p' − ρ'·p|² − cos²·(p × p')²), which is the same for any origin of s along
//!   the ray.
//!
//! No term may cancel if the cone is far or thin (Haines, Günther and Akenine-Möller, "Precision
//! Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019). So s is not measured from
//! the ray's origin but from the point where the ray enters the cone's own box. That makes all
//! coordinates as small as the box. The discriminant is that difference of squares of lengths, and
//! not that of b² and a·c, which vanishes if the cone is thin. The second root comes from c/q.
//! Measured against f64, distances are within 1 ulp of origin and cone, up to the surface's slope.
//!
//! Half the derivative at a root is b + a·s = ∓√(b² − a·c). Its sign is that of the ray's direction
//! along the outward normal: −√ is a hit from outside and +√ one from inside, whatever the sign of
//! a. A ray along the surface's lines has a = 0 and one root at infinity, which is not a valid
//! height. A ray within the surface has a NaN for a root. The mirrored cone beyond the tip lies
//! above or below the two ends.

use super::hit::HitCandidate;
use super::leaf_prim::{Candidates, LeafPrim};
use super::ray_setup::RaySetup;
use crate::bvh::leaf::LeafCone;
use crate::packet::RayPacket;
use crate::simd::{LaneMask, Lanes, Vec3Lanes};

impl LeafPrim for LeafCone {
    #[inline(always)]
    fn prim_id(&self) -> u32 {
        self.prim_id
    }

    /// The hit ahead, clamped to the interval of the own box. Lanes that enter the box beyond
    /// `limit` are left out.
    #[inline(always)]
    fn intersect<L: Lanes, const FAR: bool>(&self, rays: &RaySetup<L>, limit: L) -> Candidates<L> {
        let interval = rays.slabs.intersect_box(&self.prim_aabb);
        if !interval.overlaps(limit).any() {
            return None;
        }
        let RayPacket { org, dir, .. } = rays.rays;
        let [x, y, z] = self.base;
        let entry = (org - Vec3Lanes::splat(x, y, z)) + dir.scale(interval.tnear);
        let [right, up, axis] = self.axes.map(|a| Vec3Lanes::splat(a[0], a[1], a[2]));
        let (dx, dy, dz) = (right.dot(dir), up.dot(dir), axis.dot(dir));
        let (px, py, pz) = (right.dot(entry), up.dot(entry), axis.dot(entry));
        let across = dx * dx + dy * dy;
        let (sin, cos2) = (L::splat(self.sin), L::splat(self.cos_squared));
        let (rho, drho) = (L::splat(self.radius) + sin * pz, sin * dz);
        let (gx, gy) = (rho * dx - drho * px, rho * dy - drho * py);
        let cross = px * dy - py * dx;
        let gap = (gx * gx + gy * gy) - cos2 * (cross * cross);
        let meets = gap.ge(L::ZERO) & interval.overlaps(limit);
        if !meets.any() {
            return None;
        }
        let root = (cos2 * gap).sqrt();
        let a = cos2 * across - drho * drho;
        let b = cos2 * (px * dx + py * dy) - rho * drho;
        let c = cos2 * (px * px + py * py) - rho * rho;
        // From outside (−b − √)/a, from inside (−b + √)/a; the one of the two that cancels is c/q.
        let ahead = b.ge(L::ZERO);
        let q = ahead.select(-b - root, root - b);
        let (by_a, by_c) = (q / a, c / q);
        let from_outside = ahead.select(by_a, by_c);
        let from_inside = ahead.select(by_c, by_a);
        let length = L::splat(self.length);
        let valid = |s: L| {
            let (t, height) = (interval.tnear + s, pz + dz * s);
            let between = height.ge(L::ZERO) & height.le(length);
            (between & t.gt(L::ZERO), t)
        };
        let (outer, t_outer) = valid(from_outside);
        let (inner, t_inner) = valid(from_inside);
        let outer = outer & L::Mask::splat(self.inside == 0);
        let (counts, raw) = if FAR {
            (outer & inner, t_outer.max(t_inner))
        } else {
            let far = L::splat(f32::INFINITY);
            let nearer = outer.select(t_outer, far).min(inner.select(t_inner, far));
            (outer | inner, nearer)
        };
        let t = raw.max(interval.tnear).min(interval.tfar);
        let valid = meets & counts & t.gt(L::ZERO);
        Some(HitCandidate::without_uv(valid, t))
    }
}
