//! The oracle itself: its tree against brute force to the bit, and brute force against f64 within a stated bound.

mod common;

use common::rays::{hit_bits, toward};
use common::rng::Rng;
use common::scenes;
use common::tolerances::{EPSILON, HIT_ULPS};
use glam::{DVec3, Vec3};
use phalanx::oracle::{Forest, Hit, Oracle, Ray, Search};
use phalanx::scene::{PAD, PrimKind, Scene};

const SCALES: [f32; 5] = [1e-3, 0.1, 1.0, 1e3, 1e6];

/// A ray at a scene: from within, around, or far outside, at a surface, past it, or anywhere.
fn ray_at(scene: &Scene, rng: &mut Rng, scale: f32) -> Ray {
    let distance = rng.pick(&[0.5, 2.0, 2.0, 1000.0]);
    let org = match rng.below(8) {
        0 => scenes::point_on(scene, rng),
        _ => rng.point(distance * scale),
    };
    let ray = match rng.below(4) {
        0 => Ray::new(org, rng.direction()),
        1 => toward(org, rng.point(scale)),
        _ => toward(org, scenes::point_on(scene, rng)),
    };
    match rng.below(3) {
        0 => Ray::new(ray.org, ray.dir * rng.magnitude(-2.0, 2.0)),
        _ => ray,
    }
}

fn each_ray(seed: u64, per_scene: usize, mut each: impl FnMut(&Scene, &Forest, &Ray)) {
    let mut rng = Rng::new(seed);
    for scale in SCALES {
        for count in [1, 2, 10, 40, 150] {
            let scene = scenes::random(&mut rng, count, scale);
            let tree = Forest::build(&scene);
            for _ in 0..per_scene {
                let ray = ray_at(&scene, &mut rng, scale);
                each(&scene, &tree, &ray);
            }
        }
    }
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    each_ray(11, 2000, |scene, tree, ray| {
        let by_tree = Oracle::new(scene, Search::Tree(tree), 0);
        let by_force = Oracle::new(scene, Search::BruteForce, 0);
        let want = by_force.closest(ray);
        let got = by_tree.closest(ray);
        let bits = |hit: Option<Hit>| hit.as_ref().map(hit_bits);
        assert_eq!(bits(got), bits(want), "{ray:?}");
        for tmax in [0.5, 1.0, f32::INFINITY] {
            let blocked = by_force.occluded(ray, tmax);
            assert_eq!(
                by_tree.occluded(ray, tmax),
                blocked,
                "{ray:?} before {tmax}"
            );
        }
        if let Some(hit) = want {
            assert!(by_tree.occluded(ray, hit.t.next_up()), "{ray:?}: {hit:?}");
            assert!(!by_tree.occluded(ray, hit.t), "{ray:?}: {hit:?}");
        }
    });
}

#[test]
fn ties_go_to_the_smaller_number() {
    let mut rng = Rng::new(12);
    let mut scene = scenes::bare();
    let corners = [
        Vec3::new(-1.0, -1.0, 0.0),
        Vec3::new(1.0, -1.0, 0.0),
        Vec3::new(0.0, 1.0, 0.0),
    ];
    for _ in 0..20 {
        scene.add_triangle(corners, None, 0);
        scene.add_sphere(Vec3::new(0.0, 0.0, -3.0), 1.0, 0);
    }
    let tree = Forest::build(&scene);
    let oracle = Oracle::new(&scene, Search::Tree(&tree), 0);
    for _ in 0..1000 {
        let front = toward(Vec3::new(0.0, 0.0, 5.0), rng.point(0.2));
        assert_eq!(oracle.closest(&front).map(|hit| hit.prim_id), Some(0));
        let back = toward(Vec3::new(0.0, 0.0, -9.0), rng.point(0.2));
        assert_eq!(oracle.closest(&back).map(|hit| hit.prim_id), Some(1));
    }
}

/// What f64 says of one ray and one primitive.
struct Exact {
    /// Distance in units of the direction, and the error that f32 may make in it.
    t: f64,
    error: f64,
    /// The other root, where f32 cannot tell on which side of the surface the ray starts.
    other: f64,
    /// Weights of the second and third corner, and the error in them.
    weights: [f64; 2],
    weight_error: f64,
    /// By how much the ray runs inside the primitive's outline, in units of the error that f32 may make in that: above
    /// 1 it surely meets the primitive, below −1 it surely does not.
    margin: f64,
}

/// Errors in f32: [`HIT_ULPS`] roundings at the largest length involved, and the padding of boxes to which distances
/// are clamped.
fn length_error(length: f64) -> f64 {
    length * HIT_ULPS * EPSILON
}

