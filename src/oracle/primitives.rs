//! The kinds of primitive, one after another: one ray against one primitive, and the surface at a
//! hit, in plain f32. This is the definition of both for either engine.
//!
//! Each formula stands, with its source, in the file of the same test in `trace`, or in
//! `render::shade::surface_point`. Here it is written out once more in scalar form, operation for
//! operation in the same order.

use super::intersect::{OracleHit, OracleRay, OracleRaySetup, max, max_abs, min};
use glam::Vec3;
use phalanx_scene::{
    DOUBLE_ROUNDING, MAX_OFFSET_PER_DISTANCE, OFFSET_PER_COORDINATE, OFFSET_PER_EDGE, PAD,
    PLANE_ROUNDING, PrimKind, Scene,
};

/// Share of the largest depth that is added to the difference of depths.
const MIN_SPREAD: f32 = 1.0 / 1024.0;

/// Term that is added to the bound on a distance's error before it is compared.
const MIN_DETERMINANT: f32 = f32::from_bits((127 - 75) << 23);

impl OracleRaySetup {
    /// The ray's first hit on a primitive at t > 0, or with `FAR` the second: the far side of a
    /// curved primitive that the ray enters.
    #[inline]
    pub(super) fn hit<const FAR: bool>(&self, scene: &Scene, prim_id: u32) -> Option<OracleHit> {
        let prim = scene.prims[prim_id as usize];
        let i = prim.index();
        match prim.kind() {
            PrimKind::Triangle if FAR => None,
            PrimKind::Triangle => self.triangle(scene.triangles.corners(i), scene, prim_id),
            PrimKind::Sphere => {
                let from_center = self.ray.org - scene.spheres.center.get(i);
                let radius = scene.spheres.radius[i];
                self.sphere::<FAR>(from_center, self.ray.dir, radius, scene, prim_id)
            }
            PrimKind::Ellipsoid => {
                let [x, y, z, shift] = scene.ellipsoids.object_columns(i);
                let rotate = |v: Vec3| (x * v.x + y * v.y) + z * v.z;
                let org = rotate(self.ray.org) + shift;
                self.sphere::<FAR>(org, rotate(self.ray.dir), 1.0, scene, prim_id)
            }
            PrimKind::Cone => self.cone::<FAR>(scene, i, prim_id),
        }
    }

