//! Meshes stored once and placed many times: the same answers from brute force and both engines'
//! trees, and known answers where there are any.

use crate::common::rays::{Engines, hit_bits, lane_bits, pack, toward};
use crate::common::rng::Rng;
use crate::common::scenes;
use crate::common::tolerances::PLACE;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use phalanx::bvh::{BuildSettings, Bvh, Quality};
use phalanx::frame::{Accel, Control, Engine, Settings, render};
use phalanx::oracle::{OracleRay, TwoLevelBvh};
use phalanx::scene::{Scene, SceneError};
use phalanx::{GeometryError, Ray, RayFilter};
use std::panic::{AssertUnwindSafe, catch_unwind};

fn with_engines(scene: &Scene, ask: impl FnOnce(&mut Engines)) {
    scene.validate().expect("a valid scene");
    let (forest, bvh) = (TwoLevelBvh::build(scene), Bvh::build(scene));
    ask(&mut Engines::new(scene, &forest, &bvh));
}

/// A random ray: from anywhere, including far away, toward a point on a primitive or anywhere.
fn random_ray(scene: &Scene, rng: &mut Rng, scale: f32) -> OracleRay {
    let reach = if rng.once_in(8) { 1000.0 } else { 2.0 };
    let org = rng.point(scale * reach);
    let target = if rng.once_in(2) { scenes::point_on(scene, rng) } else { rng.point(scale) };
    match rng.below(6) {
        // Along an axis, so that boxes are met edge on.
        0 => OracleRay::new(org, rng.pick(&[Vec3::X, -Vec3::Y, Vec3::Z])),
        _ => toward(org, target),
    }
}

#[test]
fn every_search_agrees() {
    let mut rng = Rng::new(71);
    let mut met = 0;
    for _ in 0..150 {
        let scale = rng.magnitude(-2.0, 3.0);
        let count = rng.below(12);
        let mut scene = scenes::random(&mut rng, count, scale);
        scenes::add_instances(&mut scene, &mut rng, scale, 0);
        if rng.once_in(2) {
            for _ in 0..4 {
                let map = scenes::extreme_map(&mut rng, scale);
                scene.add_instance(0, map).expect("an invertible map");
            }
        }
        let stored = scene.prim_count() as u32;
        with_engines(&scene, |engines| {
            for _ in 0..40 {
                let rays = [0; 8].map(|_| random_ray(&scene, &mut rng, scale));
                let hits = engines.closest_of(&rays);
                met += hits
                    .iter()
                    .flatten()
                    .filter(|h| h.prim_id >= stored)
                    .count();
                for tmax in [0.5, 1.0, f32::INFINITY] {
                    engines.occluded_of(&rays, tmax);
                }
            }
        });
    }
    assert!(met > 10_000, "only {met} hits on instances");
}

/// An instance with identity maps equals its mesh, bit for bit.
#[test]
fn an_unmoved_instance_is_the_mesh_itself() {
    let mut rng = Rng::new(72);
    for _ in 0..40 {
        let direct = scenes::random(&mut rng, 30, 1.0);
        let mut placed = direct.clone();
        placed.meshes.first.push(0);
        placed.meshes.count.push(direct.prim_count() as u32);
        placed.add_instance(0, DAffine3::IDENTITY).unwrap();
        if direct.prim_count() == 0 {
            continue;
        }
        let rays: Vec<[OracleRay; 8]> = (0..40)
            .map(|_| [0; 8].map(|_| random_ray(&direct, &mut rng, 1.0)))
            .collect();
        let mut truth = Vec::new();
        with_engines(&direct, |engines| {
            truth.extend(rays.iter().flat_map(|eight| engines.closest_of(eight)));
        });
        with_engines(&placed, |engines| {
            let actual = rays.iter().flat_map(|eight| engines.closest_of(eight));
            for (hit, want) in actual.zip(&truth) {
                let mut want = want.as_ref().map(hit_bits);
                if let Some(want) = &mut want {
                    want.3 += direct.prim_count() as u32;
                }
                assert_eq!(hit.as_ref().map(hit_bits), want);
            }
        });
    }
}

