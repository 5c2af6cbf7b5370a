//! Far sides of spheres, ellipsoids and cones: rays that do not count the near side, because it
//! lies before `tnear` or because a filter refuses it, against f64 and against the oracle.

mod exact;

use crate::common::full_or;
use crate::common::rays::{Engines, hit_bits};
use crate::common::rng::Rng;
use crate::common::scenes;
use crate::common::tolerances::UNDECIDED_CROSSINGS;
use exact::{Crossing, crossings, curved_prims};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use phalanx::bvh::Bvh;
use phalanx::oracle::{Oracle, OracleHit, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx::scene::Scene;
use phalanx::{
    BatchFilter, Hit, HitBuffer, NO_PRIM, PerRay, Ray, RayBuffer, RayFilter, refine, thread_count,
};

/// A few curved primitives of each kind and a triangle, in every other scene some of them in
/// instances.
fn random_scene(rng: &mut Rng, with_instances: bool) -> Scene {
    let mut scene = scenes::bare();
    if with_instances {
        let mesh = scene.begin_mesh();
        add_curved(&mut scene, rng);
        scene.end_mesh(mesh);
        for _ in 0..2 {
            let turn = (rng.direction() * rng.range(0.0, 3.0)).as_dvec3();
            let stretch = [0; 3].map(|_| f64::from(rng.range(0.5, 2.0)));
            let mirror = rng.pick(&[-1.0, 1.0]);
            let map = DAffine3 {
                matrix3: DMat3::from_quat(DQuat::from_scaled_axis(turn))
                    * DMat3::from_diagonal(DVec3::from(stretch) * mirror),
                translation: rng.point(1.0).as_dvec3(),
            };
            scene.add_instance(mesh, map).expect("an invertible map");
        }
    }
    add_curved(&mut scene, rng);
    let corners = [0; 3].map(|_| rng.point(1.0));
    scene.add_triangle(corners, None, 0);
    scene.validate().expect("a valid scene");
    scene
}

fn add_curved(scene: &mut Scene, rng: &mut Rng) {
    for _ in 0..1 + rng.below(2) {
        scene.add_sphere(rng.point(1.0), rng.range(0.1, 0.8), 0);
        let axes = Vec3::from_array([0; 3].map(|_| rng.range(0.2, 0.8)));
        let turn = rng.direction() * rng.range(0.0, 3.0);
        scenes::add_ellipsoid(scene, rng.point(1.0), axes, turn, 0);
        let base = rng.point(1.0);
        let cone = scenes::random_cone(rng, base, 2.0);
        scene.add_cone(cone, 0);
    }
}

/// A ray from a surface, from inside or from outside, with a direction of any length.
fn random_ray(scene: &Scene, rng: &mut Rng) -> Ray {
    let origin = match rng.below(4) {
        0 => scenes::point_on(scene, rng),
        1 => rng.point(1.0),
        _ => rng.direction() * rng.range(1.0, 5.0),
    };
    let target = match rng.below(3) {
        0 => scenes::point_on(scene, rng),
        _ => rng.point(0.8),
    };
    let length = rng.pick(&[1.0, 1.0, 0.01, 300.0]);
    Ray::new(origin, (target - origin + rng.point(0.01)) * length)
}

/// Hits that a ray refuses, besides those at or before `tnear`.
#[derive(Clone, Copy, Debug)]
enum RefusedHits {
    Nothing,
    /// Hits up to this distance on primitives with odd numbers.
    OddUntil(f32),
    /// Hits at which the ray enters a primitive.
    Entries,
}

/// A ray with its filter.
#[derive(Clone, Copy, Debug)]
struct FilteredRay {
    ray: Ray,
    tnear: f32,
    ignore: u32,
    refusal: RefusedHits,
    /// The hit whose distance is `tnear`, if there is one.
    at: Option<Hit>,
}

impl FilteredRay {
    fn random(bvh: &Bvh, ray: Ray, rng: &mut Rng) -> FilteredRay {
        let first = bvh.intersect(&ray);
        let speed = Vec3::from(ray.direction).length();
        let mut filtered = FilteredRay {
            ray,
            tnear: 0.0,
            ignore: NO_PRIM,
            refusal: RefusedHits::Nothing,
            at: None,
        };
        match rng.below(6) {
            0 => {}
            1 => filtered.tnear = 1e-3 / speed,
            2 => filtered.tnear = rng.range(0.0, 5.0) / speed,
            3 => {
                filtered.tnear = first.map_or(0.0, |hit| hit.t);
                filtered.at = first;
            }
            4 => filtered.refusal = RefusedHits::OddUntil(rng.range(0.0, 5.0) / speed),
            _ => filtered.refusal = RefusedHits::Entries,
        }
        if rng.once_in(4) {
            filtered.ignore = first.map_or(NO_PRIM, |hit| hit.prim_id);
        }
        if rng.once_in(4) {
            filtered.ray.tmax = rng.range(0.0, 8.0) / speed;
        }
        filtered
    }

    /// True if f32 has to accept a crossing, false if it has to refuse it, and `None` if both may
    /// be.
    fn accepts(&self, prim_id: u32, all: &[Crossing], k: usize) -> Option<bool> {
        let Crossing {
            t, error, leaves, ..
        } = all[k];
        let is_beyond = |limit: f32| match t - f64::from(limit) {
            apart if apart.abs() <= error => None,
            apart => Some(apart > 0.0),
        };
        let is_twofold = all.len() == 2 && all[1].t - all[0].t <= 4.0 * error;
        let is_behind = match self.at.filter(|hit| hit.prim_id == prim_id) {
            // This is the hit itself, so `tnear` refuses it.
            Some(hit) if (t - f64::from(hit.t)).abs() <= error => (!is_twofold).then_some(false),
            _ => is_beyond(self.tnear),
        };
        let is_suitable = match self.refusal {
            RefusedHits::Nothing => Some(true),
            RefusedHits::OddUntil(limit) if prim_id % 2 == 1 => is_beyond(limit),
            RefusedHits::OddUntil(_) => Some(true),
            RefusedHits::Entries if is_twofold => None,
            RefusedHits::Entries => Some(leaves),
        };
        let tests = [
            is_beyond(0.0),
            is_behind,
            is_beyond(self.ray.tmax).map(|beyond| !beyond),
            is_suitable,
            Some(prim_id != self.ignore),
        ];
        if tests.contains(&Some(false)) {
            return Some(false);
        }
        (all[k].sure && !tests.contains(&None)).then_some(true)
    }
}

/// Sums over all rays.
#[derive(Debug, Default)]
struct CrossingSums {
    rays: usize,
    hits: usize,
    /// Hits on far sides whose near side lies ahead of the origin.
    far_sides: usize,
    /// Primitives whose hit f64 cannot decide.
    undecided: usize,
}

impl CrossingSums {
    /// Compares a ray's list with f64, primitive by primitive.
    fn judge(&mut self, scene: &Scene, curved: &[u32], ray: &FilteredRay, list: &[Hit]) {
        self.rays += 1;
        for &prim_id in curved {
            let all = crossings(scene, prim_id, &ray.ray);
            let mut hits = list.iter().filter(|hit| hit.prim_id == prim_id);
            let hit = hits.next();
            assert_eq!(hits.next(), None, "{ray:?}: {prim_id} is hit twice");
            self.hits += usize::from(hit.is_some());
            let mut possible = Vec::new();
            let mut is_met = false;
            for (k, crossing) in all.iter().enumerate() {
                let accepts = ray.accepts(prim_id, &all, k);
                if accepts != Some(false) {
                    possible.push(crossing);
                }
                if accepts == Some(true) {
                    is_met = true;
                    self.far_sides += usize::from(k == 1 && all[0].t > all[0].error);
                    break;
                }
            }
            self.undecided += usize::from(possible.len() > usize::from(is_met));
            match hit {
                None => assert!(!is_met, "{ray:?}: {prim_id} is missed: {all:?}"),
                Some(hit) => {
                    let agrees = |candidate: &&Crossing| {
                        (f64::from(hit.t) - candidate.t).abs() <= candidate.error
                    };
                    assert!(possible.iter().any(agrees), "{ray:?}: {hit:?} of {all:?}");
                }
            }
        }
    }
}

/// The first crossing of each primitive that a filter accepts, by the oracle.
fn first_accepted(all: &[OracleHit], accepts: impl Fn(&OracleHit) -> bool) -> Vec<OracleHit> {
    let mut first: Vec<OracleHit> = Vec::new();
    for hit in all.iter().filter(|hit| accepts(hit)) {
        if first.iter().all(|before| before.prim_id != hit.prim_id) {
            first.push(*hit);
        }
    }
    first
}

fn oracle_ray(ray: &Ray) -> OracleRay {
    OracleRay::new(ray.origin.into(), ray.direction.into())
}

/// Checks the single calls of a ray against each other and the oracle; returns its list.
fn list_of(scene: &Scene, bvh: &Bvh, oracle: &Oracle, filtered: &FilteredRay) -> Vec<Hit> {
    let FilteredRay { ray, .. } = filtered;
    let accept = |hit: &Hit| match filtered.refusal {
        RefusedHits::Nothing => true,
        RefusedHits::OddUntil(limit) => hit.prim_id.is_multiple_of(2) || hit.t > limit,
        RefusedHits::Entries => {
            let [origin, direction] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
            let normal = DVec3::from(refine(scene, origin, direction, hit).normal);
            normal.dot(direction.into()) > 0.0
        }
    };
    let filter = RayFilter {
        tnear: filtered.tnear,
        ignore: filtered.ignore,
        accept: &accept,
        ..RayFilter::default()
    };
    let list = bvh.all_hits_filtered(ray, &filter);
    assert_eq!(bvh.intersect_filtered(ray, &filter), list.first().copied());
    assert_eq!(bvh.occluded_filtered(ray, &filter), !list.is_empty());
    let expected = first_accepted(&oracle.crossings(&oracle_ray(ray)), |hit| {
        let hit = Hit {
            t: hit.t,
            u: hit.u,
            v: hit.v,
            prim_id: hit.prim_id,
            geom_id: 0,
        };
        hit.t > filter.tnear && hit.t < ray.tmax && hit.prim_id != filter.ignore && accept(&hit)
    });
    let words = |hit: &Hit| {
        let [t, u, v] = [hit.t, hit.u, hit.v].map(f32::to_bits);
        (t, u, v, hit.prim_id)
    };
    let actual: Vec<_> = list.iter().map(words).collect();
    let expected: Vec<_> = expected.iter().map(hit_bits).collect();
    assert_eq!(actual, expected, "{filtered:?}");
    list
}

/// Checks that batches give the lists of single calls, for the rays without a closure.
fn assert_batches(bvh: &Bvh, all: &[(FilteredRay, Vec<Hit>)]) {
    let plain = |(ray, _): &&(FilteredRay, Vec<Hit>)| matches!(ray.refusal, RefusedHits::Nothing);
    let plain: Vec<_> = all.iter().filter(plain).collect();
    let rays: RayBuffer = plain.iter().map(|(filtered, _)| filtered.ray).collect();
    let tnear: Vec<f32> = plain.iter().map(|(filtered, _)| filtered.tnear).collect();
    let ignore: Vec<u32> = plain.iter().map(|(filtered, _)| filtered.ignore).collect();
    let filter = BatchFilter {
        tnear: PerRay::Each(&tnear),
        ignore: PerRay::Each(&ignore),
        ..BatchFilter::default()
    };
    let (mut hits, mut blocked) = (HitBuffer::new(plain.len()), vec![false; plain.len()]);
    let columns = rays.columns();
    let lengths = "columns of one length";
    bvh.intersect_batch_filtered(&columns, &filter, &mut hits.columns(), 1)
        .expect(lengths);
    bvh.occluded_batch_filtered(&columns, &filter, &mut blocked, 1)
        .expect(lengths);
    let lists = bvh.all_hits_batch_filtered(&columns, &filter, 1);
    let lists = lists.expect(lengths);
    for (k, (ray, list)) in plain.into_iter().enumerate() {
        assert_eq!(hits.get(k), list.first().copied(), "{ray:?}");
        assert_eq!(blocked[k], !list.is_empty(), "{ray:?}");
        assert!(lists.of(k).eq(list.iter().copied()), "{ray:?}");
    }
}

/// Checks one scene: all calls for random rays and filters, and every kernel without a filter.
fn judge_scene(seed: u64, rays: usize) -> CrossingSums {
    let mut rng = Rng::new(seed);
    let scene = random_scene(&mut rng, seed.is_multiple_of(2));
    let (tree, bvh) = (TwoLevelBvh::build(&scene), Bvh::build(&scene));
    let search = match seed % 4 {
        0 | 1 => OracleSearch::Tree(&tree),
        _ => OracleSearch::BruteForce,
    };
    let oracle = Oracle::new(&scene, search);
    let curved = curved_prims(&scene);
    let mut tally = CrossingSums::default();
    let mut all = Vec::new();
    for _ in 0..rays {
        let ray = random_ray(&scene, &mut rng);
        let filtered = FilteredRay::random(&bvh, ray, &mut rng);
        let list = list_of(&scene, &bvh, &oracle, &filtered);
        tally.judge(&scene, &curved, &filtered, &list);
        all.push((filtered, list));
    }
    assert_batches(&bvh, &all);
    let mut engines = Engines::new(&scene, &tree, &bvh);
    for eight in all.chunks(8).step_by(8) {
        let rays: Vec<OracleRay> = eight.iter().map(|(ray, _)| oracle_ray(&ray.ray)).collect();
        let hits = engines.closest_of(&rays);
        for (ray, hit) in rays.iter().zip(hits) {
            let crossings = oracle.crossings(ray);
            let first = crossings.first().map(hit_bits);
            assert_eq!(first, hit.as_ref().map(hit_bits), "{ray:?}");
        }
        engines.occluded_of(&rays, 1.0);
    }
    tally
}

#[test]
fn rays_find_the_far_sides_that_f64_finds() {
    const RAYS: usize = 1000;
    let scenes = full_or(1000, 200);
    let threads = thread_count(0) as u64;
    let tallies: Vec<CrossingSums> = std::thread::scope(|scope| {
        let workers = (0..threads).map(|first| {
            let seeds = (first..scenes).step_by(threads as usize);
            scope.spawn(move || {
                seeds
                    .map(|seed| judge_scene(seed, RAYS))
                    .collect::<Vec<_>>()
            })
        });
        let workers: Vec<_> = workers.collect();
        workers
            .into_iter()
            .flat_map(|worker| worker.join().expect("a judgment"))
            .collect()
    });
    let sum = |counter: fn(&CrossingSums) -> usize| tallies.iter().map(counter).sum::<usize>();
    let (rays, hits) = (sum(|t| t.rays), sum(|t| t.hits));
    let (far_sides, undecided) = (sum(|t| t.far_sides), sum(|t| t.undecided));
    println!("{rays} rays, {hits} hits, {far_sides} on far sides, {undecided} undecided");
    assert!(far_sides > rays / 8, "only {far_sides} on far sides");
    let share = undecided as f64 / hits as f64;
    assert!(share < UNDECIDED_CROSSINGS, "{undecided} of {hits}");
}
