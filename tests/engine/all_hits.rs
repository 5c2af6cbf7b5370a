//! All hits of rays, and rays in rows, against the oracle: a list must contain, in order, the hits
//! that it finds on each primitive alone.

use crate::common::rng::Rng;
use crate::front_door::{mixed_scene, rays, soup};
use glam::{DAffine3, DQuat, DVec3};
use phalanx::bvh::Bvh;
use phalanx::oracle::{Oracle, OracleRay, OracleSearch};
use phalanx::scene::{Cone, Scene};
use phalanx::{Hit, HitBuffer, HitLists, Ray, RayBuffer, RayRows, TMax, refine};

fn bits(hit: &Hit) -> [u32; 4] {
    [
        hit.t.to_bits(),
        hit.u.to_bits(),
        hit.v.to_bits(),
        hit.prim_id,
    ]
}

/// A part of a scene, one primitive.
#[derive(Clone)]
enum LonePrim {
    Triangle([[f32; 3]; 3]),
    Sphere([f32; 3], f32),
    Round(Cone),
    Instance([[f32; 3]; 3], DAffine3),
}

/// Triangles, five of which coincide with others and share every distance, and spheres.
fn surfaces(random: &mut Rng, triangles: usize) -> Vec<LonePrim> {
    let (vertices, indices) = soup(random, triangles);
    let corners = |row: &[u32; 3]| row.map(|index| vertices[index as usize]);
    let mut pieces: Vec<LonePrim> = indices
        .iter()
        .map(|row| LonePrim::Triangle(corners(row)))
        .collect();
    pieces.extend(pieces[..5].to_vec());
    for k in 0..10 {
        let center = random.point(1.0).to_array();
        pieces.push(LonePrim::Sphere(center, 0.1 + 0.05 * k as f32));
    }
    pieces
}

/// Adds instances of the first few triangles.
fn add_instances(pieces: &mut Vec<LonePrim>) {
    for k in 0..8 {
        let LonePrim::Triangle(corners) = pieces[k] else {
            continue;
        };
        let turn = DQuat::from_rotation_y(k as f64);
        let map =
            DAffine3::from_scale_rotation_translation(DVec3::splat(0.7), turn, DVec3::X * 0.1);
        pieces.push(LonePrim::Instance(corners, map));
    }
}

fn add_cones(random: &mut Rng, pieces: &mut Vec<LonePrim>) {
    for k in 0..8 {
        let cone = Cone {
            base: random.point(1.0),
            base_radius: 0.2,
            apex: random.point(1.0),
            apex_radius: 0.05 * k as f32,
            inside: false,
        };
        pieces.push(LonePrim::Round(cone));
    }
}

/// A scene of pieces. Instances come last, so a primitive's number is its index.
fn scene_of(pieces: &[LonePrim]) -> (Scene, u32) {
    let mut scene = Scene::new();
    let mut prototypes = 0;
    for piece in pieces {
        match piece {
            LonePrim::Triangle(corners) => scene.add_mesh(corners, &[[0, 1, 2]]).map(drop).unwrap(),
            LonePrim::Sphere(center, radius) => {
                scene.add_spheres(&[*center], &[*radius]).map(drop).unwrap()
            }
            LonePrim::Round(cone) => drop(scene.add_cone(*cone, 0)),
            LonePrim::Instance(corners, map) => {
                let mesh = scene.add_prototype(corners, &[[0, 1, 2]]).unwrap();
                scene.add_instance(mesh, *map).unwrap();
                prototypes += 1;
            }
        }
    }
    (scene, prototypes)
}

/// The hits of rays on one piece, according to the oracle.
fn alone(piece: &LonePrim, prim_id: u32, rays: &[Ray]) -> Vec<Option<[u32; 4]>> {
    let (scene, _) = scene_of(std::slice::from_ref(piece));
    let oracle = Oracle::new(&scene, OracleSearch::BruteForce);
    let hit = |ray: &Ray| {
        let oracle_ray = OracleRay::new(ray.origin.into(), ray.direction.into());
        let hit = oracle.closest(&oracle_ray).filter(|hit| hit.t < ray.tmax)?;
        Some([hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), prim_id])
    };
    rays.iter().map(hit).collect()
}

#[test]
fn lists_hold_what_each_primitive_alone_is_hit_at() {
    for seed in 1..4 {
        let mut pieces = surfaces(&mut Rng::new(seed), 30);
        add_instances(&mut pieces);
        lists_are_those_of_each_alone(&pieces, &rays(seed, 6000));
    }
}

/// Divergent rays with a common limit are traced singly if the tree is large enough.
#[test]
fn lists_of_single_rays_hold_what_each_primitive_alone_is_hit_at() {
    for (seed, tmax) in [(4, f32::INFINITY), (5, 0.9)] {
        let mut random = Rng::new(seed);
        let mut pieces = surfaces(&mut random, 400);
        add_cones(&mut random, &mut pieces);
        let limited = |ray| Ray { tmax, ..ray };
        let all: Vec<Ray> = rays(seed, 6000).into_iter().map(limited).collect();
        lists_are_those_of_each_alone(&pieces, &all);
    }
}

