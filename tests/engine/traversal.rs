//! Directions, origins and trees that are difficult for traversals. Every answer is compared
//! between brute force, the oracle's tree and the packet engine ([`Engines`]), and with the known
//! answer, if there is one.

use crate::common::rays::{Engines, toward};
use crate::common::rng::Rng;
use crate::common::scenes;
use crate::common::tolerances::PLACE;
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::oracle::{OracleRay, TwoLevelBvh};
use phalanx::scene::{Cone, Scene};

fn with_engines(scene: &Scene, ask: impl FnOnce(&mut Engines)) {
    scene.validate().expect("a valid scene");
    let (tree, bvh) = (TwoLevelBvh::build(scene), Bvh::build(scene));
    ask(&mut Engines::new(scene, &tree, &bvh));
}

/// A 3×3×3 grid of boxes of twelve triangles, side 1, centres 2 apart.
fn boxes() -> Scene {
    let mut scene = scenes::bare();
    for cell in 0..27 {
        let position = [cell % 3, cell / 3 % 3, cell / 9].map(|k| 2.0 * k as f32 - 2.0);
        add_box(&mut scene, Vec3::from_array(position), 0.5);
    }
    scene
}

fn add_box(scene: &mut Scene, center: Vec3, half: f32) {
    for triangle in scenes::cube_triangles() {
        let corners = triangle.map(|k| center + scenes::cube_corner(k) * half);
        scene.add_triangle(corners, None, 0);
    }
}

#[test]
fn every_octant() {
    let scene = boxes();
    with_engines(&scene, |engines| {
        let mut rng = Rng::new(21);
        for octant in 0..8 {
            let sign = |bit: usize| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let signs = Vec3::new(sign(0), sign(1), sign(2));
            for _ in 0..200 {
                let rays = [0; 8].map(|_| {
                    let dir = rng.point(1.0).abs() * signs;
                    OracleRay::new(rng.point(0.4) - dir * rng.range(0.0, 8.0), dir)
                });
                let hits = engines.closest_of(&rays);
                engines.occluded_of(&rays, 2.0);
                // Rays that start inside the middle box cannot leave it.
                for (ray, hit) in rays.iter().zip(hits) {
                    let inside = ray.org.abs().max_element() < 0.5;
                    assert!(!inside || hit.is_some(), "{ray:?} leaves a closed box");
                }
            }
        }
    });
}

#[test]
fn axis_parallel_rays_with_zeros_of_both_signs() {
    let scene = boxes();
    with_engines(&scene, |engines| {
        let mut rng = Rng::new(22);
        for axis in 0..3 {
            for (toward, zeros) in [(1.0, 0), (1.0, 1), (1.0, 2), (1.0, 3), (-1.0, 0), (-1.0, 3)] {
                let mut dir = Vec3::ZERO;
                dir[axis] = toward;
                for (bit, other) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().enumerate() {
                    dir[other] = if zeros >> bit & 1 == 1 { -0.0 } else { 0.0 };
                }
                // From inside the middle box, to its wall.
                let org = rng.point(0.4);
                let hit = engines.closest(&OracleRay::new(org, dir));
                let t = 0.5 - org[axis] * toward;
                let error = hit.map(|hit| (hit.t - t).abs());
                assert!(error.is_some_and(|e| e < PLACE), "{org} {dir}: {hit:?}");
                // Through the gaps between the boxes: nothing.
                let mut gap = Vec3::splat(1.0);
                gap[axis] = -10.0 * toward;
                assert_eq!(
                    engines.closest(&OracleRay::new(gap, dir)),
                    None,
                    "{gap} {dir}"
                );
                // Mixed with rays the other way.
                let rays = std::array::from_fn::<_, 8, _>(|k| {
                    let dir = if k % 2 == 0 { dir } else { -dir };
                    OracleRay::new(rng.point(3.0), dir)
                });
                engines.closest_of(&rays);
                engines.occluded_of(&rays, 1.5);
            }
        }
    });
}

