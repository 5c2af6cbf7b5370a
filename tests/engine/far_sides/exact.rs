//! Both points at which a line crosses a sphere, an ellipsoid or a cone, in f64, each with a bound
//! on the error of f32.

use crate::common::tolerances::{CONE_ULPS, EPSILON, HIT_ULPS};
use glam::{DVec3, Vec3};
use phalanx::Ray;
use phalanx::scene::{Cone, PrimKind, Scene};

/// A point at which a line crosses a surface.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Distance along the line, also behind the ray's origin, and the bound on its error.
    pub t: f64,
    pub error: f64,
    /// True if the line leaves the primitive here.
    pub leaves: bool,
    /// False if f32 may miss the surface here: at a silhouette, or at the end of a cone.
    pub sure: bool,
}

/// A line in some space, and the length of the coordinates that were rounded on the way there.
#[derive(Clone, Copy)]
struct MappedLine {
    org: DVec3,
    dir: DVec3,
    size: f64,
}

impl MappedLine {
    /// The line under a map that is given by its columns.
    fn mapped(&self, columns: [Vec3; 4]) -> MappedLine {
        let [x, y, z, shift] = columns.map(Vec3::as_dvec3);
        let turn = |v: DVec3| x * v.x + y * v.y + z * v.z;
        let longest = x.length().max(y.length()).max(z.length());
        MappedLine {
            org: turn(self.org) + shift,
            dir: turn(self.dir),
            size: longest * self.size + shift.length(),
        }
    }
}

/// Numbers of the curved primitives that a ray may hit, those of instances included.
pub fn curved_prims(scene: &Scene) -> Vec<u32> {
    let stored = scene.prim_count() as u32;
    let ids = |object: u32| match object.checked_sub(stored) {
        None => object..object + 1,
        Some(instance) => {
            let first = scene.instance_first_id(instance as usize);
            let mesh = scene.instances.mesh[instance as usize] as usize;
            first..first + scene.meshes.count[mesh]
        }
    };
    let is_curved = |&id: &u32| {
        let stored = scene.resolve(id).prim as usize;
        scene.prims[stored].kind() != PrimKind::Triangle
    };
    let objects = scene.world_objects().into_iter().flatten();
    objects.flat_map(ids).filter(is_curved).collect()
}

/// The crossings of a ray's line with a curved primitive, in order.
pub fn crossings(scene: &Scene, prim_id: u32, ray: &Ray) -> Vec<Crossing> {
    let [org, dir] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    let mut line = MappedLine {
        org,
        dir,
        size: org.length(),
    };
    let placed = scene.resolve(prim_id);
    if let Some(instance) = placed.instance {
        line = line.mapped(scene.instances.object_columns(instance as usize));
    }
    let prim = scene.prims[placed.prim as usize];
    let i = prim.index();
    match prim.kind() {
        PrimKind::Triangle => unreachable!("a triangle is not curved"),
        PrimKind::Sphere => {
            let center = scene.spheres.center.get(i).as_dvec3();
            sphere(&line, center, f64::from(scene.spheres.radius[i]))
        }
        PrimKind::Ellipsoid => {
            let line = line.mapped(scene.ellipsoids.object_columns(i));
            sphere(&line, DVec3::ZERO, 1.0)
        }
        PrimKind::Cone => cone(&line, &scene.cones.get(i)),
    }
}

fn sphere(line: &MappedLine, center: DVec3, radius: f64) -> Vec<Crossing> {
    let speed = line.dir.length();
    let unit = line.dir / speed;
    let from_center = line.org - center;
    let away = from_center.length();
    let along = -from_center.dot(unit);
    let distance = (from_center + unit * along).length();
    let place = HIT_ULPS * EPSILON * (line.size + center.length() + radius + away);
    let outside = distance - radius;
    if outside > place {
        return Vec::new();
    }
    let half = ((radius - distance) * (radius + distance)).max(0.0).sqrt();
    // Moving the line by `place` moves its ends on the sphere by place · r / half, or by the
    // longest chord within that distance of the silhouette.
    let widest = (2.0 * radius * place + place * place).sqrt();
    let slide = 2.0 * (place * radius / half).min(widest);
    // c = f² − r² cancels where the origin is near the surface, and is divided by q.
    let squares = HIT_ULPS * EPSILON * away * away / (along.abs() + half);
    let error = (place + slide + squares) / speed;
    [(along - half, false), (along + half, true)]
        .map(|(t, leaves)| Crossing {
            t: t / speed,
            error,
            leaves,
            sure: outside < -place,
        })
        .into()
}

fn cone(line: &MappedLine, cone: &Cone) -> Vec<Crossing> {
    let (base, apex) = (cone.base.as_dvec3(), cone.apex.as_dvec3());
    let [base_radius, apex_radius] = [cone.base_radius, cone.apex_radius].map(f64::from);
    let length = (apex - base).length();
    let axis = (apex - base) / length;
    let widest = base_radius.max(apex_radius);
    let far = base.length().max(apex.length()) + (line.org - base).length();
    let place = CONE_ULPS * EPSILON * (line.size + widest + far);
    // From the point of the line that is nearest to the cone's middle.
    let speed = line.dir.length();
    let unit = line.dir / speed;
    let start = -(line.org - (base + apex) / 2.0).dot(unit);
    let from_base = line.org + unit * start - base;
    // The cone is |p|² = r², with p and r linear along the line.
    let (z, dz) = (from_base.dot(axis), unit.dot(axis));
    let (p, dp) = (from_base - axis * z, unit - axis * dz);
    let slope = (apex_radius - base_radius) / length;
    let secant = (1.0 + slope * slope).sqrt();
    let (r, dr) = (base_radius + slope * z, slope * dz);
    let (a, b) = (dp.dot(dp) - dr * dr, p.dot(dp) - r * dr);
    let squared = (dp * r - p * dr).length_squared() - p.cross(dp).length_squared();
    let root = squared.max(0.0).sqrt();
    let root_of = |leaves: bool| {
        let c = p.dot(p) - r * r;
        // The form of the quadratic's root that subtracts no nearly equal numbers.
        let s = if leaves == (b < 0.0) {
            (root.copysign(-b) - b) / a
        } else {
            c / (root.copysign(-b) - b)
        };
        let (height, radius) = (z + dz * s, (r + dr * s).abs());
        // `change` bounds the error of |p|² − r²: the surface may move by `place`, and squares are
        // rounded where the line enters the cone's box. Then follows how far that moves the
        // crossing, on steep lines and on others.
        let squares = CONE_ULPS * EPSILON * (length + widest) * (length + widest);
        let change = 2.0 * secant * radius * place + place * place + squares;
        let slide = (change / (2.0 * root)).min((change / a.abs()).sqrt());
        let error = 2.0 * slide.min(length + 2.0 * widest) + place;
        let beyond_end = -height.min(length - height);
        let slack = place + error * dz.abs();
        let is_beside = squared < -(a.abs() * change);
        let possible = !is_beside && beyond_end < slack;
        possible.then_some(Crossing {
            t: (start + s) / speed,
            error: error / speed,
            leaves,
            sure: squared > a.abs() * change && beyond_end < -slack,
        })
    };
    let enters = if cone.inside { None } else { root_of(false) };
    let mut both: Vec<Crossing> = enters.into_iter().chain(root_of(true)).collect();
    both.sort_by(|x, y| x.t.total_cmp(&y.t));
    both
}
