//! The contract: the packet engine and the oracle make the same picture, bit for bit, however it is
//! divided.

use crate::common::frames::{difference, frame_of};
use crate::common::full_or;
use crate::common::rng::Rng;
use crate::common::scenes::{self, TestMaterial};
use glam::Vec3;
use phalanx::frame::{
    Accel, Adaptive, Aovs, Engine, Filter, Integrator, Kernel, Lens, Sampling, Settings,
};
use phalanx::render::RayCounts;
use phalanx::scene::{SHADOWLESS, Scene};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::cell::Cell;

/// Parameters of a random scene; everything else follows from the seed.
#[derive(Clone, Debug)]
struct Recipe {
    seed: u64,
    prims: usize,
    materials: usize,
    lights: usize,
    /// Scene size as a power of ten.
    magnitude: f32,
    eye: EyePlace,
    depth: u32,
    nested_glass: bool,
}

impl Recipe {
    fn scale(&self) -> f32 {
        10f32.powf(self.magnitude)
    }
}

#[derive(Clone, Copy, Debug)]
enum EyePlace {
    Outside,
    InsideASphere,
    OnASurface,
    Far,
}

fn recipes() -> impl Strategy<Value = Recipe> {
    let eye = prop_oneof![
        4 => Just(EyePlace::Outside),
        2 => Just(EyePlace::InsideASphere),
        1 => Just(EyePlace::OnASurface),
        1 => Just(EyePlace::Far),
    ];
    let magnitude =
        prop_oneof![3 => Just(0.0f32), 1 => -3.0f32..6.0, 1 => Just(-3.0f32), 1 => Just(6.0f32)];
    (
        any::<u64>(),
        0usize..120,
        1usize..12,
        0usize..5,
        magnitude,
        eye,
        0u32..7,
        any::<bool>(),
    )
        .prop_map(
            |(seed, prims, materials, lights, magnitude, eye, depth, nested_glass)| Recipe {
                seed,
                prims,
                materials,
                lights,
                magnitude,
                eye,
                depth,
                nested_glass,
            },
        )
}

fn random_paint(rng: &mut Rng) -> TestMaterial {
    TestMaterial {
        ka: rng.color(),
        ke: if rng.once_in(4) { rng.color() } else { Vec3::ZERO },
        kd: rng.color(),
        ks: if rng.once_in(2) { rng.color() } else { Vec3::ZERO },
        kt: if rng.once_in(3) { rng.color() } else { Vec3::ZERO },
        shininess: rng.pick(&[0.0, 1.0, 3.5, 20.0, 1000.0, 1e5]),
        ior: rng.pick(&[1.0, 1.5, 0.7, 2.4, 1.000_1]),
    }
}

fn glass() -> TestMaterial {
    TestMaterial {
        ka: Vec3::splat(0.01),
        kd: Vec3::ZERO,
        ks: Vec3::splat(0.2),
        kt: Vec3::new(0.9, 0.8, 0.7),
        ior: 1.5,
        ..scenes::GREY
    }
}

fn cook(recipe: &Recipe) -> Scene {
    let mut rng = Rng::new(recipe.seed);
    let scale = recipe.scale();
    let mut scene = Scene::default();
    let paints: Vec<u32> = (0..recipe.materials)
        .map(|_| scenes::add_paint(&mut scene, random_paint(&mut rng)))
        .collect();
    for _ in 0..recipe.prims {
        let paint = rng.pick(&paints);
        scenes::add_random(&mut scene, &mut rng, scale, paint);
    }
    if recipe.nested_glass {
        let glass = scenes::add_paint(&mut scene, glass());
        let center = rng.point(0.3 * scale);
        for radius in [0.5, 0.3, 0.1] {
            scene.add_sphere(center, radius * scale, glass);
        }
        let axes = Vec3::new(0.25, 0.2, 0.28) * scale;
        scenes::add_ellipsoid(&mut scene, center, axes, Vec3::ONE, glass);
    }
    if rng.once_in(3) {
        let paint = rng.pick(&paints);
        scenes::add_instances(&mut scene, &mut rng, scale, paint);
    }
    for _ in 0..recipe.lights {
        add_light(&mut scene, &mut rng, scale);
    }
    place_eye(&mut scene, recipe.eye, scale, &mut rng);
    scene.background = rng.color();
    scene.max_depth = recipe.depth;
    (scene.width, scene.height) = (64, 48);
    scene.validate().expect("a valid recipe");
    scene
}

