//! One ray against one truncated cone: the formula is explained in `trace::intersect::cone`.

use super::intersect::{OracleHit, OracleRaySetup, min};
use phalanx_scene::Scene;

impl OracleRaySetup {
    /// The ray's hit on the cone at `i`, if it has one at t > 0.
    pub(super) fn cone(&self, scene: &Scene, i: usize, prim_id: u32) -> Option<OracleHit> {
        let interval = self.intersect_box(&scene.prim_bounds(prim_id).padded());
        let frame = scene.cones.frame(i);
        let (org, dir) = (self.ray().org, self.ray().dir);
        let entry = (org - frame.base) + dir * interval.tnear;
        let [right, up, axis] = frame.axes;
        let (dx, dy, dz) = (right.dot(dir), up.dot(dir), axis.dot(dir));
        let (px, py, pz) = (right.dot(entry), up.dot(entry), axis.dot(entry));
        let across = dx * dx + dy * dy;
        let (rho, drho) = (frame.radius + frame.sin * pz, frame.sin * dz);
        let (gx, gy) = (rho * dx - drho * px, rho * dy - drho * py);
        let cross = px * dy - py * dx;
        let gap = (gx * gx + gy * gy) - frame.cos_squared * (cross * cross);
        if gap.is_nan() || gap < 0.0 {
            return None;
        }
        let root = (frame.cos_squared * gap).sqrt();
        let a = frame.cos_squared * across - drho * drho;
        let b = frame.cos_squared * (px * dx + py * dy) - rho * drho;
        let c = frame.cos_squared * (px * px + py * py) - rho * rho;
        let (from_outside, from_inside) = if b >= 0.0 {
            let q = -b - root;
            (q / a, c / q)
        } else {
            let q = root - b;
            (c / q, q / a)
        };
        let valid = |s: f32| {
            let (t, height) = (interval.tnear + s, pz + dz * s);
            let met = height >= 0.0 && height <= frame.length && t > 0.0;
            met.then_some(t)
        };
        let outer = match scene.cones.get(i).inside {
            true => None,
            false => valid(from_outside),
        };
        let raw = match (outer, valid(from_inside)) {
            (Some(a), Some(b)) => min(a, b),
            (a, b) => a.or(b)?,
        };
        let t = interval.clamp(raw)?;
        Some(OracleHit {
            t,
            u: 0.0,
            v: 0.0,
            prim_id,
        })
    }
}
