//! Rays against single primitives in f64, with error bounds for f32.

use crate::common::tolerances::{CONE_ULPS, EPSILON, HIT_ULPS};
use glam::{DVec3, Vec3};
use phalanx::oracle::OracleRay;
use phalanx::scene::{Cone, PrimKind, Scene};

/// Result in f64 for one ray and one primitive.
pub struct Exact {
    /// Distance in units of the direction, and its error bound in f32.
    pub t: f64,
    pub error: f64,
    /// The other root, if f32 cannot decide on which side of the surface the ray starts.
    pub other: f64,
    /// Weights of the second and third vertex, and their error bound.
    pub weights: [f64; 2],
    pub weight_error: f64,
    /// Distance of the ray inside the primitive's outline, in units of f32's error bound: above 1
    /// it certainly hits the primitive, below −1 it certainly misses.
    pub margin: f64,
}

/// Errors in f32: [`HIT_ULPS`] roundings at the largest length involved, and the padding of boxes
/// to which distances are clamped.
fn length_error(length: f64) -> f64 {
    length * HIT_ULPS * EPSILON
}

/// Computes the result in f64 for a ray and a primitive of the scene.
pub fn exact(scene: &Scene, prim_id: u32, ray: &OracleRay) -> Exact {
    let (org, dir) = (ray.org.as_dvec3(), ray.dir.as_dvec3());
    let prim = scene.prims[prim_id as usize];
    let i = prim.index();
    match prim.kind() {
        PrimKind::Triangle => {
            let corners = scene.triangles.corners(i).map(Vec3::as_dvec3);
            triangle(corners, org, dir)
        }
        PrimKind::Sphere => {
            let center = scene.spheres.center.get(i).as_dvec3();
            let radius = f64::from(scene.spheres.radius[i]);
            // The primitive's own box clamps from here: it is padded in proportion to the
            // coordinates.
            let size = center.length() + radius + org.length();
            sphere(org - center, dir, radius, size)
        }
        PrimKind::Ellipsoid => {
            let [x, y, z, shift] = scene.ellipsoids.object_columns(i).map(Vec3::as_dvec3);
            let turn = |v: DVec3| x * v.x + y * v.y + z * v.z;
            let longest = x.length().max(y.length()).max(z.length());
            let size = longest * org.length() + shift.length() + 1.0;
            sphere(turn(org) + shift, turn(dir), 1.0, size)
        }
        PrimKind::Cone => cone(&scene.cones.get(i), org, dir),
    }
}

fn triangle([a, b, c]: [DVec3; 3], org: DVec3, dir: DVec3) -> Exact {
    let unit = dir.normalize();
    let corners = [a - org, b - org, c - org];
    let depth = corners.map(|p| p.dot(unit));
    // As the ray sees them.
    let flat = [0, 1, 2].map(|k| corners[k] - unit * depth[k]);
    let around = [0, 1, 2].map(|k| flat[(k + 1) % 3].cross(flat[(k + 2) % 3]).dot(unit));
    let area: f64 = around.iter().sum();
    let weights = around.map(|w| w / area);
    let t = (0..3).map(|k| weights[k] * depth[k]).sum::<f64>() / dir.length();
    let farthest = corners.iter().map(|p| p.length()).fold(0.0, f64::max);
    let place = length_error(farthest + org.length());
    // Distance of the ray from each edge's line, positive inside.
    let margin = (0..3).map(|k| {
        let edge = (flat[(k + 2) % 3] - flat[(k + 1) % 3]).length();
        around[k] * area.signum() / edge
    });
    let margin = margin.fold(f64::INFINITY, f64::min) / place;
    // An error of a weight is the place's error over the triangle's height as the ray sees it;
    // depth differs by at most the length of an edge, to which the clamp bounds the error, too.
    let longest = [b - a, c - b, a - c]
        .iter()
        .map(|e| e.length())
        .fold(0.0, f64::max);
    let height = area.abs() / longest;
    let slope = (longest / height).max(1.0);
    let error = (place * slope).min(longest + place) + place;
    Exact {
        t,
        error: error / dir.length(),
        other: f64::NAN,
        weights: [weights[1], weights[2]],
        weight_error: 2.0 * place / height + HIT_ULPS * EPSILON,
        margin: if margin.is_nan() { 0.0 } else { margin },
    }
}

