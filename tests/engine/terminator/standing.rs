//! Shadows of things that stand on a smooth surface of few triangles: those that they cast on its
//! facets.

use super::{add_globe, faceted, picture, seen_from};
use crate::common::frames::frame_of;
use crate::common::rng::Rng;
use glam::{Affine3A, DAffine3, DVec3, Quat, Vec3};
use phalanx::formats::{Options, ReadOptions, read_bytes};
use phalanx::frame::{Accel, Engine, Settings};
use phalanx::scene::{Material, Mesh, Scene};
use phalanx::{Bvh, Ray};

/// A smooth surface z = h(x, y) of `side` × `side` cells of a unit, centred on the axis.
struct Terrain {
    waves: [[f32; 4]; 3],
    side: i32,
}

impl Terrain {
    fn random(rng: &mut Rng) -> Terrain {
        let mut wave = || {
            let [x, y] = [0; 2].map(|_| rng.range(-1.2, 1.2));
            [x, y, rng.range(0.0, 6.0), rng.range(0.0, 0.5)]
        };
        Terrain {
            waves: [wave(), wave(), wave()],
            side: 6,
        }
    }

    /// Height, and unit normal.
    fn at(&self, x: f32, y: f32) -> (f32, Vec3) {
        let (mut height, mut slope) = (0.0, Vec3::Z);
        for [kx, ky, phase, size] in self.waves {
            let angle = kx * x + ky * y + phase;
            height += size * angle.sin();
            slope -= Vec3::new(kx, ky, 0.0) * (size * angle.cos());
        }
        (height, slope.normalize())
    }

    fn add(&self, scene: &mut Scene) {
        let corner = |i: i32, k: i32| {
            let [x, y] = [i, k].map(|c| c as f32 - self.side as f32 / 2.0);
            let (height, normal) = self.at(x, y);
            (Vec3::new(x, y, height), normal)
        };
        for (i, k) in (0..self.side).flat_map(|i| (0..self.side).map(move |k| (i, k))) {
            let [a, b] = [corner(i, k), corner(i + 1, k)];
            let [c, d] = [corner(i + 1, k + 1), corner(i, k + 1)];
            for corners in [[a, b, c], [a, c, d]] {
                let (points, normals) = (corners.map(|c| c.0), corners.map(|c| c.1));
                scene.add_triangle(points, Some(normals), 0);
            }
        }
    }
}

/// Adds a turned box of half sides `half`, shaded smoothly or not.
fn add_turned_box(scene: &mut Scene, map: Affine3A, half: Vec3, smooth: bool, material: u32) {
    let corner = |k: usize| {
        let corner_along = |axis: usize| if k >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let corner = Vec3::new(corner_along(0), corner_along(1), corner_along(2));
        let point = map.transform_point3(corner * half);
        (point, map.transform_vector3(corner).normalize())
    };
    for triangle in crate::common::scenes::cube_triangles() {
        let corners = triangle.map(corner);
        let normals = smooth.then(|| corners.map(|c| c.1));
        scene.add_triangle(corners.map(|c| c.0), normals, material);
    }
}