fn exact(scene: &Scene, prim_id: u32, ray: &Ray) -> Exact {
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
            // Where from the own box clamps: it is padded in proportion to the coordinates.
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
        PrimKind::Cone => todo!("cones are on their way"),
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
    // An error of a weight is the place's error over the triangle's height as the ray sees it; depth differs by at most
    // the length of an edge, to which the clamp bounds the error, too.
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
        other: match near.abs() <= error {
            true if near > 0.0 => far / speed,
            true => near / speed,
            false => f64::NAN,
        },
        weights: [0.0, 0.0],
        weight_error: 0.0,
        margin: (radius - closest.length()) / place,
    }
}

/// Whether f64 cannot tell if the primitive is met: at an outline, or at the origin.
fn undecided(at: &Exact) -> bool {
    at.margin.abs() <= 1.0 || at.t.abs() <= at.error || !at.other.is_nan()
}

#[test]
fn brute_force_finds_what_f64_finds() {
    let (mut hits, mut excused, mut worst) = (0u32, 0u32, 0.0f64);
    each_ray(13, 8000, |scene, _, ray| {
        let got = Oracle::new(scene, Search::BruteForce, 0).closest(ray);
        let all: Vec<Exact> = (0..scene.prim_count() as u32)
            .map(|id| exact(scene, id, ray))
            .collect();
        let sure = |at: &&Exact| at.margin > 1.0 && at.t > at.error;
        let Some(hit) = got else {
            let missed = all.iter().find(sure);
            assert!(missed.is_none(), "{ray:?} misses what it surely meets");
            return;
        };
        hits += 1;
        let at = &all[hit.prim_id as usize];
        assert!(
            at.margin >= -1.0,
            "{ray:?}: {hit:?}, {:e} outside",
            at.margin
        );
        let t = f64::from(hit.t);
        let error = (t - at.t).abs().min((t - at.other).abs());
        if at.margin.abs() > 1.0 {
            worst = worst.max(error / at.error);
        }
        assert!(
            at.margin.abs() <= 1.0 || error <= at.error,
            "{ray:?}: {hit:?}, but f64 says {:e}, {error:e} away, {:e} allowed",
            at.t,
            at.error
        );
        for (got, want) in [hit.u, hit.v].into_iter().zip(at.weights) {
            let error = (f64::from(got) - want).abs();
            let within = at.margin.abs() <= 1.0 || error <= at.weight_error;
            assert!(within, "{ray:?}: {hit:?}, but f64 says {:?}", at.weights);
        }
        // Nothing that is surely met lies surely closer.
        for (id, other) in all.iter().enumerate().filter(|(_, other)| sure(other)) {
            let closer = other.t + other.error < f64::from(hit.t) - at.error;
            assert!(
                !closer,
                "{ray:?}: {hit:?}, but {id} is hit at {:e}",
                other.t
            );
        }
        // The nearest by f64 is another one only where something could not be decided.
        let meets = |at: &Exact| at.margin > 0.0 && at.t > 0.0;
        let nearest = all.iter().enumerate().filter(|(_, at)| meets(at));
        let nearest = nearest.min_by(|(_, a), (_, b)| a.t.total_cmp(&b.t));
        if nearest.is_none_or(|(id, _)| id != hit.prim_id as usize) {
            let tie = nearest.is_some_and(|(_, n)| (n.t - at.t).abs() <= n.error + at.error);
            let excuse = tie || undecided(at) || nearest.is_some_and(|(_, n)| undecided(n));
            assert!(
                excuse,
                "{ray:?}: {hit:?}, but f64 says {:?}",
                nearest.map(|n| n.0)
            );
            excused += 1;
        }
    });
    println!("{hits} hits, {excused} undecidable, largest error {worst:.3} of the bound");
    assert!(hits > 80_000, "only {hits} hits");
    assert!(
        f64::from(excused) < 0.2 * f64::from(hits),
        "{excused} of {hits} undecided: the bound says nothing"
    );
}

/// Distances stay within the own box's padding of the box that the primitive fills: what the clamp promises.
#[test]
fn hits_lie_in_the_primitive_s_own_box() {
    each_ray(14, 500, |scene, _, ray| {
        let Some(hit) = Oracle::new(scene, Search::BruteForce, 0).closest(ray) else {
            return;
        };
        let b = scene.prim_bounds(hit.prim_id).padded();
        let (org, dir) = (ray.org.as_dvec3(), ray.dir.as_dvec3());
        let place = org + dir * f64::from(hit.t);
        // The slab test moves the origin by as much, and rounds some times.
        let size = org.abs().max_element() + (place - org).abs().max_element();
        let slack = 2.0 * f64::from(PAD) * size;
        let inside = place.cmpge(b.lo.as_dvec3() - slack).all()
            && place.cmple(b.hi.as_dvec3() + slack).all();
        assert!(inside, "{ray:?}: {hit:?} at {place}, outside {b:?}");
    });
}