/// The first of several instances in the same position is hit, with any tree.
#[test]
fn ties_go_to_the_smaller_number() {
    let mut scene = scenes::bare();
    let mesh = scene.begin_mesh();
    scene.add_triangle([Vec3::ZERO, Vec3::X, Vec3::Y], None, 0);
    scene.end_mesh(mesh);
    for _ in 0..20 {
        scene.add_instance(mesh, DAffine3::IDENTITY).unwrap();
    }
    with_engines(&scene, |engines| {
        let hit = engines.closest(&toward(Vec3::new(0.2, 0.2, 3.0), Vec3::new(0.2, 0.2, 0.0)));
        assert_eq!(hit.map(|h| h.prim_id), Some(1));
    });
    // In the world itself the same triangle has a smaller number than in any instance.
    let direct = scene.add_triangle([Vec3::ZERO, Vec3::X, Vec3::Y], None, 0);
    with_engines(&scene, |engines| {
        let hit = engines.closest(&toward(Vec3::new(0.2, 0.2, 3.0), Vec3::new(0.2, 0.2, 0.0)));
        assert_eq!(hit.map(|h| h.prim_id), Some(direct));
    });
}

/// Hits inside an instance that the clamp to its box puts at one distance are a tie like any other:
/// the closest hit is the first of all hits. Directions so short that the slab test cannot tell
/// planes apart clamp many.
#[test]
fn clamped_ties_go_to_the_smaller_number() {
    let mut rng = Rng::new(79);
    let mut ties = 0;
    for _ in 0..60 {
        let mut scene = scenes::bare();
        scenes::add_instances(&mut scene, &mut rng, 1.0, 0);
        for _ in 0..3 {
            let map = scenes::extreme_map(&mut rng, 1.0);
            scene.add_instance(0, map).expect("an invertible map");
        }
        let bvh = Bvh::build(&scene);
        with_engines(&scene, |engines| {
            for _ in 0..40 {
                let rays = [0; 8].map(|_| {
                    let ray = random_ray(&scene, &mut rng, 1.0);
                    let tiny = rng.magnitude(-44.0, -20.0);
                    let shrunk = rng.pick(&[1.0, tiny]);
                    OracleRay::new(ray.org, ray.dir * shrunk)
                });
                let hits = engines.closest_of(&rays);
                for (ray, hit) in rays.iter().zip(hits) {
                    let all = engines.brute.all_hits(ray);
                    let first = all.first().map(hit_bits);
                    assert_eq!(hit.as_ref().map(hit_bits), first, "{ray:?}");
                    ties += usize::from(all.len() > 1 && all[0].t == all[1].t);
                    let ray = Ray::new(ray.org, ray.dir);
                    let hit = bvh.intersect(&ray);
                    assert_eq!(bvh.intersect_filtered(&ray, &RayFilter::default()), hit);
                    let listed = bvh.all_hits_filtered(&ray, &RayFilter::default());
                    assert_eq!(listed.first().copied(), hit, "{ray:?}");
                }
            }
        });
    }
    assert!(ties > 200, "only {ties} ties");
}

/// Rays inside an instance much smaller than its mesh, with directions so short that their
/// distances in the world end before the first triangle: the clamp puts all hits at the end of the
/// box, and the smallest number wins, not the triangle that is closest inside.
#[test]
fn hits_beyond_the_end_of_a_box_tie() {
    let mut rng = Rng::new(80);
    let mut reordered = 0;
    for _ in 0..30 {
        let mut scene = scenes::bare();
        let mesh = scene.begin_mesh();
        for _ in 0..40 {
            scene.add_triangle([0; 3].map(|_| rng.point(1.0)), None, 0);
        }
        scene.end_mesh(mesh);
        let mut map = scenes::random_map(&mut rng, 1e-3);
        map.matrix3 *= 1e-3;
        scene.add_instance(mesh, map).expect("an invertible map");
        let bvh = Bvh::build(&scene);
        with_engines(&scene, |engines| {
            for _ in 0..40 {
                let rays = [0; 8].map(|_| {
                    let inside = map.transform_point3(rng.point(0.3).as_dvec3());
                    let slow = rng.direction() * rng.magnitude(-27.0, -24.0);
                    OracleRay::new(inside.as_vec3(), slow)
                });
                for (ray, hit) in rays.iter().zip(engines.closest_of(&rays)) {
                    let all = engines.brute.all_hits(ray);
                    let first = all.first().map(hit_bits);
                    assert_eq!(hit.as_ref().map(hit_bits), first, "{ray:?}");
                    reordered += usize::from(all.len() > 1 && all[0].t == all[1].t);
                    let listed =
                        bvh.all_hits_filtered(&Ray::new(ray.org, ray.dir), &RayFilter::default());
                    let listed = listed.first().map(|hit| hit.prim_id);
                    assert_eq!(listed, hit.map(|hit| hit.prim_id), "{ray:?}");
                }
            }
        });
    }
    assert!(reordered > 1000, "only {reordered} ties");
}