fn add_light(scene: &mut Scene, rng: &mut Rng, scale: f32) {
    let brightness = if rng.once_in(10) { 1e30 } else { rng.magnitude(-1.0, 1.0) };
    let color = rng.color() * brightness;
    if rng.once_in(3) {
        let toward = if rng.once_in(3) {
            rng.pick(&[Vec3::X, -Vec3::Y, Vec3::Z])
        } else {
            rng.direction()
        };
        return if rng.once_in(2) {
            scene.lights.add_fill(toward, color)
        } else {
            scene.lights.add_directional(toward, color)
        };
    }
    let position = match rng.below(3) {
        // Exactly on a surface.
        0 => scenes::point_on(scene, rng),
        _ => rng.point(2.0 * scale),
    };
    let attenuation = rng.pick(&[
        Vec3::X,
        Vec3::new(1.0, 0.1 / scale, 0.0),
        Vec3::new(0.0, 0.0, 1.0 / (scale * scale)),
        Vec3::new(0.0, 1.0 / scale, 0.5 / (scale * scale)),
        Vec3::new(0.3, 0.2 / scale, 0.1 / (scale * scale)),
        Vec3::new(0.0, 0.0, 1e-30),
    ]);
    scene.lights.add_point(position, color, attenuation);
    if rng.once_in(4) {
        let last = scene.lights.len() - 1;
        scene.lights.flags[last] = SHADOWLESS;
    }
}

fn place_eye(scene: &mut Scene, place: EyePlace, scale: f32, rng: &mut Rng) {
    let spheres = scene.spheres.len();
    let eye = match place {
        EyePlace::InsideASphere if spheres > 0 => {
            let i = rng.below(spheres);
            scene.spheres.center.get(i) + rng.direction() * 0.5 * scene.spheres.radius[i]
        }
        EyePlace::OnASurface => scenes::point_on(scene, rng),
        EyePlace::Far => rng.direction() * 100.0 * scale,
        _ => rng.direction() * 2.5 * scale,
    };
    let view = &mut scene.view;
    view.eye = eye;
    view.center = eye + (rng.point(0.3 * scale) - eye) + rng.direction() * 0.1 * scale;
    view.up = rng.direction();
    view.fovy = if matches!(place, EyePlace::Far) { 2.0 } else { rng.range(20.0, 110.0) };
}

/// Numbers of threads and tile sizes for rendering a picture.
const CUTS: [(usize, u32); 12] = [
    (1, 8),
    (2, 17),
    (3, 32),
    (1, 64),
    (2, 8),
    (3, 17),
    (1, 32),
    (2, 64),
    (3, 8),
    (1, 17),
    (2, 32),
    (3, 64),
];
const SIZES: [(u32, u32); 4] = [(1, 1), (7, 3), (33, 65), (64, 48)];

fn compare(scene: &Scene, cuts: &[(usize, u32)], sizes: &[(u32, u32)]) -> Result<(), String> {
    compare_as(scene, cuts, sizes, &Settings::of(scene))
}

