//! The public calls against the oracle, bit for bit: single rays and batches of every length,
//! including invalid rays.

use crate::common::rng::Rng;
use crate::common::scenes;
use crate::common::tolerances::DISTANCE;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use phalanx::bvh::{BuildSettings, Bvh};
use phalanx::oracle::{Oracle, OracleRay, OracleSearch};
use phalanx::scene::{Cone, GeometryError, NO_GEOM, Scene};
use phalanx::{BatchError, Hit, HitBuffer, Ray, RayBuffer, RayColumns, RayFilter, TMax};
use std::time::{Duration, Instant};

/// Lengths around those of packets, pairs, beams and chunks.
const LENGTHS: [usize; 12] = [0, 1, 7, 8, 9, 15, 17, 511, 513, 1000, 4097, 9001];

/// Triangles that share vertices, half of them large.
pub(super) fn soup(random: &mut Rng, triangles: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut vertices: Vec<[f32; 3]> = (0..40).map(|_| random.point(1.0).to_array()).collect();
    let mut indices = Vec::new();
    for k in 0..triangles {
        if k % 2 == 0 {
            indices.push([(); 3].map(|()| random.below(40) as u32));
            continue;
        }
        let first = vertices.len() as u32;
        let center = random.point(1.0);
        vertices.extend([(); 3].map(|()| (center + 0.1 * random.point(1.0)).to_array()));
        indices.push([first, first + 1, first + 2]);
    }
    (vertices, indices)
}

/// A mesh, spheres, a cone that belongs to no geometry, and two instances of another mesh.
pub(super) fn mixed_scene(seed: u64) -> Scene {
    let mut random = Rng::new(seed);
    let mut scene = Scene::new();
    let (vertices, indices) = soup(&mut random, 300);
    assert_eq!(scene.add_mesh(&vertices, &indices), Ok(0));
    let cone = Cone {
        base: random.point(1.0),
        apex: random.point(1.0),
        base_radius: 0.2,
        apex_radius: 0.05,
        inside: false,
    };
    scene.add_cone(cone, 0);
    let centers: Vec<[f32; 3]> = (0..20).map(|_| random.point(1.0).to_array()).collect();
    let radii: Vec<f32> = (0..20)
        .map(|_| 0.11 + 0.1 * random.range(-1.0, 1.0))
        .collect();
    assert_eq!(scene.add_spheres(&centers, &radii), Ok(1));
    let (vertices, indices) = soup(&mut random, 40);
    let prototype = scene.add_prototype(&vertices, &indices).unwrap();
    for k in 0..2 {
        let turn = DQuat::from_rotation_y(f64::from(k) + 0.3);
        let place = DVec3::new(f64::from(random.range(-1.0, 1.0)), 0.5, 0.2);
        let map = DAffine3::from_scale_rotation_translation(DVec3::splat(0.4), turn, place);
        assert_eq!(scene.add_instance(prototype, map), Ok(2 + k));
    }
    scene.validate().expect("a sound scene");
    scene
}

/// A mesh large enough for single rays, and for beams.
fn mesh_scene(seed: u64) -> Scene {
    let (vertices, indices) = soup(&mut Rng::new(seed), 9000);
    let mut scene = Scene::new();
    scene.add_mesh(&vertices, &indices).unwrap();
    scene
}

/// Hundreds of rays of each kind: from one point, from everywhere, along axes, toward one point;
/// occasionally invalid.
pub(super) fn rays(seed: u64, count: usize) -> Vec<Ray> {
    let mut random = Rng::new(seed);
    let eye = [0.3, 0.2, 4.0];
    let ray = |k: usize| {
        let to = random.point(1.0).to_array();
        let mut ray = match k / 1024 % 4 {
            0 => Ray::segment(eye, to),
            1 => Ray::new(random.point(1.0).to_array(), to),
            2 => Ray::segment(to, eye),
            _ => Ray::new(to.map(|x| 1.5 * x), [0.0, -0.0, to[0].signum()]),
        };
        match k % 37 {
            3 => ray.tmax = 0.4 + random.range(-1.0, 1.0),
            5 => ray.direction = [0.0, -0.0, 0.0],
            7 => ray.origin[k % 3] = f32::NAN,
            11 => ray.direction[k % 3] = f32::NAN,
            13 => ray.direction[k % 3] = f32::INFINITY,
            17 => ray.tmax = f32::NAN,
            19 => ray.origin[k % 3] = f32::NEG_INFINITY,
            _ => {}
        }
        ray
    };
    (0..count).map(ray).collect()
}