fn lists_are_those_of_each_alone(pieces: &[LonePrim], all: &[Ray]) {
    let (scene, prototypes) = scene_of(pieces);
    // Prototypes are stored primitives, too, but nothing hits them.
    let number = |place: usize| match pieces[place] {
        LonePrim::Instance(..) => place as u32 + prototypes,
        _ => place as u32,
    };
    let columns = pieces.iter().enumerate();
    let columns = columns.map(|(place, piece)| alone(piece, number(place), all));
    let columns: Vec<_> = columns.collect();
    let bvh = Bvh::build(&scene);
    let buffer: RayBuffer = all.iter().copied().collect();
    let lists = bvh.all_hits_batch(&buffer.columns(), 2).unwrap();
    let mut counts = vec![7; all.len()];
    bvh.count_batch(&buffer.columns(), &mut counts, 2).unwrap();
    for (i, ray) in all.iter().enumerate() {
        let met = columns.iter().filter_map(|column| column[i]);
        let mut expected: Vec<[u32; 4]> = met.collect();
        expected.sort_by_key(|hit| (hit[0], hit[3]));
        let actual: Vec<[u32; 4]> = lists.of(i).map(|hit| bits(&hit)).collect();
        assert_eq!(actual, expected, "ray {i}: {ray:?}");
        assert_eq!(counts[i] as usize, expected.len(), "ray {i}: {ray:?}");
        assert_eq!(lists.of(i).next(), bvh.intersect(ray), "ray {i}: {ray:?}");
    }
    assert!(lists.t.len() > all.len() / 4, "{} hits", lists.t.len());
    assert!(
        lists.t.windows(2).any(|two| two[0] == two[1]),
        "no distance is shared"
    );
}

#[test]
fn lists_do_not_depend_on_threads_or_on_how_rays_are_split() {
    let bvh = Bvh::build(&mixed_scene(3));
    let all = rays(5, 9000);
    let lists = |rays: &[Ray], threads| {
        let buffer: RayBuffer = rays.iter().copied().collect();
        bvh.all_hits_batch(&buffer.columns(), threads).unwrap()
    };
    let unsplit = lists(&all, 1);
    assert_eq!(unsplit, lists(&all, 3));
    let mut parts = HitLists::empty();
    for part in all.chunks(1234) {
        parts.append(lists(part, 2));
    }
    assert_eq!(unsplit, parts);
    assert_eq!(lists(&[], 0), HitLists::empty());
}

#[test]
fn rows_give_the_same_bits_as_columns() {
    let bvh = Bvh::build(&mixed_scene(7));
    for (length, stride) in [(0, 3), (1, 6), (8, 7), (2049, 3), (5000, 6), (4097, 11)] {
        rows_are_as_columns(&bvh, &rays(11, length), stride);
    }
}

/// Compares a batch of rays in rows, `stride` numbers apart, with the same rays in columns.
fn rows_are_as_columns(bvh: &Bvh, all: &[Ray], stride: usize) {
    let length = all.len();
    let buffer: RayBuffer = all.iter().copied().collect();
    let mut expected = HitBuffer::new(length);
    bvh.intersect_batch(&buffer.columns(), &mut expected.columns(), 2)
        .unwrap();
    let tmax: Vec<f32> = all.iter().map(|ray| ray.tmax).collect();
    let numbers = |component: fn(&Ray) -> [f32; 3]| -> Vec<f32> {
        let mut rows = vec![f32::NAN; (length * stride).saturating_sub(stride - 3)];
        for (row, ray) in rows.chunks_mut(stride).zip(all) {
            row[..3].copy_from_slice(&component(ray));
        }
        rows
    };
    let (origin, direction) = (numbers(|ray| ray.origin), numbers(|ray| ray.direction));
    let rows = RayRows {
        origin: &origin,
        direction: &direction,
        stride,
        tmax: TMax::Each(&tmax),
    };
    assert_eq!(rows.len(), length);
    let mut hits = HitBuffer::new(length);
    bvh.intersect_batch(&rows, &mut hits.columns(), 2).unwrap();
    assert!(
        hits.iter().eq(expected.iter()),
        "{length} rays, stride {stride}"
    );
    let (mut dark, mut blocked) = (vec![true; length], vec![false; length]);
    bvh.occluded_batch(&rows, &mut dark, 2).unwrap();
    bvh.occluded_batch(&buffer.columns(), &mut blocked, 2)
        .unwrap();
    assert_eq!(dark, blocked, "{length} rays, stride {stride}");
}