    /// The first hit and, with `FAR_SIDES`, the second.
    pub(super) fn hits<const FAR_SIDES: bool>(
        &self,
        scene: &Scene,
        prim_id: u32,
    ) -> impl Iterator<Item = OracleHit> {
        let far = FAR_SIDES.then(|| self.hit::<true>(scene, prim_id));
        [self.hit::<false>(scene, prim_id), far.flatten()]
            .into_iter()
            .flatten()
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
        let most = |[a, b, c]: [f32; 3]| max(max(a.abs(), b.abs()), c.abs());
        let (far, near) = (max(max(a.z, b.z), c.z), min(min(a.z, b.z), c.z));
        let (depth, spread) = (max(far.abs(), near.abs()), far - near);
        let extent = most([ax, bx, cx]) + most([ay, by, cy]);
        let bound = (extent + self.steepness * depth) * (extent * (spread + depth * MIN_SPREAD))
            + (depth * det.abs() + MIN_DETERMINANT);
        let weight = sum.abs();
        let times = if by_edges > 0.0 { 32.0 } else { 1_048_576.0 };
        let t = if bound < weight * times && by_edges < f32::INFINITY {
            (by_edges > 0.0).then_some(by_edges)?
        } else {
            let t = self.plane_distance(stored, by_edges);
            if bound < weight * 128.0 {
                (t > 0.0 && t < f32::INFINITY).then_some(t)?
            } else {
                self.clamp(t, scene, prim_id)?
            }
        };
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

    fn sphere<const FAR: bool>(
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
        let enters = near > 0.0;
        if FAR && !enters {
            return None;
        }
        let raw = if enters && !FAR { near } else { far };
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

    /// The ray's hit on the cone at `i`: see [`OracleRaySetup::hit`].
    fn cone<const FAR: bool>(&self, scene: &Scene, i: usize, prim_id: u32) -> Option<OracleHit> {
        let interval = self.intersect_box(&scene.prim_bounds(prim_id).padded());
        let frame = scene.cones.frame(i);
        let (org, dir) = (self.ray.org, self.ray.dir);
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
        let outer = if scene.cones.get(i).inside { None } else { valid(from_outside) };
        let raw = match (outer, valid(from_inside)) {
            (Some(a), Some(b)) if FAR => max(a, b),
            _ if FAR => return None,
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

/// The surface at a hit.
pub(super) struct OraclePoint {
    pub(super) point: Vec3,
    /// Geometric normal.
    pub(super) ng: Vec3,
    /// Shading normal.
    pub(super) ns: Vec3,
    /// Mean of the vertex normals.
    pub(super) outward: Vec3,
    /// Distance from the point at which rays leave it.
    pub(super) offset: f32,
}

impl OraclePoint {
    /// A point of a surface with one normal.
    fn smooth(point: Vec3, n: Vec3, offset: f32) -> OraclePoint {
        OraclePoint {
            point,
            ng: n,
            ns: n,
            outward: n,
            offset,
        }
    }
}

/// The surface point in the space where the primitive is stored; `back` is the unit vector against
/// the ray there.
pub(super) fn surface_point(
    scene: &Scene,
    prim: u32,
    ray: &OracleRay,
    back: Vec3,
    hit: &OracleHit,
) -> OraclePoint {
    let prim = scene.prims[prim as usize];
    let i = prim.index();
    match prim.kind() {
        PrimKind::Sphere => sphere_point(scene, i, ray, back, hit.t),
        PrimKind::Ellipsoid => ellipsoid_point(scene, i, ray, back, hit.t),
        PrimKind::Triangle => triangle_point(scene, i, ray, back, hit),
        PrimKind::Cone => cone_point(scene, i, ray, back, hit.t),
    }
}

pub(super) fn unit_or(v: Vec3, otherwise: Vec3) -> Vec3 {
    let squared = v.dot(v);
    if squared > 0.0 { v * (1.0 / squared.sqrt()) } else { otherwise }
}

pub(super) fn unit(v: Vec3) -> Vec3 {
    v * (1.0 / v.dot(v).sqrt())
}

fn triangle_point(
    scene: &Scene,
    i: usize,
    ray: &OracleRay,
    back: Vec3,
    hit: &OracleHit,
) -> OraclePoint {
    let [a, b, c] = scene.triangles.corners(i).map(Vec3::as_dvec3);
    let (e1, e2) = (b - a, c - a);
    let normal = e1.cross(e2);
    let (org, dir, t) = (ray.org.as_dvec3(), ray.dir.as_dvec3(), f64::from(hit.t));
    let (beta, gamma) = (f64::from(hit.u), f64::from(hit.v));
    let edges = e1.abs().max(e2.abs()).max_element();
    let along = normal.dot(a - org) / normal.dot(dir);
    let way = t * dir.abs().max_element();
    let by_ray = edges > 64.0 * way && (along - t).abs() <= t / 4096.0;
    let point = if by_ray {
        org + dir * along
    } else {
        (a * ((1.0 - beta) - gamma) + b * beta) + c * gamma
    };
    let point = point.as_vec3();
    let length = normal.dot(normal).sqrt();
    let unit = (normal * (1.0 / length)).as_vec3();
    let ng = if length > 0.0 { unit } else { back };
    let alpha = (1.0 - hit.u) - hit.v;
    let (ns, outward) = match scene.triangles.corner_normals(i) {
        Some([na, nb, nc]) => (
            unit_or((na * alpha + nb * hit.u) + nc * hit.v, ng),
            unit_or((na + nb) + nc, ng),
        ),
        None => (ng, ng),
    };
    let (edges, way) = (edges as f32, way as f32);
    let rounding = ng.abs().dot(point.abs()) * PLANE_ROUNDING + edges * DOUBLE_ROUNDING;
    let [least, most] = OFFSET_PER_EDGE.map(|share| edges * share);
    let beyond = min(max(max_abs(point) * OFFSET_PER_COORDINATE, least), most);
    let offset = max(rounding, min(beyond, way * MAX_OFFSET_PER_DISTANCE));
    OraclePoint {
        point,
        ng,
        ns,
        outward,
        offset,
    }
}

fn sphere_point(scene: &Scene, i: usize, ray: &OracleRay, back: Vec3, t: f32) -> OraclePoint {
    let (center, radius) = (scene.spheres.center.get(i), scene.spheres.radius[i]);
    let n = unit_or((ray.org - center) + ray.dir * t, back);
    let point = center + n * radius;
    let offset = radius * PAD + n.abs().dot(point.abs()) * PLANE_ROUNDING;
    OraclePoint::smooth(point, n, offset)
}

fn ellipsoid_point(scene: &Scene, i: usize, ray: &OracleRay, back: Vec3, t: f32) -> OraclePoint {
    let [mx, my, mz, shift] = scene.ellipsoids.object_columns(i);
    let [wx, wy, wz, center] = scene.ellipsoids.world_columns(i);
    let to_object = |v: Vec3| (mx * v.x + my * v.y) + mz * v.z;
    let org = to_object(ray.org) + shift;
    let dir = to_object(ray.dir);
    let n = unit_or(org + dir * t, -unit(dir));
    let point = ((wx * n.x + wy * n.y) + wz * n.z) + center;
    let gradient = Vec3::new(mx.dot(n), my.dot(n), mz.dot(n));
    let length = gradient.dot(gradient).sqrt();
    let ng = unit_or(gradient, back);
    let p = point.abs();
    let terms = ((mx.abs() * p.x + my.abs() * p.y) + mz.abs() * p.z) + shift.abs();
    let inside = (max_abs(terms) + 1.0) / length;
    OraclePoint::smooth(point, ng, (inside + max_abs(point)) * PAD)
}

fn cone_point(scene: &Scene, i: usize, ray: &OracleRay, back: Vec3, t: f32) -> OraclePoint {
    let c = scene.cones.get(i);
    let (radius, profile) = (c.base_radius, scene.cones.profile(i));
    let f = (ray.org - c.base) + ray.dir * t;
    let height = f.dot(profile.axis);
    let away = f - profile.axis * height;
    let radial = unit_or(away, Vec3::ZERO);
    let apart = away.dot(radial);
    let along = (apart - radius) * profile.sin + height * profile.cos;
    let along = min(max(along, 0.0), profile.slant);
    let (x, z) = (radius + profile.sin * along, profile.cos * along);
    let point = c.base + (radial * x + profile.axis * z);
    let slanted = radial * profile.cos - profile.axis * profile.sin;
    let ng = if away.dot(away) > 0.0 { unit_or(slanted, back) } else { back };
    let size = max_abs(c.apex - c.base) + max(radius, c.apex_radius);
    let offset = size * PAD + ng.abs().dot(point.abs()) * PLANE_ROUNDING;
    OraclePoint::smooth(point, ng, offset)
}
