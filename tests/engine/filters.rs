//! Rays that choose what they hit, against the list of all crossings of the oracle.

use super::front_door::mixed_scene;
use crate::common::rng::Rng;
use phalanx::oracle::{Oracle, OracleHit, OracleRay, OracleSearch};
use phalanx::{
    BatchFilter, Bvh, Hit, HitBuffer, HitColumns, NO_PRIM, PerRay, Ray, RayBuffer, RayFilter, Scene,
};
use std::cell::RefCell;
use std::sync::Mutex;

type FilteredBits = ([u32; 3], u32, u32);

fn bits(hit: &Hit) -> FilteredBits {
    let numbers = [hit.t, hit.u, hit.v].map(f32::to_bits);
    (numbers, hit.prim_id, hit.geom_id)
}

/// The mask of a primitive and its geometry, searched one by one.
fn geometry_of(scene: &Scene, prim_id: u32) -> (u32, u32) {
    let starts = scene.geometry_starts();
    let last = starts.iter().rev().find(|(first, _)| *first <= prim_id);
    let geometry = last.expect("a run").1;
    let mask = scene.geometries.mask.get(geometry as usize);
    (geometry, mask.copied().unwrap_or(u32::MAX))
}

/// The first crossing of each primitive that a filter accepts, in order.
fn expected(scene: &Scene, all: &[OracleHit], tmax: f32, filter: &RayFilter) -> Vec<FilteredBits> {
    let hit = |hit: &OracleHit| Hit {
        t: hit.t,
        u: hit.u,
        v: hit.v,
        prim_id: hit.prim_id,
        geom_id: geometry_of(scene, hit.prim_id).0,
    };
    let accepted = all.iter().map(hit).filter(|hit| {
        filter.tnear < hit.t
            && hit.t < tmax
            && hit.prim_id != filter.ignore
            && geometry_of(scene, hit.prim_id).1 & filter.mask != 0
            && (filter.accept)(hit)
    });
    let mut first: Vec<FilteredBits> = Vec::new();
    for hit in accepted.map(|hit| bits(&hit)) {
        if first.iter().all(|before| before.1 != hit.1) {
            first.push(hit);
        }
    }
    first
}

/// A scene of all kinds of primitives, some of whose geometries have masks, one is hidden.
fn masked_scene(random: &mut Rng, seed: u64) -> Scene {
    let mut scene = mixed_scene(seed);
    for geometry in 0..scene.geometries.len() as u32 {
        let mask = match random.below(5) {
            0 => 0,
            1 => u32::MAX,
            _ => 1 << random.below(4),
        };
        scene.set_mask(geometry, mask).expect("a geometry");
    }
    scene
}

fn random_ray(random: &mut Rng) -> Ray {
    let tmax = match random.below(3) {
        0 => f32::INFINITY,
        _ => random.range(0.0, 3.0),
    };
    Ray {
        tmax,
        ..Ray::new(random.point(1.5), random.point(1.0))
    }
}

/// Checks single calls and batches for random scenes, rays and filters.
#[test]
fn filters_choose_among_the_crossings_of_the_oracle() {
    let mut random = Rng::new(51);
    let (mut hits, mut chosen) = (0, 0);
    for seed in 0..12 {
        let scene = masked_scene(&mut random, seed);
        let bvh = Bvh::build(&scene);
        let oracle = Oracle::new(&scene, OracleSearch::BruteForce);
        let count = 300;
        let rays: Vec<Ray> = (0..count).map(|_| random_ray(&mut random)).collect();
        let lists: Vec<Vec<OracleHit>> = rays
            .iter()
            .map(|ray| oracle.crossings(&OracleRay::new(ray.origin.into(), ray.direction.into())))
            .collect();
        let odds = |hit: &Hit| !hit.prim_id.is_multiple_of(3) && hit.u <= 0.6;
        let (mut tnear, mut mask, mut ignore) = (Vec::new(), Vec::new(), Vec::new());
        for (ray, all) in rays.iter().zip(&lists) {
            let some = || all.first().copied();
            let filter = RayFilter {
                tnear: match random.below(4) {
                    0 => 0.0,
                    1 => -1.0,
                    2 => some().map_or(0.5, |hit| hit.t),
                    _ => random.range(0.0, 1.0),
                },
                mask: match random.below(2) {
                    0 => u32::MAX,
                    _ => random.below(16) as u32,
                },
                ignore: some().map_or(NO_PRIM, |hit| hit.prim_id),
                ..RayFilter::default()
            };
            tnear.push(filter.tnear);
            mask.push(filter.mask);
            ignore.push(filter.ignore);
            for filter in [
                filter,
                RayFilter {
                    accept: &odds,
                    ..filter
                },
            ] {
                let want = expected(&scene, all, ray.tmax, &filter);
                let actual = bvh.intersect_filtered(ray, &filter);
                assert_eq!(actual.as_ref().map(bits), want.first().copied(), "{ray:?}");
                assert_eq!(bvh.occluded_filtered(ray, &filter), !want.is_empty());
                let listed = bvh.all_hits_filtered(ray, &filter);
                assert_eq!(listed.iter().map(bits).collect::<Vec<_>>(), want, "{ray:?}");
                hits += all.len();
                chosen += want.len();
            }
            let plain = bvh.intersect_filtered(ray, &RayFilter::default());
            assert_eq!(plain, bvh.intersect(ray));
        }
        let filter = BatchFilter {
            tnear: PerRay::Each(&tnear),
            mask: PerRay::Each(&mask),
            ignore: PerRay::Each(&ignore),
            accept: None,
        };
        assert_batches(&bvh, &rays, &filter);
        // Where hits of curved surfaces are refused one side at a time.
        let accept = |ray: usize, hit: &Hit| (hit.t.to_bits() as usize + ray).is_multiple_of(2);
        let filter = BatchFilter {
            accept: Some(&accept),
            ..filter
        };
        assert_batches(&bvh, &rays, &filter);
    }
    assert!(chosen > 500 && hits > 2 * chosen, "{chosen} of {hits}");
}