#[test]
fn rows_that_are_none_are_refused() {
    let bvh = Bvh::build(&mixed_scene(7));
    let numbers = [0.5; 30];
    let rows = |origin, direction, stride, tmax| RayRows {
        origin,
        direction,
        stride,
        tmax,
    };
    let all = TMax::All(1.0);
    for (rows, column) in [
        (rows(&numbers[..30], &numbers[..27], 3, all), "direction"),
        (rows(&numbers[..30], &numbers[..30], 2, all), "stride"),
        (rows(&numbers[..30], &numbers[..30], 0, all), "stride"),
        (rows(&numbers, &numbers, usize::MAX, all), "stride"),
        (rows(&numbers, &numbers, usize::MAX / 4, all), "stride"),
        (rows(&[], &[], usize::MAX, all), "stride"),
        (
            rows(&numbers[..30], &numbers[..30], 3, TMax::Each(&numbers[..9])),
            "tmax",
        ),
    ] {
        let error = bvh.all_hits_batch(&rows, 1).unwrap_err();
        assert_eq!(error.column, column);
    }
    // A single ray has no next row, so its stride cannot lead out of the array.
    let one = rows(&numbers, &numbers, usize::MAX / 9, all);
    assert_eq!(one.len(), 1);
    assert!(bvh.all_hits_batch(&one, 1).is_ok());
}

/// Largest relative error of a refined distance: a few roundings of f64, times the condition
/// numbers of the triangles and spheres in these tests.
const REFINED: f64 = 1e-9;

#[test]
fn refined_hits_lie_on_their_surfaces() {
    let mut pieces = surfaces(&mut Rng::new(9), 30);
    add_instances(&mut pieces);
    let (scene, _) = scene_of(&pieces);
    let bvh = Bvh::build(&scene);
    let mut tested = 0;
    for ray in rays(21, 8000) {
        let Some(hit) = bvh.intersect(&ray) else {
            continue;
        };
        let refined = refine(
            &scene,
            ray.origin.map(f64::from),
            ray.direction.map(f64::from),
            &hit,
        );
        assert!(
            (refined.t - f64::from(hit.t)).abs() <= 1e-3 * (1.0 + refined.t.abs()),
            "{ray:?}"
        );
        let place = match hit.prim_id as usize {
            stored if stored < 45 => stored,
            shown => shown - 8,
        };
        let point = DVec3::from(refined.point);
        let normal = DVec3::from(refined.normal);
        let off = match &pieces[place] {
            LonePrim::Sphere(center, radius) => {
                let center = DVec3::from(center.map(f64::from));
                (point - center).dot(normal) - f64::from(*radius)
            }
            LonePrim::Round(_) => unreachable!("there are no cones"),
            LonePrim::Triangle(corners) => plane_distance(point, normal, corners.map(world)),
            LonePrim::Instance(corners, map) => {
                // The scene stores the map in single precision.
                let map = DAffine3 {
                    matrix3: map.matrix3.as_mat3().as_dmat3(),
                    translation: map.translation.as_vec3().as_dvec3(),
                };
                plane_distance(
                    point,
                    normal,
                    corners.map(|c| map.transform_point3(world(c))),
                )
            }
        };
        assert!(off.abs() < REFINED, "{off} off: {ray:?} {hit:?}");
        tested += 1;
    }
    assert!(tested > 3000, "only {tested} hits");
}

fn world(corner: [f32; 3]) -> DVec3 {
    DVec3::from(corner.map(f64::from))
}

/// Distance of a point from a triangle's plane with this normal.
fn plane_distance(point: DVec3, normal: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    assert!(normal.dot((b - a).cross(c - a)) >= 0.0);
    (point - a).dot(normal)
}

#[test]
fn pictures_give_the_same_bits_ray_by_ray() {
    let scene = mixed_scene(13);
    let bvh = Bvh::build(&scene);
    // Complete and partial bands and blocks, and rays after the last row.
    for (width, rows, more) in [(100, 83, 37), (64, 16, 0), (33, 9, 5)] {
        let ray = |k: usize| {
            let (x, y) = (
                (k % width) as f32 / width as f32,
                (k / width) as f32 / rows as f32,
            );
            let ray = Ray::new([0.3, 0.2, 4.0], [x - 0.5, y - 0.5, -1.0]);
            let tmax = if k.is_multiple_of(3) { 3.5 } else { f32::INFINITY };
            Ray { tmax, ..ray }
        };
        let all: Vec<Ray> = (0..width * rows + more).map(ray).collect();
        let buffer: RayBuffer = all.iter().copied().collect();
        for threads in [1, 2] {
            let mut hits = HitBuffer::new(all.len());
            let mut blocked = vec![false; all.len()];
            bvh.intersect_batch(&buffer.columns(), &mut hits.columns(), threads)
                .unwrap();
            bvh.occluded_batch(&buffer.columns(), &mut blocked, threads)
                .unwrap();
            for (i, ray) in all.iter().enumerate() {
                assert_eq!(hits.get(i), bvh.intersect(ray), "ray {i}");
                assert_eq!(blocked[i], bvh.occluded(ray), "ray {i}");
            }
            assert!(hits.iter().flatten().count() > all.len() / 10);
        }
        for stride in [3, 6, 7] {
            rows_are_as_columns(&bvh, &all, stride);
        }
    }
}