/// A flat mesh lies entirely in the surface of its box, where rounding could lose it.
#[test]
fn a_flat_mesh_has_no_holes() {
    let mut rng = Rng::new(73);
    for _ in 0..300 {
        let mut scene = scenes::bare();
        let mesh = scene.begin_mesh();
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        scene.add_triangle(
            [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)],
            None,
            0,
        );
        scene.add_triangle(
            [corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
            None,
            0,
        );
        scene.end_mesh(mesh);
        let mut map = scenes::random_map(&mut rng, 100.0);
        if rng.once_in(2) {
            // In one plane of the world's axes.
            map.matrix3 =
                glam::DMat3::from_diagonal(DVec3::splat(f64::from(rng.magnitude(-3.0, 3.0))));
        }
        scene.add_instance(mesh, map).unwrap();
        with_engines(&scene, |engines| {
            let normal = map.matrix3.inverse().transpose() * DVec3::Z;
            let size = map.matrix3.x_axis.length().max(map.matrix3.y_axis.length());
            for _ in 0..16 {
                let (x, y) = (rng.range(-0.9, 0.9), rng.range(-0.9, 0.9));
                let target = map.transform_point3(corner(x, y).as_dvec3());
                let away = normal.normalize() * size * f64::from(rng.magnitude(-1.0, 2.0));
                let org = (target + away).as_vec3();
                let hit = engines.closest(&toward(org, target.as_vec3()));
                let t = hit
                    .unwrap_or_else(|| panic!("lost at {x} {y} of {map:?}"))
                    .t;
                let reach = (target.length() + size) / away.length();
                let bound = f64::from(PLACE) * (1.0 + reach) * 8.0;
                assert!(
                    (f64::from(t) - 1.0).abs() < bound.max(1e-5),
                    "{t} of {map:?}"
                );
            }
        });
    }
}

/// Rounding on the way into a flat mesh's space and back must not take it out of its own box.
#[test]
fn a_flat_mesh_stretched_out_of_all_proportion_has_no_holes() {
    let mut rng = Rng::new(77);
    for _ in 0..300 {
        let mut scene = scenes::bare();
        let mesh = scene.begin_mesh();
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        scene.add_triangle(
            [corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)],
            None,
            0,
        );
        scene.end_mesh(mesh);
        let map = scenes::extreme_map(&mut rng, 100.0);
        scene.add_instance(mesh, map).unwrap();
        with_engines(&scene, |engines| {
            for _ in 0..16 {
                let (x, y) = (rng.range(-0.2, 0.2), rng.range(-0.5, 0.2));
                let target = map.transform_point3(corner(x, y).as_dvec3());
                // From where the way in loses less than the triangle is wide.
                let above = map.transform_point3(DVec3::new(f64::from(x), f64::from(y), 3.0));
                let hit = engines.closest(&toward(above.as_vec3(), target.as_vec3()));
                assert!(hit.is_some(), "lost at {x} {y} of {map:?}");
            }
        });
    }
}

/// No ray leaves a closed mesh, regardless of its placement.
#[test]
fn closed_meshes_stay_closed() {
    let mut rng = Rng::new(74);
    for _ in 0..200 {
        let mut scene = scenes::bare();
        let mesh = scene.begin_mesh();
        for triangle in scenes::cube_triangles() {
            scene.add_triangle(triangle.map(scenes::cube_corner), None, 0);
        }
        scene.end_mesh(mesh);
        let reach = rng.magnitude(-1.0, 4.0);
        let map = scenes::random_map(&mut rng, reach);
        scene.add_instance(mesh, map).unwrap();
        with_engines(&scene, |engines| {
            for _ in 0..32 {
                // A corner or an edge is the hardest to keep closed.
                let sides = [0; 3].map(|_| {
                    let between = rng.range(-1.0, 1.0);
                    rng.pick(&[-1.0, 1.0, 0.0, between])
                });
                let target = map.transform_point3(Vec3::from_array(sides).as_dvec3());
                let inside = map.transform_point3((rng.point(0.5)).as_dvec3());
                let ray = toward(inside.as_vec3(), target.as_vec3());
                if ray.dir != Vec3::ZERO {
                    assert!(engines.closest(&ray).is_some(), "{ray:?} leaves {map:?}");
                }
            }
        });
    }
}