/// Settings with the size, tiles and engine from `wanted_settings`.
fn compare_as(
    scene: &Scene,
    cuts: &[(usize, u32)],
    sizes: &[(u32, u32)],
    wanted_settings: &Settings,
) -> Result<(), String> {
    let packets = Accel::build(scene, Engine::Simd);
    let oracle = Accel::build(scene, Engine::Scalar);
    for &(width, height) in sizes {
        let settings = Settings {
            width,
            height,
            record_hits: true,
            ..wanted_settings.clone()
        };
        let scalar = Settings {
            engine: Engine::Scalar,
            ..settings.clone()
        };
        let want = frame_of(scene, &oracle, scalar);
        for &(threads, tile) in cuts {
            for kernel in Kernel::ALL.map(|(_, kernel)| kernel) {
                let cut = Settings {
                    threads,
                    tile,
                    kernel,
                    ..settings.clone()
                };
                let got = frame_of(scene, &packets, cut);
                if let Some(what) = difference(&want, &got) {
                    return Err(format!(
                        "{width}x{height}, {threads} threads, tiles of {tile}, {kernel:?}, scalar then simd: {what}"
                    ));
                }
            }
        }
    }
    Ok(())
}

/// The same recipes in every run.
fn runner(cases: u32, seed: u8) -> TestRunner {
    let config = Config {
        cases,
        failure_persistence: None,
        ..Config::default()
    };
    TestRunner::new_with_rng(
        config,
        TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]),
    )
}