/// The oracle's answer, with the limit applied here.
fn expected(oracle: &Oracle, ray: &Ray) -> (Option<[u32; 4]>, bool) {
    let oracle_ray = OracleRay::new(ray.origin.into(), ray.direction.into());
    let hit = oracle.closest(&oracle_ray).filter(|hit| hit.t < ray.tmax);
    let bits = hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim_id]);
    (bits, oracle.occluded(&oracle_ray, ray.tmax))
}

fn bits(hit: Option<Hit>) -> Option<[u32; 4]> {
    hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim_id])
}

fn batch(bvh: &Bvh, rays: &RayColumns, threads: usize) -> (HitBuffer, Vec<bool>) {
    let mut hits = HitBuffer::new(rays.len());
    let mut blocked = vec![true; rays.len()];
    bvh.intersect_batch(rays, &mut hits.columns(), threads)
        .unwrap();
    bvh.occluded_batch(rays, &mut blocked, threads).unwrap();
    (hits, blocked)
}

fn assert_oracle(scene: &Scene, bvh: &Bvh, rays: &[Ray], threads: usize) {
    let oracle = Oracle::new(scene, OracleSearch::BruteForce);
    let buffer: RayBuffer = rays.iter().copied().collect();
    let (hits, blocked) = batch(bvh, &buffer.columns(), threads);
    for (i, ray) in rays.iter().enumerate() {
        let (hit, dark) = expected(&oracle, ray);
        assert_eq!(bits(hits.get(i)), hit, "ray {i}: {ray:?}");
        assert_eq!(blocked[i], dark, "ray {i}: {ray:?}");
        assert_eq!(bits(bvh.intersect(ray)), hit, "ray {i} alone: {ray:?}");
        assert_eq!(bvh.occluded(ray), dark, "ray {i} alone: {ray:?}");
        assert_eq!(hits.get(i), bvh.intersect(ray), "ray {i}: {ray:?}");
    }
}

#[test]
fn answers_are_those_of_the_oracle() {
    for seed in 1..4 {
        let scene = mixed_scene(seed);
        let bvh = Bvh::build(&scene);
        assert_oracle(&scene, &bvh, &rays(seed, 5000), 1);
    }
}

#[test]
fn batches_may_have_any_length() {
    let scene = mixed_scene(5);
    let bvh = Bvh::build(&scene);
    for length in LENGTHS {
        assert_oracle(&scene, &bvh, &rays(length as u64, length), 2);
    }
}

/// A common limit allows every kernel, one per ray only packets: there must be no other difference.
#[test]
fn common_limits_give_the_same_bits_as_limits_of_each() {
    let scene = mesh_scene(7);
    let bvh = Bvh::build(&scene);
    bvh.build_wide(1);
    for common in [f32::INFINITY, 1.0, 0.3, 0.0, -1.0, f32::NAN] {
        let mut all = rays(9, 10_000);
        all.iter_mut().for_each(|ray| ray.tmax = common);
        let buffer: RayBuffer = all.iter().copied().collect();
        let each = buffer.columns();
        let same = RayColumns {
            tmax: TMax::All(common),
            ..each
        };
        let (hits, blocked) = batch(&bvh, &same, 2);
        // One limit that differs in every chunk.
        let mut limits = vec![common; all.len()];
        let odd = (0..all.len()).step_by(100);
        odd.clone().for_each(|i| limits[i] = 0.7);
        let apart = RayColumns {
            tmax: TMax::Each(&limits),
            ..each
        };
        let (other_hits, other_blocked) = batch(&bvh, &apart, 1);
        for i in (0..all.len()).filter(|i| i % 100 != 0) {
            assert_eq!(bits(hits.get(i)), bits(other_hits.get(i)), "{:?}", all[i]);
            assert_eq!(blocked[i], other_blocked[i], "{:?}", all[i]);
        }
        for (i, ray) in all.iter().enumerate().step_by(7) {
            assert_eq!(hits.get(i), bvh.intersect(ray), "{ray:?}");
            assert_eq!(blocked[i], bvh.occluded(ray), "{ray:?}");
        }
    }
}