/// A picture of instances equals that of the same triangles in the world, up to rounding.
#[test]
fn instances_look_like_what_they_place() {
    let mut rng = Rng::new(75);
    let mut base = scenes::bare();
    base.lights
        .add_point(Vec3::new(3.0, 4.0, 8.0), Vec3::ONE, Vec3::X);
    base.view.eye = Vec3::new(0.0, 0.3, 4.0);
    (base.width, base.height) = (96, 72);
    let (mut direct, mut placed) = (base.clone(), base);
    let shape: Vec<([Vec3; 3], Option<[Vec3; 3]>)> = (0..60)
        .map(|_| {
            let center = rng.point(0.7);
            let normals = rng.once_in(2).then(|| [0; 3].map(|_| rng.direction()));
            ([0; 3].map(|_| center + rng.point(0.4)), normals)
        })
        .collect();
    let mesh = placed.begin_mesh();
    shape.iter().for_each(|&(corners, normals)| {
        placed.add_triangle(corners, normals, 0);
    });
    placed.end_mesh(mesh);
    for k in 0..5 {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.6, 0.9, 0.7),
            DQuat::from_scaled_axis(DVec3::new(0.3, f64::from(k), 0.1)),
            DVec3::new(f64::from(k) - 2.0, 0.3, 0.0),
        );
        placed.add_instance(mesh, map).unwrap();
        let turn = map.matrix3.inverse().transpose();
        for (corners, normals) in &shape {
            let corners = corners.map(|c| map.transform_point3(c.as_dvec3()).as_vec3());
            let normals = normals.map(|n| n.map(|n| (turn * n.as_dvec3()).as_vec3()));
            direct.add_triangle(corners, normals, 0);
        }
    }
    assert_eq!(placed.visible_count(), direct.visible_count());
    let picture = |scene: &Scene| {
        let prepared = Accel::build(scene, Engine::Simd);
        let frame = render(scene, &prepared, &Settings::of(scene), &Control::default());
        frame.expect("a frame").film
    };
    let (a, b) = (picture(&direct), picture(&placed));
    let near = |i: usize| (0..3).all(|c| (a.planes[c][i] - b.planes[c][i]).abs() < 2e-3);
    let pixels = a.planes[0].len();
    let same = (0..pixels).filter(|&i| near(i)).count();
    let dark = (0..pixels).filter(|&i| a.planes[0][i] == 0.0).count();
    assert!(dark < pixels * 7 / 10, "a picture of something");
    // Pixels on edges may fall to either side.
    assert!(same * 1000 >= pixels * 995, "{same} of {pixels}");
}