#[test]
fn random_scenes() {
    let turn = Cell::new(0);
    let outcome = runner(240, 1).run(&recipes(), |recipe| {
        let scene = cook(&recipe);
        let k = turn.replace(turn.get() + 1);
        let cuts = [CUTS[k % 12], CUTS[(k + 5) % 12]];
        compare(&scene, &cuts, &[(64, 48)]).map_err(TestCaseError::fail)
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}

#[test]
fn several_samples() {
    let turn = Cell::new(0);
    let outcome = runner(24, 4).run(&recipes(), |recipe| {
        let k = turn.replace(turn.get() + 1);
        let scene = cook(&recipe);
        let cuts = [CUTS[k % 12], CUTS[(k + 5) % 12]];
        compare_as(&scene, &cuts, &[(33, 25)], &sampled(&scene, k)).map_err(TestCaseError::fail)
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}

/// Rays of little or no weight: both engines skip the same ones.
#[test]
fn least_weights() {
    let turn = Cell::new(0);
    let (all, fewer) = (Cell::new(0), Cell::new(0));
    let outcome = runner(48, 17).run(&recipes(), |recipe| {
        let k = turn.replace(turn.get() + 1);
        let mut scene = cook(&recipe);
        scene.max_depth = [3, 8, 15, 60][k % 4];
        let min_weight = [0.3, 1e-3, 0.05, 0.01, 0.6][k % 5];
        let settings = match k % 3 {
            0 => Settings::of(&scene),
            _ => sampled(&scene, k),
        };
        let settings = Settings {
            min_weight: Some(min_weight),
            ..settings
        };
        let cuts = [CUTS[k % 12], CUTS[(k + 5) % 12]];
        compare_as(&scene, &cuts, &[(33, 25)], &settings).map_err(TestCaseError::fail)?;
        if scene.max_depth == 8 {
            let prepared = Accel::build(&scene, Engine::Simd);
            let rays = |min_weight| {
                let settings = Settings {
                    min_weight: Some(min_weight),
                    ..Settings::of(&scene)
                };
                let rays = frame_of(&scene, &prepared, settings).stats.rays;
                rays.reflection + rays.refraction
            };
            all.set(all.get() + rays(0.0));
            fewer.set(fewer.get() + rays(min_weight));
        }
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
    let (all, fewer) = (all.get(), fewer.get());
    assert!(fewer > 0 && fewer < all / 2, "{fewer} bounces of {all}");
}

/// Depths at which waves of bounces are smaller than those of camera rays, in tiles of any size.
#[test]
fn split_waves() {
    let mut rng = Rng::new(5);
    let mut scene = Scene::default();
    let paint = |ks: Vec3, kt: Vec3| TestMaterial {
        ks,
        kt,
        ior: 1.5,
        ..scenes::GREY
    };
    let mirror = scenes::add_paint(&mut scene, paint(Vec3::ONE, Vec3::ZERO));
    let tinted = scenes::add_paint(&mut scene, paint(Vec3::new(1.0, 0.9, 0.5), Vec3::ZERO));
    let clear = scenes::add_paint(&mut scene, paint(Vec3::splat(0.1), Vec3::splat(0.9)));
    scene.add_sphere(Vec3::ZERO, 9.0, mirror);
    for k in 0..12 {
        let paint = [mirror, tinted, clear][k % 3];
        scene.add_sphere(rng.point(4.0), 0.7, paint);
    }
    scene
        .lights
        .add_point(Vec3::new(0.0, 5.0, 0.0), Vec3::ONE, Vec3::X);
    scene.view.eye = Vec3::new(0.0, 0.0, 6.0);
    let large = full_or((150, 140), (75, 70));
    for (max_depth, size) in [(300, (24, 16)), (1000, (9, 5)), (8, large)] {
        let settings = Settings {
            max_depth,
            min_weight: Some(0.02),
            aovs: Aovs::all(),
            ..Settings::of(&scene)
        };
        scene.validate().expect("a valid scene");
        let cuts = [(1, 1024), (2, 32), (1, 8), (3, 128)];
        for cuts in cuts[..full_or(4, 2)].chunks(2) {
            if let Err(what) = compare_as(&scene, cuts, &[size], &settings) {
                panic!("depth {max_depth}: {what}");
            }
        }
    }
}

/// Adaptive samples that halve cells and reuse each other's light visibility: many of them, some in
/// tiles whose blocks do not fit in memory at once.
#[test]
fn halved_cells() {
    let turn = Cell::new(0);
    let size = full_or((33, 25), (17, 13));
    let outcome = runner(full_or(16, 8), 11).run(&recipes(), |recipe| {
        let k = turn.replace(turn.get() + 1);
        let scene = cook(&recipe);
        let sampling = Sampling {
            spp: [64, 9, 1024, 256][k % 4],
            filter: Filter::ALL[k % 3].1,
            adaptive: Some(Adaptive {
                threshold: [0.003, 1e-4, 0.02, 0.01][k % 4],
            }),
        };
        let settings = Settings {
            sampling,
            ..Settings::of(&scene)
        };
        let cuts = [CUTS[k % 12], CUTS[(k + 7) % 12]];
        compare_as(&scene, &cuts, &[size], &settings).map_err(TestCaseError::fail)
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}

/// The k-th way to take several samples.
fn sampled(scene: &Scene, k: usize) -> Settings {
    let adaptive = Adaptive {
        threshold: [0.02, 0.002][k / 2 % 2],
    };
    let sampling = Sampling {
        spp: [2, 3, 4, 7, 20][k % 5],
        filter: Filter::ALL[k % 3].1,
        adaptive: (k % 2 == 1).then_some(adaptive),
    };
    Settings {
        sampling,
        ..Settings::of(scene)
    }
}

/// Compares both engines with random effects: `with` changes scene and settings, given the
/// iteration. One in five takes one sample per pixel, whose decisions are random, too.
fn by_chance(seed: u8, with: impl Fn(&Recipe, usize, &mut Scene, &mut Settings)) {
    let turn = Cell::new(0);
    let outcome = runner(24, seed).run(&recipes(), |recipe| {
        let k = turn.replace(turn.get() + 1);
        let mut scene = cook(&recipe);
        let mut settings = match k % 5 {
            0 => Settings::of(&scene),
            more => sampled(&scene, more),
        };
        with(&recipe, k, &mut scene, &mut settings);
        scene.validate().expect("a valid recipe");
        let cuts = [CUTS[k % 12], CUTS[(k + 5) % 12], (2, 16)];
        compare_as(&scene, &cuts, &[(33, 25)], &settings).map_err(TestCaseError::fail)
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}

#[test]
fn area_lights() {
    by_chance(5, |recipe, _, scene, _| add_area_lights(recipe, scene));
}

#[test]
fn gloss() {
    by_chance(6, |recipe, _, scene, _| add_gloss(recipe, scene));
}

#[test]
fn lenses() {
    by_chance(7, |recipe, k, _, settings| {
        settings.lens = Some(lens(recipe, k))
    });
}

#[test]
fn ambient_occlusion() {
    by_chance(8, |recipe, k, _, settings| {
        let distance = [f32::INFINITY, 0.01, 0.3, 2.0][k % 4] * recipe.scale();
        settings.integrator = Integrator::Occlusion { distance };
        settings.lens = (k % 3 == 0).then(|| lens(recipe, k));
    });
}

#[test]
fn everything_by_chance() {
    by_chance(9, |recipe, k, scene, settings| {
        add_area_lights(recipe, scene);
        add_gloss(recipe, scene);
        settings.lens = Some(lens(recipe, k));
    });
}

/// Lenses from none, and one whose rays all start at the eye, to one as large as the scene.
fn lens(recipe: &Recipe, k: usize) -> Lens {
    Lens {
        aperture: [0.0, 1e-30, 1e-3, 0.3, 3.0][k % 5] * recipe.scale(),
        focus: [0.5, 2.0, 100.0][k % 3] * recipe.scale(),
    }
}

fn add_gloss(recipe: &Recipe, scene: &mut Scene) {
    let mut rng = Rng::new(recipe.seed);
    for gloss in scene.materials.gloss.iter_mut() {
        *gloss = rng.pick(&[0.0, 0.0, 0.3, 1.0, 20.0, 1e4, 1e30]);
    }
}

fn add_area_lights(recipe: &Recipe, scene: &mut Scene) {
    let mut rng = Rng::new(recipe.seed);
    for _ in 0..3 {
        add_area_light(scene, &mut rng, recipe.scale());
    }
}

/// Lights from almost a point, which shadow rays reach as a beam, to larger than the scene.
fn add_area_light(scene: &mut Scene, rng: &mut Rng, scale: f32) {
    let position = rng.point(2.0 * scale);
    let color = rng.color() * rng.magnitude(-1.0, 1.0);
    let size = scale * rng.pick(&[1e-30, 1e-5, 0.01, 0.3, 4.0]);
    let attenuation = rng.pick(&[Vec3::X, Vec3::new(0.0, 0.0, 1.0 / (scale * scale))]);
    if rng.once_in(2) {
        scene.lights.add_sphere(position, size, color, attenuation);
    } else {
        let edges = [rng.direction() * size, rng.direction() * size];
        let lights = &mut scene.lights;
        lights.add_rectangle(position, edges, color, attenuation);
    }
}

#[test]
fn every_cut_and_size() {
    let outcome = runner(6, 2).run(&recipes(), |recipe| {
        compare(&cook(&recipe), &CUTS, &SIZES).map_err(TestCaseError::fail)
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}

/// The recipes exercise what they are meant to: without bounces or shadows, equal pictures would
/// prove little.
#[test]
fn the_recipes_have_everything_in_them() {
    let (rays, kinds) = (Cell::new(RayCounts::default()), Cell::new([0; 4]));
    let outcome = runner(60, 1).run(&recipes(), |recipe| {
        let scene = cook(&recipe);
        let prepared = Accel::build(&scene, Engine::Simd);
        let frame = frame_of(&scene, &prepared, Settings::of(&scene));
        let mut sum = rays.get();
        sum.add(&frame.stats.rays);
        rays.set(sum);
        let [spheres, ellipsoids, cones, normals] = kinds.get();
        kinds.set([
            spheres + scene.spheres.len(),
            ellipsoids + scene.ellipsoids.len(),
            cones + scene.cones.len(),
            normals + scene.triangles.vertex_normals.len(),
        ]);
        Ok(())
    });
    assert!(outcome.is_ok(), "{outcome:?}");
    let (sum, kinds) = (rays.get(), kinds.get());
    println!("{sum:?}, spheres, ellipsoids, cones and vertex normals {kinds:?}");
    let least = [sum.shadow, sum.reflection, sum.refraction]
        .into_iter()
        .min();
    assert!(least > Some(20_000), "{sum:?}");
    assert!(kinds.iter().all(|&k| k > 50), "{kinds:?}");
}
