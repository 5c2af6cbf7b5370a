//! A warmed-up painter paints without allocating memory, and its memory does not grow with the
//! depth.

use crate::allocator::{allocations, alone, peak_of};
use crate::common::rng::Rng;
use crate::common::scenes::{self, TestMaterial};
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::camera::Camera;
use phalanx::frame::Settings;
use phalanx::render::{Tile, TileBuffer, TileRenderer, WaveSizes, WavefrontRenderer, tiles};
use phalanx::scene::Scene;
use phalanx::trace::Kernel;
use phalanx::{HitBuffer, Ray, RayBuffer, RayFilter};

/// Mirrors, glass, matte objects and lights of both kinds.
fn busy_scene() -> Scene {
    let mut rng = Rng::new(71);
    let mut scene = Scene::default();
    let dull = scenes::add_paint(&mut scene, scenes::GREY);
    let mirror = scenes::add_paint(
        &mut scene,
        TestMaterial {
            ks: Vec3::splat(0.7),
            shininess: 40.0,
            ..scenes::GREY
        },
    );
    let glass = scenes::add_paint(
        &mut scene,
        TestMaterial {
            ks: Vec3::splat(0.3),
            kt: Vec3::splat(0.8),
            ior: 1.5,
            ..scenes::GREY
        },
    );
    for k in 0..200 {
        let paint = [dull, mirror, glass][k % 3];
        scenes::add_random(&mut scene, &mut rng, 1.0, paint);
    }
    scenes::add_instances(&mut scene, &mut rng, 1.0, glass);
    let lights = &mut scene.lights;
    lights.add_point(Vec3::new(3.0, 4.0, 5.0), Vec3::ONE, Vec3::X);
    lights.add_point(Vec3::ZERO, Vec3::splat(0.5), Vec3::new(1.0, 0.1, 0.2));
    lights.add_directional(Vec3::Y, Vec3::splat(0.4));
    scene.background = Vec3::splat(0.1);
    scene.view.eye = Vec3::new(0.0, 0.5, 3.0);
    (scene.width, scene.height, scene.max_depth) = (320, 256, 6);
    scene.validate().expect("a valid scene");
    scene
}

#[test]
fn painting_allocates_nothing_once_warm() {
    let _alone = alone();
    let scene = busy_scene();
    let bvh = Bvh::build(&scene);
    let camera = Camera::new(&scene.view, scene.width, scene.height).expect("a camera");
    for (side, record_hits, kernel) in [
        (32, false, Kernel::Packet8),
        (32, true, Kernel::Packet16),
        (8, false, Kernel::Packet16),
        (64, true, Kernel::Packet8),
        (32, true, Kernel::Auto),
        (32, false, Kernel::Beam8),
        (32, false, Kernel::Beam16),
        (32, false, Kernel::Single),
    ] {
        let mut pixels = TileBuffer::new(record_hits);
        let all = tiles(Tile::whole(scene.width, scene.height), side);
        // From all over the picture.
        let step = all.len().div_ceil(50);
        let some: Vec<Tile> = all.into_iter().step_by(step).collect();
        let settings = Settings {
            kernel,
            ..Settings::of(&scene)
        };
        let mut painter = WavefrontRenderer::new(&scene, &bvh, &camera, &settings);
        let mut paint_all = |painter: &mut WavefrontRenderer| {
            for &tile in &some {
                pixels.fit(tile);
                painter.render_tile(tile, &mut pixels);
            }
        };
        let before = allocations();
        paint_all(&mut painter);
        let warming = allocations() - before;
        let rays = painter.stats().rays;
        assert!(warming > 0, "the counter counts nothing");
        assert!(rays.reflection > 1000 && rays.refraction > 1000, "{rays:?}");
        let before = allocations();
        paint_all(&mut painter);
        let again = allocations() - before;
        println!("tiles of {side}: {warming} allocations while warming up, {again} after");
        assert_eq!(again, 0, "tiles of {side}, hits kept: {record_hits}");
    }
}