/// The same scene, with the normals that `--smooth` makes instead of those of its triangles.
fn smoothed(scene: &Scene) -> Scene {
    let (mut scene, mut text) = (scene.clone(), String::new());
    for k in 0..scene.triangles.len() {
        for corner in scene.triangles.corners(k) {
            text += &format!("v {} {} {}\n", corner.x, corner.y, corner.z);
        }
        text += "f -3 -2 -1\n";
    }
    let options = Options {
        read: ReadOptions {
            smooth: Some(60.0),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let read = read_bytes("obj", text.as_bytes(), &options).expect("a format");
    let made = read.expect("a scene").scene.triangles;
    (scene.triangles.normals, scene.triangles.vertex_normals) = (made.normals, made.vertex_normals);
    scene
}

/// Number of random terrains, each with a box of its own.
const BOXES: usize = 1000;

/// Pixels across a picture of a terrain.
const SIDE: u32 = 32;

/// Asserts that no box on a terrain loses its shadow: nothing of the terrain is lit where the box
/// lies between it and the sun, and no pixel is lit that the box darkens where shadows follow
/// facets. A box between is one of 98 % of its size, as pixels on the edge of its shadow may differ
/// by rounding. Every other one has made normals.
#[test]
fn boxes_on_smooth_terrains_lose_no_shadow() {
    let mut rng = Rng::new(64);
    let (mut hidden, mut darkened) = (0, 0);
    for number in 0..BOXES {
        let terrain = Terrain::random(&mut rng);
        let mut bare = seen_from(9.0, 6.0);
        (bare.width, bare.height) = (SIDE, SIDE);
        bare.materials.push(&Material {
            kd: Vec3::ZERO,
            ka: Vec3::ZERO,
            ke: Vec3::Z,
            ..Material::DEFAULT
        });
        let elevation = rng.range(0.05, 0.6);
        let azimuth = rng.range(0.0, std::f32::consts::TAU);
        let sun = Vec3::new(azimuth.cos(), azimuth.sin(), elevation).normalize();
        bare.lights.add_directional(sun, Vec3::ONE);
        terrain.add(&mut bare);
        let [x, y] = [0; 2].map(|_| rng.range(-2.0, 2.0));
        let size = rng.magnitude(-2.5, -0.6);
        let half = Vec3::from([0; 3].map(|_| size * rng.range(0.4, 1.0)));
        let across = 12.0 * half.max_element();
        (bare.view.eye, bare.view.center) = (Vec3::new(x, y, 9.0), Vec3::new(x, y, 0.0));
        bare.view.ortho = Some(across);
        let smooth = rng.once_in(2);
        let turn = Quat::from_axis_angle(rng.direction(), rng.range(0.0, 0.4));
        let ground = Bvh::build(&bare);
        let above = Ray::new(Vec3::new(x, y, 9.0), -Vec3::Z);
        let height = 9.0 - ground.intersect(&above).expect("ground").t;
        let place = Vec3::new(x, y, height + 0.5 * half.z);
        let map = Affine3A::from_rotation_translation(turn, place);
        let with_box = |scale: f32| {
            let mut scene = bare.clone();
            add_turned_box(&mut scene, map, half * scale, smooth, 1);
            if number % 2 == 1 { smoothed(&scene) } else { scene }
        };
        let standing = with_box(1.0);
        let pixels = |scene: &Scene| {
            let settings = Settings::of(scene);
            let film = frame_of(scene, &Accel::build(scene, Engine::Simd), settings).film;
            (film.planes[0].clone(), film.planes[2].clone())
        };
        let ((smooth_red, blue), (faceted_red, _)) =
            (pixels(&standing), pixels(&faceted(&standing)));
        let (bare_red, _) = pixels(&faceted(&bare));
        let mut alone = seen_from(9.0, 6.0);
        add_turned_box(&mut alone, map, half * 0.98, false, 0);
        let alone = Bvh::build(&alone);
        for pixel in 0..bare_red.len() {
            if blue[pixel] > smooth_red[pixel] {
                continue;
            }
            let coordinate = |k: u32| ((k as f32 + 0.5) / SIDE as f32 - 0.5) * across;
            let (column, row) = (pixel as u32 % SIDE, pixel as u32 / SIDE);
            let origin = Vec3::new(x + coordinate(column), y - coordinate(row), 9.0);
            let Some(hit) = ground.intersect(&Ray::new(origin, -Vec3::Z)) else {
                continue;
            };
            let point = origin - Vec3::Z * hit.t;
            let is_lit = smooth_red[pixel] > 0.0;
            // Rounding may let a ray pass the edge of a tiny box, whatever the terminator.
            if faceted_red[pixel] == 0.0 && alone.occluded(&Ray::new(point, sun)) {
                hidden += 1;
                assert!(
                    !is_lit,
                    "box {number}, pixel {column}, {row} is lit behind it"
                );
            }
            if bare_red[pixel] > 0.0 && faceted_red[pixel] == 0.0 {
                darkened += 1;
                assert!(
                    !is_lit,
                    "box {number}, pixel {column}, {row} lost its shadow"
                );
            }
        }
    }
    // Most boxes shade a few pixels of ground.
    assert!(hidden > 8 * BOXES, "{hidden}");
    assert!(darkened > 5 * BOXES, "{darkened}");
}

/// Pixels that are lit although they are dark with facets, more than a row from the lit ones.
fn lit_by_mistake(scene: &Scene) -> (usize, usize) {
    let (smooth, facets) = (picture(scene), picture(&faceted(scene)));
    let dark = facets.iter().filter(|&&red| red == 0.0).count();
    let lit = smooth
        .iter()
        .zip(&facets)
        .filter(|(s, f)| **s > 0.0 && **f == 0.0);
    (lit.count(), dark)
}

/// A table whose corner normals lean outward by ten degrees, seen from above.
fn add_table(scene: &mut Scene) {
    let corner = |x: f32, y: f32| {
        (
            Vec3::new(x, y, 0.0),
            Vec3::new(x * 0.15, y * 0.15, 1.0).normalize(),
        )
    };
    let [a, b, c, d] =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| corner(x, y));
    for corners in [[a, b, c], [a, c, d]] {
        scene.add_triangle(corners.map(|c| c.0), Some(corners.map(|c| c.1)), 0);
    }
}

/// A table in light from the left, which all of its normals face.
fn table() -> Scene {
    let mut scene = seen_from(4.0, 2.2);
    scene
        .lights
        .add_directional(Vec3::new(-1.0, 0.0, 0.5).normalize(), Vec3::ONE);
    add_table(&mut scene);
    scene
}

#[test]
fn a_smooth_stone_of_the_same_mesh_shades_its_ground() {
    let mut scene = table();
    let map = Affine3A::from_translation(Vec3::new(0.0, 0.0, 0.04));
    add_turned_box(&mut scene, map, Vec3::splat(0.05), true, 0);
    let mut in_mesh = seen_from(4.0, 2.2);
    in_mesh.lights = scene.lights.clone();
    let mesh = in_mesh.begin_mesh();
    add_table(&mut in_mesh);
    add_turned_box(&mut in_mesh, map, Vec3::splat(0.05), true, 0);
    in_mesh.end_mesh(mesh);
    in_mesh
        .add_instance(mesh, DAffine3::IDENTITY)
        .expect("invertible");
    for scene in [scene, in_mesh] {
        let (lit, dark) = lit_by_mistake(&scene);
        assert!(dark > 200, "{dark}");
        // The stone's own terminator is that of its normals.
        let allowed = own_terminator(&scene);
        assert_eq!(lit, allowed, "{dark} dark pixels");
    }
}

/// Pixels of the stone itself that are lit beyond its facets' terminator.
fn own_terminator(scene: &Scene) -> usize {
    let (smooth, facets) = (picture(scene), picture(&faceted(scene)));
    (0..smooth.len())
        .filter(|&pixel| {
            let [x, y] = super::place(pixel, 2.2);
            x.abs() < 0.06 && y.abs() < 0.06 && smooth[pixel] > 0.0 && facets[pixel] == 0.0
        })
        .count()
}

#[test]
fn an_instance_shades_another_of_the_same_prototype() {
    let mut scene = seen_from(4.0, 2.2);
    scene
        .lights
        .add_directional(Vec3::new(-1.0, 0.0, 0.5).normalize(), Vec3::ONE);
    let mesh = scene.begin_mesh();
    add_globe(&mut scene);
    scene.end_mesh(mesh);
    let flat = DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.3));
    let pebble = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.04, 0.1, 0.04),
        glam::DQuat::IDENTITY,
        DVec3::new(0.0, 0.0, 0.3),
    );
    for map in [flat, pebble] {
        scene.add_instance(mesh, map).expect("invertible");
    }
    let mut alone = seen_from(4.0, 2.2);
    alone.lights = scene.lights.clone();
    let mesh = alone.begin_mesh();
    add_globe(&mut alone);
    alone.end_mesh(mesh);
    alone.add_instance(mesh, flat).expect("invertible");
    let [with, without] = [&scene, &alone].map(picture);
    let [facets_with, facets_without] = [faceted(&scene), faceted(&alone)].map(|s| picture(&s));
    let shaded = (0..with.len()).filter(|&k| facets_without[k] > 0.0 && facets_with[k] == 0.0);
    let shaded: Vec<usize> = shaded.collect();
    assert!(shaded.len() > 50, "{}", shaded.len());
    for k in shaded {
        let [x, y] = super::place(k, 2.2);
        let on_pebble = (x / 0.045).hypot(y / 0.105) < 1.0;
        assert!(
            on_pebble || with[k] == 0.0,
            "{x} {y}: {} {}",
            with[k],
            without[k]
        );
    }
}