/// Neither tree depends on threads at any quality, and every quality gives the same picture.
#[test]
fn trees_of_any_quality_on_any_threads() {
    let mut rng = Rng::new(76);
    let mut scene = scenes::bare();
    // Many segments, and a cell with more objects than fit a chunk.
    for (count, middle, size) in [(90_000, 0.0, 10.0), (40_000, 3.0, 0.2)] {
        for _ in 0..count {
            let center = middle + rng.point(size);
            let corners = [0; 3].map(|_| center + rng.point(size / 100.0));
            scene.add_triangle(corners, None, 0);
        }
    }
    for _ in 0..3000 {
        let center = rng.point(10.0);
        scene.add_sphere(center, 0.05, 0);
    }
    let rays: Vec<[OracleRay; 8]> = (0..50)
        .map(|_| [0; 8].map(|_| random_ray(&scene, &mut rng, 10.0)))
        .collect();
    let forest = TwoLevelBvh::build(&scene);
    let mut first: Option<Vec<_>> = None;
    for (name, quality) in Quality::ALL {
        let trees = [1, 2, 3, 7, 16].map(|threads| {
            let tree = Bvh::build_with(&scene, &BuildSettings { quality, threads });
            tree.build_wide(threads);
            let nodes = tree.nodes().iter().map(|n| (n.boxes, n.first));
            let wide = tree.wide().nodes().iter().map(|n| (n.boxes, n.children));
            let blocks = tree.wide().triangles().iter().map(|b| b.prim_id);
            let rows = (nodes.collect::<Vec<_>>(), wide.collect::<Vec<_>>());
            (rows, blocks.collect::<Vec<_>>(), tree)
        });
        for other in &trees[1..] {
            let same = trees[0].0 == other.0 && trees[0].1 == other.1;
            assert!(same, "{name}: a tree depends on threads");
        }
        let mut engines = Engines::new(&scene, &forest, &trees[0].2);
        // Brute force over all rays takes too long here: compared with the oracle's tree instead.
        let hits: Vec<_> = rays
            .iter()
            .flatten()
            .map(|ray| engines.oracle.closest(ray).map(|h| hit_bits(&h)))
            .collect();
        let packets = rays.iter().flat_map(|eight| {
            let packet = pack(eight, |_| f32::INFINITY);
            let active = phalanx::lanes::LaneMask::first(8);
            let hits = engines.tracer.closest(&packet, active);
            (0..8).map(move |lane| lane_bits(&hits, lane))
        });
        let packets: Vec<_> = packets.collect();
        assert_eq!(packets, hits, "{name}");
        let first = first.get_or_insert(packets);
        assert_eq!(*first, hits, "{name}");
    }
}

/// Two triangles that face the camera, as an instanced mesh or directly in the world.
fn two_squares(size: f64, apart: f64, baked: bool, stored: f64) -> Scene {
    let mut scene = scenes::bare();
    let corner = |x: f64, y: f64, map: &DAffine3| {
        map.transform_point3(DVec3::new(x, y, 0.0) * stored)
            .as_vec3()
    };
    let square = |scene: &mut Scene, map: &DAffine3| {
        let [a, b] = [corner(-1.0, -1.0, map), corner(1.0, -1.0, map)];
        let [c, d] = [corner(1.0, 1.0, map), corner(-1.0, 1.0, map)];
        scene.add_triangle([a, b, c], None, 0);
        scene.add_triangle([a, c, d], None, 0);
    };
    let place = |x: f64| DAffine3 {
        matrix3: glam::DMat3::from_diagonal(DVec3::splat(size / stored)),
        translation: DVec3::new(x, 0.0, 0.0),
    };
    if baked {
        square(&mut scene, &place(0.0));
        square(&mut scene, &place(apart));
    } else {
        let mesh = scene.begin_mesh();
        square(&mut scene, &DAffine3::IDENTITY);
        scene.end_mesh(mesh);
        scene.add_instance(mesh, place(0.0)).unwrap();
        scene.add_instance(mesh, place(apart)).unwrap();
    }
    // Something in the world itself, behind.
    let far = |x: f64, y: f64| (DVec3::new(x, y, -1.0) * size).as_vec3();
    scene.add_triangle([far(-9.0, -9.0), far(9.0, -9.0), far(0.0, 9.0)], None, 0);
    scene.view.eye = DVec3::new(apart / 2.0, 0.0, apart * 2.0).as_vec3();
    scene.view.center = DVec3::new(apart / 2.0, 0.0, 0.0).as_vec3();
    scene.rescale_to_f32_range();
    scene
}