/// Rays that run in the planes, along the edges and through the corners of the boxes.
#[test]
fn rays_along_box_faces() {
    let scene = boxes();
    with_engines(&scene, |engines| {
        let grid = [-2.5, -1.5, -0.5, 0.0, 0.5, 1.5, 2.5];
        for axis in 0..3 {
            for &a in &grid {
                let rays: Vec<OracleRay> = grid
                    .iter()
                    .map(|&b| {
                        let mut org = Vec3::new(a, b, a);
                        org[axis] = -7.0;
                        org[(axis + 1) % 3] = b;
                        let mut dir = Vec3::ZERO;
                        dir[axis] = 1.0;
                        OracleRay::new(org, dir)
                    })
                    .collect();
                let hits = engines.closest_of(&rays);
                engines.occluded_of(&rays, f32::INFINITY);
                for (ray, hit) in rays.iter().zip(hits) {
                    // Onto a face, its edges and corners included, whichever of its triangles that
                    // is.
                    let met = hit.map(|hit| hit.t);
                    assert_eq!(met, Some(4.5), "{ray:?}");
                }
            }
        }
        // Diagonals within a face's plane, and through opposite corners.
        for (org, dir) in [
            (Vec3::new(-5.0, -5.0, 0.5), Vec3::new(1.0, 1.0, 0.0)),
            (Vec3::new(-5.0, 0.5, 5.0), Vec3::new(1.0, 0.0, -1.0)),
            (Vec3::new(-5.0, -5.0, -5.0), Vec3::ONE),
            (Vec3::new(5.0, -5.0, 5.0), Vec3::new(-1.0, 1.0, -1.0)),
        ] {
            let hit = engines.closest(&OracleRay::new(org, dir));
            assert!(hit.is_some(), "{org} {dir}");
        }
    });
}

#[test]
fn origins_on_geometry() {
    let mut rng = Rng::new(23);
    for scale in [1e-3, 1.0, 1e6] {
        let scene = scenes::random(&mut rng, 80, scale);
        with_engines(&scene, |engines| {
            for _ in 0..1000 {
                let rays = [0; 8].map(|_| {
                    let org = scenes::point_on(&scene, &mut rng);
                    match rng.below(3) {
                        0 => OracleRay::new(org, rng.direction()),
                        1 => toward(org, org),
                        _ => toward(org, scenes::point_on(&scene, &mut rng)),
                    }
                });
                engines.closest_of(&rays);
                engines.occluded_of(&rays, 1.0);
            }
        });
    }
}

#[test]
fn partial_packets() {
    let mut rng = Rng::new(24);
    let scene = scenes::random(&mut rng, 60, 1.0);
    with_engines(&scene, |engines| {
        for _ in 0..500 {
            for count in 0..=8 {
                let rays: Vec<OracleRay> = (0..count)
                    .map(|_| toward(rng.point(3.0), rng.point(1.0)))
                    .collect();
                engines.closest_of(&rays);
                engines.occluded_of(&rays, 0.7);
            }
        }
    });
}

#[test]
fn an_empty_scene() {
    let scene = scenes::bare();
    with_engines(&scene, |engines| {
        let mut rng = Rng::new(25);
        for _ in 0..100 {
            let rays = [0; 8].map(|_| OracleRay::new(rng.point(1.0), rng.direction()));
            assert!(engines.closest_of(&rays).iter().all(Option::is_none));
            assert_eq!(engines.occluded_of(&rays, f32::INFINITY), 0);
            // Through the origin, where an empty leaf's box may lie.
            let through = [0; 8].map(|_| toward(rng.point(1.0), Vec3::ZERO));
            assert!(engines.closest_of(&through).iter().all(Option::is_none));
        }
    });
}

#[test]
fn one_primitive_of_each_kind() {
    let add: [fn(&mut Scene); 3] = [
        |scene| _ = scene.add_sphere(Vec3::ZERO, 1.0, 0),
        |scene| scenes::add_ellipsoid(scene, Vec3::ZERO, Vec3::new(2.0, 1.0, 0.5), Vec3::Y, 0),
        |scene| {
            let corners = [[-3.0, -3.0, 0.0], [3.0, -3.0, 0.0], [0.0, 3.0, 0.0]];
            scene.add_triangle(corners.map(Vec3::from_array), None, 0);
        },
    ];
    for add in add {
        let mut scene = scenes::bare();
        add(&mut scene);
        with_engines(&scene, |engines| {
            let mut rng = Rng::new(26);
            for _ in 0..500 {
                let rays = [0; 8].map(|_| toward(rng.point(5.0), rng.point(0.4)));
                let hits = engines.closest_of(&rays);
                assert!(hits.iter().flatten().all(|hit| hit.prim_id == 0));
                assert!(hits.iter().any(Option::is_some));
                engines.occluded_of(&rays, 0.9);
            }
        });
    }
}

