//! One ray against one primitive, in plain f32: the definition of a hit, for both engines.
//!
//! Each formula stands, with its source, in the file of the same test in `trace`. Here it is
//! written out once more in scalar form, operation for operation in the same order.

use glam::Vec3;
use phalanx_scene::{Bounds, PAD, PrimKind, Scene, SurfaceHit};

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
    /// use glam::Vec3;
    /// use phalanx_oracle::OracleRay;
    ///
    /// assert_eq!(OracleRay::new(Vec3::ZERO, Vec3::Z).dir, Vec3::Z);
    /// ```
    pub fn new(org: Vec3, dir: Vec3) -> OracleRay {
        OracleRay { org, dir }
    }
}

/// A ray's hit. A miss is no `OracleHit`, but `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OracleHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric weight of a triangle's second vertex, else 0.
    pub u: f32,
    /// Barycentric weight of a triangle's third vertex, else 0.
    pub v: f32,
    /// Primitive, or primitive of an instance: see [`Scene::resolve`].
    pub prim_id: u32,
}

impl OracleHit {
    pub(super) fn on_surface(&self) -> SurfaceHit {
        SurfaceHit {
            prim_id: self.prim_id,
            t: self.t,
            u: self.u,
            v: self.v,
        }
    }

    /// Replaces `best` if this hit comes after `after`, but before `best`.
    pub(super) fn update_next(&self, after: &SurfaceHit, best: &mut Option<OracleHit>) {
        let precedes = best.is_none_or(|best| (self.t, self.prim_id) < (best.t, best.prim_id));
        if self.is_after(after) && precedes {
            *best = Some(*self);
        }
    }

    /// Returns true if this hit comes after another, by (t, prim_id).
    pub(super) fn is_after(&self, after: &SurfaceHit) -> bool {
        (self.t, self.prim_id) > (after.t, after.prim_id)
    }
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
    ray: OracleRay,
    rdir: Vec3,
    org_lo: Vec3,
    org_hi: Vec3,
    /// Axes of the sheared frame, its origin, and the slopes against the dominant axis.
    axes: [usize; 3],
    sheared_org: Vec3,
    slope_x: f32,
    slope_y: f32,
    scale: f32,
}

/// The distances at which a ray enters (not before 0) and leaves a box.
#[derive(Clone, Copy)]
pub(super) struct OracleInterval {
    pub(super) tnear: f32,
    pub(super) tfar: f32,
}