/// A scene is scaled as a whole, whether its small or large numbers are in meshes or in maps.
#[test]
fn meshes_and_maps_of_other_scales_are_seen_like_what_is_baked() {
    for (size, stored, apart) in [
        (1e11, 1.0, 3.0),
        (1e-11, 1.0, 3.0),
        // The largest allowed maps.
        (1e11, 1.0, 1e5),
        (1e-15, 1e-3, 3.0),
        (1.0, 1e-11, 3.0),
        (1.0, 1e11, 3.0),
        (1e14, 1e13, 3.0),
        (1.0, 1.0, 3.0),
    ] {
        let counts = [false, true].map(|baked| {
            let scene = two_squares(size, size * apart, baked, stored);
            let mut seen = Vec::new();
            let unit = f64::from(scene.scale);
            with_engines(&scene, |engines| {
                for k in 0..600 {
                    let (x, y) = (
                        f64::from(k % 30) / 5.0 - 1.53,
                        f64::from(k / 30) / 8.0 - 1.22,
                    );
                    let target = (DVec3::new(x, y, 0.0) * size * unit).as_vec3();
                    let hit = engines.closest(&toward(scene.view.eye, target));
                    seen.push(hit.map(|hit| (hit.t * 100.0).round()));
                }
            });
            seen
        });
        let met = counts[1].iter().flatten().count();
        assert!(met > 200, "{met} rays met squares of {size}");
        assert_eq!(
            counts[0], counts[1],
            "squares of {size}, stored as {stored}"
        );
    }
}

/// Invalid instances are errors when they are added: no panic in the tree's build, and no numbers
/// for a missing mesh.
#[test]
fn what_cannot_be_placed_is_refused() {
    let mut scene = scenes::bare();
    let mesh = scene.begin_mesh();
    scene.add_triangle([Vec3::ZERO, Vec3::X, Vec3::Y], None, 0);
    scene.end_mesh(mesh);
    for stretch in [1e38, 1e13, 1e-13] {
        let map = DAffine3::from_scale(DVec3::new(stretch, 1.0, 1.0));
        assert!(scene.add_instance(mesh, map).is_err(), "{stretch}");
    }
    assert!(scene.instances.is_empty());
    let mut far = scene.clone();
    let map = DAffine3::from_translation(DVec3::splat(3.402_823_4e38));
    far.add_instance(mesh, map).unwrap();
    assert!(far.validate().unwrap_err().to_string().contains("box"));
    let unfinished = scene.begin_mesh();
    for none in [unfinished, 7] {
        let refused = scene.add_instance(none, DAffine3::IDENTITY);
        assert_eq!(refused, Err(GeometryError::NoPrototype(none)));
    }
}

/// Each primitive of each instance has a 32-bit number; more would wrap around to 0.
#[test]
fn more_primitives_than_there_are_numbers_are_refused_wherever_they_come_from() {
    const PRIMS: usize = 1 << 20;
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let moved_to = |k: u32| DAffine3::from_translation(DVec3::new(f64::from(4 * k), 0.0, 0.0));
    let mut scene = Scene::new();
    let mesh = scene.add_prototype(&corners, &vec![[0, 1, 2]; PRIMS]);
    let mesh = mesh.expect("a mesh");
    let too_many = |ids: u64| GeometryError::TooManyShown(ids);
    let ids = 1 << 32;
    for k in 0..4094 {
        assert_eq!(scene.add_instance(mesh, moved_to(k)), Ok(k));
    }
    assert_eq!(scene.add_instance(mesh, moved_to(4094)), Err(too_many(ids)));
    let spheres = vec![[0.0; 3]; PRIMS];
    let triangles = vec![[0, 1, 2]; PRIMS];
    assert_eq!(
        scene.add_spheres(&spheres, &vec![1.0; PRIMS]),
        Err(too_many(ids))
    );
    assert_eq!(scene.add_mesh(&corners, &triangles), Err(too_many(ids)));
    assert_eq!(
        scene.add_prototype(&corners, &triangles),
        Err(too_many(ids))
    );
    scene.validate().expect("nothing was added");
    let bvh = Bvh::build(&scene);
    let ray = Ray::new([4.0 * 4093.0 + 0.25, 0.25, 9.0], [0.0, 0.0, -1.0]);
    let hit = bvh.intersect(&ray).expect("the last instance");
    assert_eq!((hit.geom_id, hit.prim_id), (4093, 4094 << 20));
    // Rows filled by hand.
    scene.instances.mesh.push(mesh);
    scene.instances.first.push(4094 << 20);
    scene.instances.name.push(phalanx::scene::NO_NAME);
    let maps = &mut scene.instances;
    for column in maps.to_world.iter_mut().chain(&mut maps.to_object) {
        column.push(column.get(0));
    }
    assert_eq!(scene.validate(), Err(SceneError::TooManyShown(ids)));
    let build = AssertUnwindSafe(|| Bvh::build(&scene));
    assert!(catch_unwind(build).is_err());
}