/// No split separates copies: a leaf may hold them all, and the first wins.
#[test]
fn many_identical_primitives() {
    for copies in [2, 9, 100, 4000] {
        let mut scene = scenes::bare();
        for k in 0..copies {
            match k % 2 {
                0 => {
                    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
                    scene.add_triangle(corners, None, 0)
                }
                _ => scene.add_sphere(Vec3::splat(5.0), 1.0, 0),
            };
        }
        with_engines(&scene, |engines| {
            let mut rng = Rng::new(27);
            for _ in 0..20 {
                let rays = std::array::from_fn::<_, 8, _>(|k| match k % 2 {
                    0 => toward(rng.point(1.0) - Vec3::Z * 3.0, Vec3::new(0.25, 0.25, 0.0)),
                    _ => toward(rng.point(1.0) + 2.0, Vec3::splat(5.0)),
                });
                let hits = engines.closest_of(&rays);
                let ids: Vec<_> = hits.iter().map(|hit| hit.map(|hit| hit.prim_id)).collect();
                assert_eq!(
                    ids,
                    [0, 1].repeat(4).into_iter().map(Some).collect::<Vec<_>>()
                );
                assert_eq!(engines.occluded_of(&rays, 2.0), 0xff);
            }
        });
    }
}

/// All four kinds in the same place, so that a builder puts them into one leaf.
#[test]
fn mixed_kinds_in_one_leaf() {
    let mut rng = Rng::new(28);
    for count in 1..=6 {
        let mut scene = scenes::bare();
        for _ in 0..count {
            scene.add_sphere(rng.point(0.01), 1.0, 0);
            let axes = Vec3::new(1.0, 0.9, 1.1);
            scenes::add_ellipsoid(&mut scene, rng.point(0.01), axes, Vec3::X, 0);
            let corners = [0; 3].map(|_| rng.direction());
            scene.add_triangle(corners, None, 0);
            // As large as the others, so that their boxes are alike.
            scene.add_cone(
                Cone {
                    base: rng.point(0.01) - Vec3::X,
                    base_radius: 1.0,
                    apex: rng.point(0.01) + Vec3::X,
                    apex_radius: 0.9,
                    inside: false,
                },
                0,
            );
        }
        with_engines(&scene, |engines| {
            let mut kinds = [0u32; 4];
            for _ in 0..500 {
                let rays = [0; 8].map(|_| toward(rng.point(3.0), rng.point(1.0)));
                for hit in engines.closest_of(&rays).into_iter().flatten() {
                    kinds[scene.prims[hit.prim_id as usize].kind() as usize] += 1;
                }
                engines.occluded_of(&rays, 0.8);
            }
            assert!(
                kinds.iter().all(|&k| k > 0),
                "{kinds:?} of {count} of each kind"
            );
        });
    }
}

/// Nested triangles, each `ratio` times as large as the previous: every split removes one, so the
/// tree has maximum depth.
fn nested(count: usize, ratio: f32) -> Scene {
    let mut scene = scenes::bare();
    let mut size = 1e-9f32;
    for _ in 0..count {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.3], [0.0, 1.0, 0.3]];
        let corners = corners.map(|c| Vec3::from_array(c) * size);
        scene.add_triangle(corners, None, 0);
        size *= ratio;
    }
    scene
}

#[test]
fn deep_trees() {
    for (count, ratio) in [(40, 2.0), (80, 1.5), (300, 1.1), (1500, 1.02), (2500, 1.01)] {
        let scene = nested(count, ratio);
        let (tree, bvh) = (TwoLevelBvh::build(&scene), Bvh::build(&scene));
        println!(
            "{count} nested triangles: {} and {} deep",
            bvh.depth(),
            tree.world().depth()
        );
        let mut engines = Engines::new(&scene, &tree, &bvh);
        let mut rng = Rng::new(29);
        for k in 0..150 {
            let size = 1e-9 * ratio.powi((count * k / 150) as i32);
            let rays = [0; 8].map(|_| {
                let org = rng.point(2.0 * size);
                toward(org, Vec3::new(rng.unit(), rng.unit(), rng.unit()) * size)
            });
            engines.closest_of(&rays);
            engines.occluded_of(&rays, 1.0);
            // Into the corner that all share: every node is entered.
            let rays = [0; 8].map(|_| toward(rng.direction() * size, Vec3::ZERO));
            engines.closest_of(&rays);
            engines.occluded_of(&rays, 0.5);
        }
    }
}