fn sphere(from_center: DVec3, dir: DVec3, radius: f64, size: f64) -> Exact {
    let speed = dir.length();
    let unit = dir / speed;
    let along = -from_center.dot(unit);
    let closest = from_center + unit * along;
    let place = length_error(size + from_center.length());
    let gap = radius * radius - closest.length_squared();
    let half = gap.max(0.0).sqrt();
    let (near, far) = (along - half, along + half);
    let t = if near > 0.0 { near } else { far };
    // The half chord is steep at the silhouette: √(2 r δ) at worst.
    let widest = (2.0 * radius * place + place * place).sqrt();
    let chord = (place * radius / half.max(1e-300)).min(widest) * 2.0;
    // c = f² − r² cancels where the origin is near the surface, and is divided by q.
    let q = along.abs() + half;
    let squares = length_error(from_center.length()) * from_center.length() / q.max(1e-300);
    let error = (place + chord + squares).min(2.0 * radius + place);
    Exact {
        t: t / speed,
        error: error / speed,
        other: if near.abs() <= error {
            if near > 0.0 { far / speed } else { near / speed }
        } else {
            f64::NAN
        },
        weights: [0.0, 0.0],
        weight_error: 0.0,
        margin: (radius - closest.length()) / place,
    }
}

/// A hit on a cone in f64, whether or not it counts.
#[derive(Clone, Copy)]
struct Candidate {
    t: f64,
    error: f64,
    /// The smallest of the margins at the silhouette, at the ends and at the ray's origin.
    margin: f64,
}

fn cone(cone: &Cone, org: DVec3, dir: DVec3) -> Exact {
    let (base, apex) = (cone.base.as_dvec3(), cone.apex.as_dvec3());
    let radii = [cone.base_radius, cone.apex_radius].map(f64::from);
    let length = (apex - base).length();
    let (axis, speed) = ((apex - base) / length, dir.length());
    let slope = (radii[1] - radii[0]) / length;
    let cos2 = 1.0 / (1.0 + slope * slope);
    let widest = radii[0].max(radii[1]);
    let size = base.length().max(apex.length()) + widest;
    let place = CONE_ULPS * EPSILON * (size + (org - base).length());
    // From the point of the ray that is nearest to the cone's middle.
    let unit = dir / speed;
    let start = -(org - (base + apex) / 2.0).dot(unit);
    let f = org - base + unit * start;
    let (z, dz) = (f.dot(axis), unit.dot(axis));
    let (p, dp) = (f - axis * z, unit - axis * dz);
    let (r, dr) = (radii[0] + slope * z, slope * dz);
    let (a, b, c) = (dp.dot(dp) - dr * dr, p.dot(dp) - r * dr, p.dot(p) - r * r);
    let disc = (dp * r - p * dr).length_squared() - p.cross(dp).length_squared();
    let root = disc.max(0.0).sqrt();
    let bend = (cos2 * a).abs();
    let root_of = |outside: bool| {
        let s = if disc < 0.0 {
            -b / a
        } else if outside == (b >= 0.0) {
            (-b - b.signum() * root) / a
        } else {
            c / (-b - b.signum() * root)
        };
        // Effect on the equation of moving the surface by `place`: its gradient there, and its
        // second order.
        let moved = 2.0 * cos2.sqrt() * (r + dr * s).abs() * place + place * place;
        let slide = (moved / (2.0 * cos2 * root)).min((moved / bend).sqrt());
        let error = 2.0 * slide.min(length + 2.0 * widest) + place;
        let (t, height) = (start + s, z + dz * s);
        let ends = height.min(length - height) / (place + error * dz.abs());
        let silhouette = cos2 * cos2 * disc / (bend * moved);
        let margin = ends.min(silhouette).min(t / error);
        Candidate {
            t: t / speed,
            error: error / speed,
            margin: if margin.is_nan() { -2.0 } else { margin },
        }
    };
    let mut all = vec![root_of(false)];
    if !cone.inside {
        all.push(root_of(true));
    }
    all.sort_by(|x, y| x.t.total_cmp(&y.t));
    let mut possible = all.iter().filter(|c| c.margin >= -1.0);
    let first = possible.next().copied().unwrap_or(all[0]);
    let sure = first.margin > 1.0;
    Exact {
        t: first.t,
        error: first.error,
        other: match possible.next() {
            Some(second) if !sure => second.t,
            _ => f64::NAN,
        },
        weights: [0.0, 0.0],
        weight_error: 0.0,
        margin: first.margin,
    }
}

/// Returns true if f64 cannot decide a hit of the primitive: at an outline, or at the origin.
pub fn undecided(exact: &Exact) -> bool {
    exact.margin.abs() <= 1.0 || exact.t.abs() <= exact.error || !exact.other.is_nan()
}
