//! Accuracy of hit distances on triangles, against f64: needles, long triangles and grazing rays,
//! by the ratio of the triangle's longest edge to the distance. `PHALANX_DISTANCE_RAYS=10000000`
//! for more rays than usual, `-- --nocapture` for the table.

use crate::common::rng::Rng;
use crate::common::scenes;
use crate::common::tolerances::DISTANCE;
use glam::{DVec3, Vec3};
use phalanx::oracle::{Oracle, OracleRay, OracleSearch};
use phalanx::scene::Scene;

const RAYS_A_TRIANGLE: usize = 64;
const DECADES: usize = 9;

/// Errors of the rays in one decade of longest edge / distance.
#[derive(Clone, Copy, Default)]
struct Decade {
    hits: usize,
    missed: usize,
    worst: f64,
    sum: f64,
}

/// A triangle around or next to the origin: equally wide and long, a needle, or with two vertices
/// close together.
fn triangle(rng: &mut Rng) -> [Vec3; 3] {
    let length = rng.magnitude(-3.0, 5.0);
    let point = rng.point(length) * rng.pick(&[0.0, 1.0, 3.0]);
    let (a, b) = (point + rng.point(length), point + rng.point(length));
    let c = match rng.below(3) {
        0 => point + rng.point(length),
        1 => a + (b - a) * rng.unit() + rng.direction() * length * rng.magnitude(-4.0, 0.0),
        _ => b + rng.direction() * length * rng.magnitude(-4.0, 0.0),
    };
    [a, b, c]
}

/// A ray at a point of a triangle from `distance` in front of it: from anywhere, or along its
/// surface, with a direction of any length.
fn ray_at([a, b, c]: [Vec3; 3], distance: f32, rng: &mut Rng) -> OracleRay {
    let (v, w) = (rng.unit(), rng.unit());
    let (v, w) = if v + w > 1.0 { (1.0 - v, 1.0 - w) } else { (v, w) };
    let point = a + (b - a) * v + (c - a) * w;
    let dir = match rng.below(3) {
        0 => (b - a) * rng.range(-1.0, 1.0) + (c - a) * rng.range(-1.0, 1.0),
        _ => rng.direction(),
    };
    let slant = rng.magnitude(-2.0, 0.0);
    let dir = (dir.normalize_or(Vec3::X) + rng.direction() * slant).normalize_or(Vec3::X);
    OracleRay::new(point - dir * distance, dir * rng.magnitude(-1.0, 1.0))
}

/// The distance in f64, and its error bound: products of three lengths, each rounded.
fn truth(corners: [Vec3; 3], ray: &OracleRay) -> (f64, f64) {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - ray.org.as_dvec3());
    let dir = ray.dir.as_dvec3();
    let volume = |a: DVec3, b: DVec3, c: DVec3| a.dot(b.cross(c));
    let size = a.length().max(b.length()).max(c.length());
    let height = volume(a, b - a, c - a);
    let facing = dir.dot((b - a).cross(c - a));
    let off = 8.0 * f64::EPSILON * size * (b - a).length() * (c - a).length();
    (height / facing, off / height.abs().min(facing.abs() * size))
}

/// One triangle.
fn scene(corners: [Vec3; 3]) -> Option<Scene> {
    let mut scene = scenes::bare();
    scene.add_triangle(corners, None, 0);
    scene.validate().ok().map(|()| scene)
}

#[test]
fn distances_are_those_of_f64() {
    let given = std::env::var("PHALANX_DISTANCE_RAYS").ok();
    let rays: usize = given.map_or(1_000_000, |n| n.parse().expect("a number of rays"));
    let mut rng = Rng::new(29);
    let mut decades = [Decade::default(); DECADES];
    let mut traced = 0;
    while traced < rays {
        let corners = triangle(&mut rng);
        let Some(scene) = scene(corners) else {
            continue;
        };
        let oracle = Oracle::new(&scene, OracleSearch::BruteForce);
        let [a, b, c] = corners;
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        for _ in 0..RAYS_A_TRIANGLE {
            traced += 1;
            let wanted = longest / rng.magnitude(-1.0, DECADES as f32 - 1.0);
            let ray = ray_at(corners, wanted, &mut rng);
            let (t, off) = truth(corners, &ray);
            if off > 0.1 * DISTANCE || t <= 0.0 {
                continue;
            }
            let ratio = f64::from(longest) / (t * ray.dir.as_dvec3().length());
            let decade = (ratio.log10().floor() + 1.0).clamp(0.0, DECADES as f64 - 1.0) as usize;
            let decade = &mut decades[decade];
            let Some(hit) = oracle.closest(&ray) else {
                decade.missed += 1;
                continue;
            };
            let error = (f64::from(hit.t) / t - 1.0).abs();
            decade.hits += 1;
            decade.sum += error;
            decade.worst = decade.worst.max(error);
            assert!(
                error <= DISTANCE,
                "{error:e} at {ratio:e}: {corners:?} {ray:?}: {} for {t}",
                hit.t
            );
        }
    }
    println!("longest edge / distance: hits, misses, worst and mean relative error");
    for (k, decade) in decades.iter().enumerate() {
        let mean = decade.sum / decade.hits as f64;
        let Decade {
            hits,
            missed,
            worst,
            ..
        } = decade;
        println!("< 10^{k}: {hits:9} {missed:8} {worst:9.1e} {mean:9.1e}");
        assert!(*hits > rays / 100, "{hits} hits in decade {k}");
    }
}