/// Checks that filtered batches give the answers of single calls.
fn assert_batches(bvh: &Bvh, rays: &[Ray], filter: &BatchFilter) {
    let (PerRay::Each(tnear), PerRay::Each(mask), PerRay::Each(ignore)) =
        (filter.tnear, filter.mask, filter.ignore)
    else {
        panic!("columns");
    };
    let buffer: RayBuffer = rays.iter().copied().collect();
    let (mut hits, mut blocked) = (HitBuffer::new(rays.len()), vec![false; rays.len()]);
    let columns = buffer.columns();
    bvh.intersect_batch_filtered(&columns, filter, &mut hits.columns(), 2)
        .expect("columns of one length");
    bvh.occluded_batch_filtered(&columns, filter, &mut blocked, 2)
        .expect("columns of one length");
    let lists = bvh.all_hits_batch_filtered(&columns, filter, 2);
    let lists = lists.expect("columns of one length");
    let each = Mutex::new(HitBuffer::new(rays.len()));
    bvh.intersect_batch_filtered_each(&columns, filter, 2, |k, hit| {
        if let Some(hit) = hit {
            let mut hits = each.lock().expect("no panic");
            let HitColumns { t, prim_id, .. } = hits.columns();
            (t[k], prim_id[k]) = (hit.t, hit.prim_id);
        }
    })
    .expect("columns of one length");
    let each = each.into_inner().expect("no panic");
    for (k, ray) in rays.iter().enumerate() {
        let accept = |hit: &Hit| filter.accept.is_none_or(|accept| accept(k, hit));
        let filter = RayFilter {
            tnear: tnear[k],
            mask: mask[k],
            ignore: ignore[k],
            accept: &accept,
        };
        let hit = bvh.intersect_filtered(ray, &filter);
        let parts = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.prim_id));
        assert_eq!(parts(each.get(k)), parts(hit));
        assert_eq!((hits.get(k), blocked[k]), (hit, hit.is_some()));
        assert_eq!(
            lists.of(k).collect::<Vec<_>>(),
            bvh.all_hits_filtered(ray, &filter)
        );
    }
}

/// Checks that a closure may cast rays of its own, that limits count as documented, and that
/// columns of other lengths are refused.
#[test]
fn filters_may_cast_rays_and_ends_do_not_count() {
    let mut scene = Scene::new();
    scene
        .add_spheres(&[[0.0; 3], [0.0, 0.0, 5.0]], &[1.0, 1.0])
        .expect("spheres");
    let bvh = Bvh::build(&scene);
    let ray = Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
    let nested = RefCell::new(Vec::new());
    let accept = |hit: &Hit| {
        nested.borrow_mut().push(bvh.intersect(&ray));
        hit.prim_id == 1
    };
    let filter = RayFilter {
        accept: &accept,
        ..RayFilter::default()
    };
    assert_eq!(
        bvh.intersect_filtered(&ray, &filter).map(|hit| hit.t),
        Some(7.0)
    );
    let all = nested.into_inner();
    assert!(!all.is_empty() && all.iter().all(|hit| *hit == bvh.intersect(&ray)));

    let from = |tnear: f32| {
        let hit = bvh.intersect_filtered(
            &ray,
            &RayFilter {
                tnear,
                ..RayFilter::default()
            },
        );
        hit.map(|hit| hit.t)
    };
    assert_eq!(from(f32::from_bits(2f32.to_bits() - 1)), Some(2.0));
    // The far sides of both spheres count, too.
    assert_eq!([2.0, 4.0, 7.0].map(from), [Some(4.0), Some(7.0), Some(9.0)]);
    assert_eq!(
        (from(9.0), from(f32::INFINITY), from(f32::NAN)),
        (None, None, None)
    );
    let short = Ray { tmax: 2.0, ..ray };
    assert_eq!(bvh.intersect_filtered(&short, &RayFilter::default()), None);
    assert!(!bvh.occluded_filtered(&short, &RayFilter::default()));
    assert!(
        bvh.all_hits_filtered(&short, &RayFilter::default())
            .is_empty()
    );

    let rays: RayBuffer = [ray; 3].into_iter().collect();
    let filter = BatchFilter {
        mask: PerRay::Each(&[1; 2]),
        ..BatchFilter::default()
    };
    let mut hits = HitBuffer::new(3);
    let error = bvh.intersect_batch_filtered(&rays.columns(), &filter, &mut hits.columns(), 1);
    assert_eq!(error.expect_err("two masks").column, "mask");
}
