//! Rays, their hits, and one ray against a box, in plain f32.

use glam::Vec3;
use phalanx_scene::{Bounds, PAD, Scene, SurfaceHit};

/// A ray: hits count for t > 0 in units of `dir`. It has no end of its own:
/// [`Oracle::occluded`](crate::Oracle::occluded) takes one.
#[derive(Clone, Copy, Debug)]
pub struct OracleRay {
    /// Origin.
    pub org: Vec3,
    /// Direction, of any length.
    pub dir: Vec3,
}

impl OracleRay {
    /// Makes a ray.
    ///
    /// ```
    /// # mod phalanx { pub use {glam, phalanx_oracle as oracle, phalanx_scene::*}; }
    /// use phalanx::glam::Vec3;
    /// use phalanx::oracle::OracleRay;
    ///
    /// assert_eq!(OracleRay::new(Vec3::ZERO, Vec3::Z).dir, Vec3::Z);
    /// ```
    pub fn new(org: Vec3, dir: Vec3) -> OracleRay {
        OracleRay { org, dir }
    }
}

/// A ray's hit, with `u` and `v` of 0 on anything but a triangle. A miss is no `OracleHit`, but
/// `None`.
pub type OracleHit = SurfaceHit;

/// Replaces `best` by a hit that comes after `after`, but before `best`.
pub(super) fn update_next(hit: OracleHit, after: &OracleHit, best: &mut Option<OracleHit>) {
    let precedes = best.is_none_or(|best| (hit.t, hit.prim_id) < (best.t, best.prim_id));
    if is_after(&hit, after) && precedes {
        *best = Some(hit);
    }
}

/// Returns true if a hit comes after another, by (t, prim_id).
pub(super) fn is_after(hit: &OracleHit, after: &OracleHit) -> bool {
    (hit.t, hit.prim_id) > (after.t, after.prim_id)
}

/// `minps` and `maxps`: a NaN in the first operand gives the second.
pub(super) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

pub(super) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Largest absolute component.
pub(super) fn max_abs(v: Vec3) -> f32 {
    let v = v.abs();
    max(max(v.x, v.y), v.z)
}

/// A ray with the values that its tests derive from it once.
#[derive(Clone, Copy, Debug)]
pub(super) struct OracleRaySetup {
    pub(super) ray: OracleRay,
    rdir: Vec3,
    org_lo: Vec3,
    org_hi: Vec3,
    /// Axes of the sheared frame, its origin, and the slopes against the dominant axis.
    pub(super) axes: [usize; 3],
    pub(super) sheared_org: Vec3,
    pub(super) slope_x: f32,
    pub(super) slope_y: f32,
    pub(super) scale: f32,
    /// The larger slope; infinite if the ray is so large or so small that intermediate numbers may
    /// overflow or vanish.
    pub(super) steepness: f32,
}

/// Factor on the distance up to which boxes are searched: a triangle's hit may be outside the ray's
/// interval in its box by half as much.
pub(super) const REACH: f32 = 1.0 + 1.0 / 4096.0;

/// The distances at which a ray enters (not before 0) and leaves a box.
#[derive(Clone, Copy)]
pub(super) struct OracleInterval {
    pub(super) tnear: f32,
    pub(super) tfar: f32,
}

impl OracleInterval {
    /// Returns true if the ray is in the box somewhere between 0 and `best`, or a little beyond.
    pub(super) fn overlaps(self, best: f32) -> bool {
        self.tnear <= min(self.tfar, best * REACH)
    }

    /// Returns true if the ray has left the box well before `start`.
    pub(super) fn ends_before(self, start: f32) -> bool {
        self.tfar * REACH < start
    }

    /// Clamps a distance to this interval of the primitive's own box; none if it is not ahead of
    /// the origin, or infinite.
    pub(super) fn clamp(self, raw: f32) -> Option<f32> {
        let t = min(max(raw, self.tnear), self.tfar);
        (raw > 0.0 && t > 0.0 && t < f32::INFINITY && self.tnear <= self.tfar).then_some(t)
    }
}

/// Least size of a direction's component when it is inverted; smaller ones count as this.
const MIN_DIRECTION: f32 = f32::from_bits((127 - 80) << 23);

/// Limit on the coordinates of an origin, on the largest component of a direction, and on its
/// reciprocal.
const SAFE_RANGE: f32 = (1u64 << 40) as f32;

fn reciprocal(x: f32) -> f32 {
    let safe = if x.abs() < MIN_DIRECTION {
        if x < 0.0 { -MIN_DIRECTION } else { MIN_DIRECTION }
    } else {
        x
    };
    1.0 / safe
}

impl OracleRaySetup {
    pub(super) fn new(ray: &OracleRay) -> OracleRaySetup {
        let (org, dir) = (ray.org, ray.dir);
        let pad = Vec3::splat(max_abs(org) * PAD);
        let size = dir.abs();
        let axes = if size.x >= size.y && size.x >= size.z {
            [1, 2, 0]
        } else if size.y >= size.z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let d = axes.map(|k| dir[k]);
        let scale = 1.0 / d[2];
        let (slope_x, slope_y) = (d[0] * scale, d[1] * scale);
        let usual =
            max_abs(org) <= SAFE_RANGE && (1.0 / SAFE_RANGE..=SAFE_RANGE).contains(&d[2].abs());
        OracleRaySetup {
            ray: *ray,
            rdir: Vec3::new(reciprocal(dir.x), reciprocal(dir.y), reciprocal(dir.z)),
            org_lo: org - pad,
            org_hi: org + pad,
            axes,
            sheared_org: Vec3::from_array(axes.map(|k| org[k])),
            slope_x,
            slope_y,
            scale,
            steepness: if usual { max(slope_x.abs(), slope_y.abs()) } else { f32::INFINITY },
        }
    }

    /// The slab test.
    #[inline]
    pub(super) fn intersect_box(&self, b: &Bounds) -> OracleInterval {
        let t0 = (b.lo - self.org_hi) * self.rdir;
        let t1 = (b.hi - self.org_lo) * self.rdir;
        let enter = max(max(min(t0.x, t1.x), min(t0.y, t1.y)), min(t0.z, t1.z));
        let leave = min(min(max(t0.x, t1.x), max(t0.y, t1.y)), max(t0.z, t1.z));
        OracleInterval {
            tnear: max(enter, 0.0),
            tfar: leave,
        }
    }

    /// Replaces `best` if the primitive is hit closer, or as close with a smaller number.
    #[inline]
    pub(super) fn update_closest(&self, scene: &Scene, prim_id: u32, best: &mut Option<OracleHit>) {
        if let Some(hit) = self.hit::<false>(scene, prim_id) {
            let closer = match best {
                None => true,
                Some(b) => hit.t < b.t || (hit.t == b.t && hit.prim_id < b.prim_id),
            };
            if closer {
                *best = Some(hit);
            }
        }
    }
}