/// A ridge of fine triangles, lower than the smooth surface is above the coarse ones beside it.
#[test]
fn a_ridge_shades_the_valley_of_its_own_mesh() {
    let mut scene = seen_from(4.0, 2.2);
    scene
        .lights
        .add_directional(Vec3::new(-1.0, 0.0, 0.4).normalize(), Vec3::ONE);
    let leaning = |x: f32| Vec3::new(x, 0.0, 1.0).normalize();
    // Position, height, and lean of the normal along x, of a profile that does not change along y.
    let profile = [
        (-1.0, 0.0, -0.1),
        (-0.30, 0.0, 0.0),
        (-0.25, 0.05, 0.0),
        (-0.20, 0.0, -0.3),
        (1.0, 0.0, 0.3),
    ];
    for pair in profile.windows(2) {
        let corner = |(x, z, lean): (f32, f32, f32), y: f32| (Vec3::new(x, y, z), leaning(lean));
        let [a, b] = [corner(pair[0], -1.0), corner(pair[1], -1.0)];
        let [c, d] = [corner(pair[1], 1.0), corner(pair[0], 1.0)];
        for corners in [[a, b, c], [a, c, d]] {
            scene.add_triangle(corners.map(|c| c.0), Some(corners.map(|c| c.1)), 0);
        }
    }
    let [smooth, facets] = [scene.clone(), faceted(&scene)].map(|scene| picture(&scene));
    let valley = (0..smooth.len()).filter(|&pixel| {
        let [x, y] = super::place(pixel, 2.2);
        (-0.19..-0.13).contains(&x) && y.abs() < 0.9
    });
    let valley: Vec<usize> = valley.collect();
    assert!(valley.len() > 500, "{}", valley.len());
    assert!(valley.iter().all(|&k| facets[k] == 0.0 && smooth[k] == 0.0));
}