impl OracleInterval {
    /// Returns true if the ray is in the box somewhere between 0 and `best`.
    pub(super) fn overlaps(self, best: f32) -> bool {
        self.tnear <= min(self.tfar, best)
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

/// Term that is added to the bound on a distance's error before it is compared.
const MIN_DETERMINANT: f32 = f32::from_bits((127 - 75) << 23);

fn reciprocal(x: f32) -> f32 {
    let safe = if x.abs() < MIN_DIRECTION {
        if x < 0.0 {
            -MIN_DIRECTION
        } else {
            MIN_DIRECTION
        }
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
        OracleRaySetup {
            ray: *ray,
            rdir: Vec3::new(reciprocal(dir.x), reciprocal(dir.y), reciprocal(dir.z)),
            org_lo: org - pad,
            org_hi: org + pad,
            axes,
            sheared_org: Vec3::from_array(axes.map(|k| org[k])),
            slope_x: d[0] * scale,
            slope_y: d[1] * scale,
            scale,
        }
    }

    /// The ray from which this was made.
    pub(super) fn ray(&self) -> &OracleRay {
        &self.ray
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
        if let Some(hit) = self.hit(scene, prim_id) {
            let closer = match best {
                None => true,
                Some(b) => hit.t < b.t || (hit.t == b.t && hit.prim_id < b.prim_id),
            };
            if closer {
                *best = Some(hit);
            }
        }
    }

    /// The ray's hit on a primitive, if it has one at t > 0.
    #[inline]
    pub(super) fn hit(&self, scene: &Scene, prim_id: u32) -> Option<OracleHit> {
        let prim = scene.prims[prim_id as usize];
        let i = prim.index();
        match prim.kind() {
            PrimKind::Triangle => self.triangle(scene.triangles.corners(i), scene, prim_id),
            PrimKind::Sphere => {
                let from_center = self.ray.org - scene.spheres.center.get(i);
                self.sphere(
                    from_center,
                    self.ray.dir,
                    scene.spheres.radius[i],
                    scene,
                    prim_id,
                )
            }
            PrimKind::Ellipsoid => {
                let [x, y, z, shift] = scene.ellipsoids.object_columns(i);
                let rotate = |v: Vec3| (x * v.x + y * v.y) + z * v.z;
                let org = rotate(self.ray.org) + shift;
                self.sphere(org, rotate(self.ray.dir), 1.0, scene, prim_id)
            }
            PrimKind::Cone => self.cone(scene, i, prim_id),
        }
    }

    fn triangle(&self, stored: [Vec3; 3], scene: &Scene, prim_id: u32) -> Option<OracleHit> {
        let [a, b, c] =
            stored.map(|corner| Vec3::from_array(self.axes.map(|k| corner[k])) - self.sheared_org);
        let (ax, ay) = (a.x - self.slope_x * a.z, a.y - self.slope_y * a.z);
        let (bx, by) = (b.x - self.slope_x * b.z, b.y - self.slope_y * b.z);
        let (cx, cy) = (c.x - self.slope_x * c.z, c.y - self.slope_y * c.z);
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        if !inside {
            return None;
        }
        let det = (u + v) + w;
        if det.is_nan() || det == 0.0 {
            return None;
        }
        let sum = (u * a.z + v * b.z) + w * c.z;
        let by_edges = (sum * self.scale) / det;
        let size = [ax, ay, bx, by, cx, cy]
            .map(f32::abs)
            .into_iter()
            .fold(0.0, max);
        let (far, near) = (max(max(a.z, b.z), c.z), min(min(a.z, b.z), c.z));
        let (depth, spread) = (max(far.abs(), near.abs()), far - near);
        let bound = size * (size * spread + depth * spread) + depth * det.abs();
        let times = if by_edges > 0.0 { 24.0 } else { 262_144.0 };
        let accurate = bound + MIN_DETERMINANT < times * sum.abs() && by_edges < f32::INFINITY;
        let raw = match accurate {
            true => by_edges,
            false => self.plane_distance(stored, by_edges),
        };
        let t = self.clamp(raw, scene, prim_id)?;
        Some(OracleHit {
            t,
            u: v / det,
            v: w / det,
            prim_id,
        })
    }

    /// The distance to the plane of a triangle, in f64.
    fn plane_distance(&self, corners: [Vec3; 3], otherwise: f32) -> f32 {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (ab, bc, ca) = (b - a, c - b, a - c);
        let (ab2, bc2, ca2) = (ab.dot(ab), bc.dot(bc), ca.dot(ca));
        let (corner, normal) = if bc2 >= ab2 && bc2 >= ca2 {
            (a, ca.cross(ab))
        } else if ca2 >= ab2 {
            (b, ab.cross(bc))
        } else {
            (c, bc.cross(ca))
        };
        let height = normal.dot(corner - self.ray.org.as_dvec3());
        let t = height / normal.dot(self.ray.dir.as_dvec3());
        if t.is_finite() { t as f32 } else { otherwise }
    }

    fn sphere(
        &self,
        from_center: Vec3,
        dir: Vec3,
        radius: f32,
        scene: &Scene,
        prim_id: u32,
    ) -> Option<OracleHit> {
        let f = from_center;
        let a = dir.dot(dir);
        let b = -f.dot(dir);
        let rr = radius * radius;
        let l = f + dir * (b / a);
        let gap = rr - l.dot(l);
        if gap.is_nan() || gap < 0.0 {
            return None;
        }
        let c = f.dot(f) - rr;
        let root = (a * gap).sqrt();
        let q = if b < 0.0 { b - root } else { b + root };
        let (t0, t1) = (c / q, q / a);
        let (near, far) = (min(t0, t1), max(t0, t1));
        let raw = if near > 0.0 { near } else { far };
        let t = self.clamp(raw, scene, prim_id)?;
        Some(OracleHit {
            t,
            u: 0.0,
            v: 0.0,
            prim_id,
        })
    }

    /// The distance, clamped to the interval of the primitive's own box.
    fn clamp(&self, raw: f32, scene: &Scene, prim_id: u32) -> Option<f32> {
        self.intersect_box(&scene.prim_bounds(prim_id).padded())
            .clamp(raw)
    }
}