#[test]
fn threads_do_not_change_answers() {
    let bvh = Bvh::build(&mesh_scene(11));
    let buffer: RayBuffer = rays(13, 30_000).into_iter().collect();
    let answers_on = |threads| {
        let (hits, blocked) = batch(&bvh, &buffer.columns(), threads);
        let hits: Vec<_> = hits.iter().map(bits).collect();
        (hits, blocked)
    };
    let one = answers_on(1);
    assert!(
        [0, 2, 7]
            .into_iter()
            .all(|threads| answers_on(threads) == one)
    );
    assert!(one.0.iter().flatten().count() > 1000);
}

#[test]
fn columns_may_begin_anywhere() {
    let scene = mixed_scene(17);
    let bvh = Bvh::build(&scene);
    let all = rays(19, 40);
    let buffer: RayBuffer = all.iter().copied().collect();
    let columns = buffer.columns();
    for from in 0..9 {
        let TMax::Each(tmax) = columns.tmax else {
            panic!("a buffer has limits of each")
        };
        let some = RayColumns {
            origin: columns.origin.map(|c| &c[from..from + 21]),
            direction: columns.direction.map(|c| &c[from..from + 21]),
            tmax: TMax::Each(&tmax[from..from + 21]),
        };
        let (hits, _) = batch(&bvh, &some, 1);
        for (hit, ray) in hits.iter().zip(&all[from..]) {
            assert_eq!(hit, bvh.intersect(ray));
        }
    }
}

