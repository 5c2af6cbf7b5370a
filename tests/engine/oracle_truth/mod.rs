//! The oracle itself: its tree against brute force, bit for bit, and brute force against f64 within
//! a stated bound.

mod exact;

use crate::common::full_or;
use crate::common::rays::{hit_bits, toward};
use crate::common::rng::Rng;
use crate::common::scenes;
use exact::{Exact, exact, undecided};
use glam::Vec3;
use phalanx::PAD;
use phalanx::oracle::{Oracle, OracleHit, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx::scene::Scene;

const SCALES: [f32; 5] = [1e-3, 0.1, 1.0, 1e3, 1e6];

/// A random ray: from inside, around, or far outside, at a surface, past it, or anywhere.
fn ray_at(scene: &Scene, rng: &mut Rng, scale: f32) -> OracleRay {
    let distance = rng.pick(&[0.5, 2.0, 2.0, 1000.0]);
    let org = match rng.below(8) {
        0 => scenes::point_on(scene, rng),
        _ => rng.point(distance * scale),
    };
    let ray = match rng.below(4) {
        0 => OracleRay::new(org, rng.direction()),
        1 => toward(org, rng.point(scale)),
        _ => toward(org, scenes::point_on(scene, rng)),
    };
    match rng.below(3) {
        0 => OracleRay::new(ray.org, ray.dir * rng.magnitude(-2.0, 2.0)),
        _ => ray,
    }
}

fn each_ray(seed: u64, per_scene: usize, mut each: impl FnMut(&Scene, &TwoLevelBvh, &OracleRay)) {
    let mut rng = Rng::new(seed);
    for scale in SCALES {
        for count in [1, 2, 10, 40, 150] {
            let scene = scenes::random(&mut rng, count, scale);
            let tree = TwoLevelBvh::build(&scene);
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
        let by_tree = Oracle::new(scene, OracleSearch::Tree(tree));
        let by_force = Oracle::new(scene, OracleSearch::BruteForce);
        let want = by_force.closest(ray);
        let got = by_tree.closest(ray);
        let bits = |hit: Option<OracleHit>| hit.as_ref().map(hit_bits);
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
    let tree = TwoLevelBvh::build(&scene);
    let oracle = Oracle::new(&scene, OracleSearch::Tree(&tree));
    for _ in 0..1000 {
        let front = toward(Vec3::new(0.0, 0.0, 5.0), rng.point(0.2));
        assert_eq!(oracle.closest(&front).map(|hit| hit.prim_id), Some(0));
        let back = toward(Vec3::new(0.0, 0.0, -9.0), rng.point(0.2));
        assert_eq!(oracle.closest(&back).map(|hit| hit.prim_id), Some(1));
    }
}

#[test]
fn brute_force_finds_what_f64_finds() {
    let mut tally = ErrorTally::default();
    each_ray(13, full_or(8000, 2000), |scene, _, ray| {
        tally.judge(scene, ray)
    });
    tally.conclude(full_or(80_000, 20_000));
}

/// Cones of every shape, each alone, hit from near, from far away, from inside, and at their rims.
#[test]
fn a_cone_is_met_where_f64_meets_it() {
    let mut tally = ErrorTally::default();
    let mut rng = Rng::new(15);
    for scale in SCALES {
        for _ in 0..3000 {
            let mut scene = scenes::bare();
            let base = rng.point(scale);
            let cone = scenes::random_cone(&mut rng, base, scale);
            scene.add_cone(cone, 0);
            for _ in 0..20 {
                let distance = rng.pick(&[0.5, 2.0, 100.0, 1e4]);
                let org = match rng.below(4) {
                    0 => cone.base + (cone.apex - cone.base) * rng.unit(),
                    _ => base + rng.direction() * distance * scale,
                };
                let target = match rng.below(3) {
                    0 | 1 => cone.base + (cone.apex - cone.base) * rng.unit(),
                    _ => scenes::point_on_cone(&cone, &mut rng),
                };
                tally.judge(&scene, &toward(org, target));
            }
        }
    }
    tally.conclude(150_000);
}

/// Comparison of the oracle's results with f64's.
#[derive(Default)]
struct ErrorTally {
    hits: u32,
    /// Hits at an outline, end or silhouette, where f32 may decide differently.
    at_outlines: u32,
    excused: u32,
    /// Largest error of a distance, as a share of the bound.
    worst: f64,
}

impl ErrorTally {
    fn judge(&mut self, scene: &Scene, ray: &OracleRay) {
        let got = Oracle::new(scene, OracleSearch::BruteForce).closest(ray);
        let all: Vec<Exact> = (0..scene.prim_count() as u32)
            .map(|id| exact(scene, id, ray))
            .collect();
        let sure = |exact: &&Exact| exact.margin > 1.0 && exact.t > exact.error;
        let Some(hit) = got else {
            let missed = all.iter().find(sure);
            assert!(missed.is_none(), "{ray:?} misses what it surely meets");
            return;
        };
        self.hits += 1;
        self.judge_place(ray, &hit, &all[hit.prim_id as usize]);
        // Nothing that is surely met lies surely closer.
        let exact = &all[hit.prim_id as usize];
        for (id, other) in all.iter().enumerate().filter(|(_, other)| sure(other)) {
            let closer = other.t + other.error < f64::from(hit.t) - exact.error;
            assert!(
                !closer,
                "{ray:?}: {hit:?}, but {id} is hit at {:e}",
                other.t
            );
        }
        self.judge_order(ray, &hit, &all);
    }

    /// Distance and weights are f64's, within the bound.
    fn judge_place(&mut self, ray: &OracleRay, hit: &OracleHit, exact: &Exact) {
        assert!(
            exact.margin >= -1.0,
            "{ray:?}: {hit:?}, {:e} outside",
            exact.margin
        );
        if exact.margin <= 1.0 {
            self.at_outlines += 1;
            return;
        }
        let t = f64::from(hit.t);
        let error = (t - exact.t).abs().min((t - exact.other).abs());
        self.worst = self.worst.max(error / exact.error);
        assert!(
            error <= exact.error,
            "{ray:?}: {hit:?}, but f64 says {:e}, {error:e} away, {:e} allowed",
            exact.t,
            exact.error
        );
        for (got, want) in [hit.u, hit.v].into_iter().zip(exact.weights) {
            let error = (f64::from(got) - want).abs();
            let within = error <= exact.weight_error;
            assert!(within, "{ray:?}: {hit:?}, but f64 says {:?}", exact.weights);
        }
    }

    /// The nearest hit by f64 differs only where something was undecidable.
    fn judge_order(&mut self, ray: &OracleRay, hit: &OracleHit, all: &[Exact]) {
        let exact = &all[hit.prim_id as usize];
        let meets = |exact: &Exact| exact.margin > 0.0 && exact.t > 0.0;
        let nearest = all.iter().enumerate().filter(|(_, exact)| meets(exact));
        let nearest = nearest.min_by(|(_, a), (_, b)| a.t.total_cmp(&b.t));
        if nearest.is_none_or(|(id, _)| id != hit.prim_id as usize) {
            let tie = nearest.is_some_and(|(_, n)| (n.t - exact.t).abs() <= n.error + exact.error);
            let excuse = tie || undecided(exact) || nearest.is_some_and(|(_, n)| undecided(n));
            assert!(
                excuse,
                "{ray:?}: {hit:?}, but f64 says {:?}",
                nearest.map(|n| n.0)
            );
            self.excused += 1;
        }
    }

    fn conclude(&self, least: u32) {
        let ErrorTally {
            hits,
            at_outlines,
            excused,
            worst,
        } = *self;
        println!(
            "{hits} hits, {at_outlines} at outlines, {excused} undecidable, largest error {worst:.3} of the bound"
        );
        assert!(hits > least, "only {hits} hits");
        let says = excused * 5 < hits && at_outlines * 3 < hits;
        assert!(says, "too many of {hits} hits are undecided: no bound");
    }
}

/// Distances stay within the padding of the primitive's box, as the clamp guarantees.
#[test]
fn hits_lie_in_the_primitive_s_own_box() {
    each_ray(14, 500, |scene, _, ray| {
        let Some(hit) = Oracle::new(scene, OracleSearch::BruteForce).closest(ray) else {
            return;
        };
        let b = scene.prim_bounds(hit.prim_id).padded();
        let (org, dir) = (ray.org.as_dvec3(), ray.dir.as_dvec3());
        let position = org + dir * f64::from(hit.t);
        // The slab test moves the origin by as much, and rounds some times.
        let size = org.abs().max_element() + (position - org).abs().max_element();
        let slack = 2.0 * f64::from(PAD) * size;
        let inside = position.cmpge(b.lo.as_dvec3() - slack).all()
            && position.cmple(b.hi.as_dvec3() + slack).all();
        assert!(inside, "{ray:?}: {hit:?} at {position}, outside {b:?}");
    });
}