/// Checks that calls for one ray, and for a few, ask for no memory, within instances, too.
#[test]
fn single_rays_allocate_nothing_once_warm() {
    let _alone = alone();
    let mut rng = Rng::new(72);
    let mut plain = Scene::default();
    let paint = scenes::add_paint(&mut plain, scenes::GREY);
    (0..300).for_each(|_| scenes::add_random(&mut plain, &mut rng, 1.0, paint));
    for scene in [plain, busy_scene()] {
        let bvh = Bvh::build(&scene);
        let rays = [(); 16].map(|()| Ray::new(rng.point(2.0), rng.point(1.0)));
        let buffer: RayBuffer = rays.into_iter().collect();
        let (mut hits, mut blocked) = (HitBuffer::new(16), [false; 16]);
        let mut cast = || {
            let filter = RayFilter {
                mask: 1,
                ..RayFilter::default()
            };
            for ray in &rays {
                bvh.intersect(ray);
                bvh.occluded(ray);
                bvh.intersect_filtered(ray, &filter);
            }
            let columns = buffer.columns();
            bvh.intersect_batch(&columns, &mut hits.columns(), 0)
                .is_ok()
                && bvh.occluded_batch(&columns, &mut blocked, 0).is_ok()
        };
        assert!(cast());
        let before = allocations();
        assert!(cast());
        assert_eq!(allocations() - before, 0, "allocations");
    }
}

/// A room with walls and a ball that are perfect mirrors; the walls of the other room send two rays
/// for each.
fn mirror_rooms() -> [Scene; 2] {
    [
        (Vec3::ONE, Vec3::ZERO),
        (Vec3::splat(0.9), Vec3::splat(0.02)),
    ]
    .map(|(ks, kt)| {
        let mut scene = Scene::default();
        let paint = TestMaterial {
            ks,
            kt,
            ior: 1.0,
            ..scenes::GREY
        };
        let walls = scenes::add_paint(&mut scene, paint);
        scene.add_sphere(Vec3::ZERO, 10.0, walls);
        scene.add_sphere(Vec3::X, 1.0, walls);
        scene
            .lights
            .add_point(Vec3::new(0.0, 0.0, 4.0), Vec3::ONE, Vec3::X);
        scene.view.eye = Vec3::new(0.0, 0.0, 5.0);
        (scene.width, scene.height) = (128, 128);
        scene.validate().expect("a valid scene");
        scene
    })
}

#[test]
fn memory_does_not_grow_with_the_depth() {
    let _alone = alone();
    for scene in mirror_rooms() {
        let bvh = Bvh::build(&scene);
        let camera = Camera::new(&scene.view, scene.width, scene.height).expect("a camera");
        for (side, depth, min_weight) in [
            (32, 30, 0.0),
            (32, 1000, 0.01),
            (128, 1000, 0.01),
            (128, 60, 0.01),
        ] {
            if depth == 30 && scene.materials.kt.get(0) != Vec3::ZERO {
                continue;
            }
            let tile = tiles(Tile::whole(scene.width, scene.height), side)[0];
            let mut pixels = TileBuffer::new(false);
            pixels.fit(tile);
            let mut reflected = 0;
            let peak = peak_of(|| {
                let settings = Settings {
                    kernel: Kernel::Packet8,
                    max_depth: depth,
                    min_weight: Some(min_weight),
                    ..Settings::of(&scene)
                };
                let mut painter = WavefrontRenderer::new(&scene, &bvh, &camera, &settings);
                painter.render_tile(tile, &mut pixels);
                reflected = painter.stats().rays.reflection;
            });
            let sizes = WaveSizes::of(&scene, depth, min_weight);
            let bounces = sizes.bounce_bytes(tile.pixels() as usize) as i64;
            println!("tile {side}, depth {depth}: {peak} bytes, bounces {bounces}");
            assert!(bounces < 8 << 20, "{bounces}");
            let shading = 800 * (tile.pixels() as usize).min(sizes.rays()) as i64;
            let allowed = bounces + shading + 400 * tile.pixels() as i64;
            assert!(peak < allowed, "{peak} of {allowed}");
            assert!(reflected > 10_000, "{reflected}");
        }
    }
}