#[test]
fn rays_that_are_none_miss() {
    let mut scene = Scene::new();
    scene.add_spheres(&[[0.0; 3]], &[2.0]).unwrap();
    let bvh = Bvh::build(&scene);
    let ahead = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
    assert_eq!(bvh.intersect(&ahead).map(|hit| hit.t), Some(2.0));
    let mut none = vec![
        Ray::new([0.0; 3], [0.0; 3]),
        Ray::new([0.0; 3], [-0.0; 3]),
        Ray::new([f32::INFINITY, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        Ray::new([0.0; 3], [f32::INFINITY, 0.0, 0.0]),
    ];
    none.extend([0.0, -1.0, f32::NAN].map(|tmax| Ray { tmax, ..ahead }));
    for axis in 0..3 {
        let (mut origin, mut direction) = (ahead, ahead);
        origin.origin[axis] = f32::NAN;
        direction.direction[axis] = f32::NAN;
        none.extend([origin, direction]);
    }
    for ray in &none {
        assert_eq!(bvh.intersect(ray), None, "{ray:?}");
        assert!(!bvh.occluded(ray), "{ray:?}");
    }
    // Among rays that hit.
    let mixed: RayBuffer = none.iter().flat_map(|&ray| [ray, ahead]).collect();
    let (hits, blocked) = batch(&bvh, &mixed.columns(), 1);
    assert!((0..hits.len()).all(|i| hits.get(i).is_some() == (i % 2 == 1)));
    assert!(
        blocked
            .iter()
            .enumerate()
            .all(|(i, &dark)| dark == (i % 2 == 1))
    );
}

#[test]
fn misses_say_so_in_every_column() {
    let bvh = Bvh::build(&Scene::new());
    let buffer: RayBuffer = [Ray::new([0.0; 3], [1.0; 3])].into_iter().collect();
    let (t, u, v) = (&mut [5.0], &mut [5.0], &mut [5.0]);
    let (prim_id, geom_id) = (&mut [5], &mut [5]);
    let mut hits = phalanx::HitColumns {
        t,
        u,
        v,
        prim_id,
        geom_id,
    };
    bvh.intersect_batch(&buffer.columns(), &mut hits, 1)
        .unwrap();
    assert_eq!((hits.t[0], hits.u[0], hits.v[0]), (f32::INFINITY, 0.0, 0.0));
    assert_eq!((hits.prim_id[0], hits.geom_id[0]), (u32::MAX, NO_GEOM));
}

#[test]
fn hits_name_their_geometry() {
    let mut scene = Scene::new();
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let moved_to = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
    let prototype = scene
        .add_prototype(&square, &[[0, 1, 2], [0, 2, 3]])
        .unwrap();
    let first = scene.add_instance(prototype, moved_to(10.0)).unwrap();
    let mesh = scene.add_mesh(&square, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    scene.add_sphere(Vec3::new(20.5, 0.5, 0.0), 0.25, 0);
    let empty = scene.add_mesh(&[], &[]).unwrap();
    let second = scene.add_instance(prototype, moved_to(30.0)).unwrap();
    let spheres = scene.add_spheres(&[[40.5, 0.5, 0.0]], &[0.25]).unwrap();
    let bvh = Bvh::build(&scene);
    let toward = |x: f32| Ray::new([x + 0.4, 0.6, 5.0], [0.0, 0.0, -1.0]);
    let hit_at = |x: f32| bvh.intersect(&toward(x)).expect("a hit");
    let actual = [0.0, 10.0, 20.0, 30.0, 40.0].map(|x| hit_at(x).geom_id);
    assert_eq!(actual, [mesh, first, NO_GEOM, second, spheres]);
    // Each ray hits the second triangle of its geometry.
    for (x, geometry) in [(0.0, mesh), (10.0, first), (30.0, second)] {
        assert_eq!(hit_at(x).prim_id - bvh.first_prim(geometry).unwrap(), 1);
    }
    assert_eq!(bvh.first_prim(empty), None);
    assert_eq!(bvh.first_prim(NO_GEOM), None);
    let buffer: RayBuffer = [0.0, 10.0, 20.0, 30.0, 40.0]
        .map(toward)
        .into_iter()
        .collect();
    let (hits, _) = batch(&bvh, &buffer.columns(), 1);
    assert!(hits.iter().map(|hit| hit.unwrap().geom_id).eq(actual));
}

#[test]
fn wrong_geometry_is_refused_and_nothing_added() {
    let mut scene = Scene::new();
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
    let mut holed = square;
    holed[1][2] = f32::NEG_INFINITY;
    let [fine, beyond] = [[[0, 1, 2]; 2], [[0, 1, 2], [0, 3, 1]]];
    let errors = [
        scene.add_mesh(&holed, &fine),
        scene.add_mesh(&square, &beyond),
        scene.add_spheres(&square, &[1.0; 2]),
        scene.add_spheres(&square, &[1.0, 1.0, -1.0]),
        scene.add_spheres(&square, &[f32::NAN, 1.0, 1.0]),
        scene.add_spheres(&holed, &[1.0; 3]),
        scene.add_prototype(&square, &[]),
    ];
    let messages = errors.map(|error| error.unwrap_err().to_string());
    assert_eq!(
        messages,
        [
            "vertex 1 is not finite: [1.0, 0.0, -inf]",
            "triangle 1 names vertex 3, and there are 3",
            "3 centres, but 2 radii",
            "sphere 2 has a radius of -1: radii are positive and finite",
            "sphere 0 has a radius of NaN: radii are positive and finite",
            "vertex 1 is not finite: [1.0, 0.0, -inf]",
            "a prototype without triangles",
        ]
    );
    assert_eq!((scene.prim_count(), scene.geometries.len()), (0, 0));
    assert_eq!(scene.materials.len(), 0);
    let lengths = scene.add_spheres(&[], &[1.0]);
    let (centers, radii) = (0, 1);
    assert_eq!(lengths, Err(GeometryError::Lengths { centers, radii }));
}

#[test]
fn columns_of_other_lengths_are_refused() {
    let bvh = Bvh::build(&mixed_scene(23));
    let (nine, ten) = ([0.5; 9], [0.5; 10]);
    let rays = RayColumns {
        origin: [&ten; 3],
        direction: [&ten; 3],
        tmax: TMax::Each(&ten),
    };
    let refuse = |rays: RayColumns, hits: usize, column: &'static str, len: usize| {
        let mut buffer = HitBuffer::new(hits);
        let actual = bvh.intersect_batch(&rays, &mut buffer.columns(), 1);
        assert_eq!(
            actual,
            Err(BatchError {
                column,
                len,
                rays: 10
            })
        );
        assert!(buffer.iter().all(|hit| hit.is_none()));
    };
    let origin = [&ten[..], &nine, &ten];
    refuse(RayColumns { origin, ..rays }, 10, "origin", 9);
    let direction = [&ten[..], &ten, &nine];
    refuse(RayColumns { direction, ..rays }, 10, "direction", 9);
    let tmax = TMax::Each(&nine);
    refuse(RayColumns { tmax, ..rays }, 10, "tmax", 9);
    refuse(rays, 11, "t", 11);
    let actual = bvh.occluded_batch(&rays, &mut [false; 3], 1);
    let expected = "the column blocked has 3 rows, and there are 10 rays";
    assert_eq!(actual.unwrap_err().to_string(), expected);
}

/// Directions of the lengths that [`Ray::direction`] documents, and surfaces of the sizes there.
#[test]
fn directions_of_the_documented_lengths_hit() {
    for size in [1e-6f32, 1e-3, 1.0, 1e3, 1e6] {
        let mut scene = Scene::new();
        let corner = |x: f32, y: f32| [x * size, y * size, 0.0];
        let square = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let mesh = scene.add_prototype(&square, &faces).unwrap();
        // Side by side, all in the plane z = 0 or tangent to it.
        let coordinate = |k: u32| Vec3::X * size * 4.0 * k as f32;
        scene.add_mesh(&square, &faces).unwrap();
        scene.add_sphere(coordinate(1) + Vec3::Z * size, size, 0);
        let half = Vec3::new(0.5, 1.0, 1.0) * size;
        scenes::add_ellipsoid(
            &mut scene,
            coordinate(2) + Vec3::Z * size,
            half,
            Vec3::ZERO,
            0,
        );
        let lying = |end: f32| coordinate(3) + Vec3::new(0.0, end, 1.0) * size;
        scene.add_cone(
            Cone {
                base: lying(-1.0),
                apex: lying(1.0),
                base_radius: size,
                apex_radius: size,
                inside: false,
            },
            0,
        );
        let place = DAffine3::from_translation(coordinate(4).as_dvec3());
        scene.add_instance(mesh, place).unwrap();
        let bvh = Bvh::build(&scene);
        let mut all = Vec::new();
        for length in [1e-12f32, 1.1e-12, 1e-6, 1.0, 1e6, 0.9e12, 1e12] {
            for (k, tilt) in (0..5).flat_map(|k| [0.0, 0.3].map(|tilt| (k, tilt))) {
                // From three sizes below to where each touches the plane, straight or at an angle.
                let toward = Vec3::new(tilt, 0.0, 1.0).normalize();
                let origin = coordinate(k) - toward * (3.0 * size / toward.z);
                all.push((
                    Ray::new(origin, toward * length),
                    3.0 * size / toward.z / length,
                ));
            }
        }
        let rays: Vec<Ray> = all.iter().map(|(ray, _)| *ray).collect();
        assert_oracle(&scene, &bvh, &rays, 1);
        for (ray, expected) in all {
            let hit = bvh
                .intersect(&ray)
                .unwrap_or_else(|| panic!("{size}: {ray:?}"));
            let error = (hit.t / expected - 1.0).abs();
            assert!(
                error < DISTANCE as f32,
                "{size}: {ray:?}: {hit:?}, {expected}"
            );
            assert!(bvh.occluded(&ray));
            let filter = RayFilter {
                tnear: 0.5 * expected,
                ..RayFilter::default()
            };
            assert_eq!(bvh.intersect_filtered(&ray, &filter), Some(hit));
        }
    }
}

/// More threads than there are CPUs or primitives change nothing, and don't take minutes.
#[test]
fn trees_take_no_more_threads_than_they_have_work_for() {
    let start = Instant::now();
    let (vertices, indices) = soup(&mut Rng::new(15), 50_000);
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(&vertices, &indices).unwrap();
    let build = |threads: usize| {
        let settings = BuildSettings {
            threads,
            ..BuildSettings::default()
        };
        let bvh = Bvh::build_with(&scene, &settings);
        bvh.build_wide(threads);
        bvh
    };
    let (mut many, one) = (build(usize::MAX), build(1));
    assert_eq!(format!("{:?}", many.nodes()), format!("{:?}", one.nodes()));
    scene.set_vertices(mesh, &vertices).unwrap();
    many.update(&scene);
    // A thread for each of the largest number took four minutes.
    assert!(start.elapsed() < Duration::from_secs(60));
}