/// Adds the sphere of 8 × 16 facets whose corners are moved in or out by up to 6 %, with the means
/// of the facets' normals.
fn add_bumpy_globe(scene: &mut Scene, rng: &mut Rng) {
    let radii: [[f32; 16]; 9] = [0; 9].map(|_| [0; 16].map(|_| rng.range(0.94, 1.06)));
    let point = |i: usize, k: usize| match i {
        0 | 8 => super::globe_point(i, 0),
        _ => super::globe_point(i, k % 16) * radii[i][k % 16],
    };
    let facets = (0..8).flat_map(|i| (0..16).map(move |k| (i, k)));
    let facets = facets.flat_map(|(i, k)| {
        let [a, b, c, d] = [(i, k), (i, k + 1), (i + 1, k + 1), (i + 1, k)];
        [[a, b, c], [a, c, d]]
    });
    let facets: Vec<[Vec3; 3]> = facets
        .map(|facet| facet.map(|(i, k)| point(i, k)))
        .filter(|[a, b, c]| (b - a).cross(c - a).length() > 1e-4)
        .collect();
    let normal = |corner: Vec3| {
        let around = facets.iter().filter(|facet| facet.contains(&corner));
        let sum: Vec3 = around.map(|[a, b, c]| (b - a).cross(c - a)).sum();
        sum.normalize()
    };
    let mut mesh = Mesh::default();
    for facet in &facets {
        let corners = facet.map(|corner| {
            let known = (0..mesh.vertices.len()).find(|&k| mesh.vertices.get(k) == corner);
            known.unwrap_or_else(|| {
                mesh.vertices.push(corner);
                mesh.vertex_normals.push(normal(corner));
                mesh.vertices.len() - 1
            }) as u32
        });
        mesh.corners.push(corners);
        mesh.normals.push(corners);
    }
    scene.append_mesh(mesh);
}

/// Facets that are lit because of their normals cast no shadow on the facets beside them. Such
/// shadows would be dark slits: pixels with lit ones within three pixels on both sides.
#[test]
fn lit_facets_in_creases_cast_no_slits() {
    let mut rng = Rng::new(5);
    let mut slits = [0, 0];
    for _ in 0..20 {
        let mut scene = seen_from(4.0, 2.2);
        scene.lights.add_directional(rng.direction(), Vec3::ONE);
        add_bumpy_globe(&mut scene, &mut rng);
        for (scene, slits) in [scene.clone(), faceted(&scene)].iter().zip(&mut slits) {
            let picture = picture(scene);
            let side = super::SIDE as usize;
            *slits += (3 * side..picture.len() - 3 * side)
                .filter(|&k| {
                    let lit = |k: usize| picture[k] > 0.0;
                    let between = |step: usize| {
                        (1..4).any(|n| lit(k - n * step)) && (1..4).any(|n| lit(k + n * step))
                    };
                    !lit(k) && (between(1) || between(side))
                })
                .count();
        }
    }
    assert!(5 * slits[0] < slits[1], "{slits:?}");
}
