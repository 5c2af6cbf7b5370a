//! Environments: their directions, and what sees them.

use crate::common::frames::{difference, frame_of};
use crate::common::rng::Rng;
use crate::common::tolerances::ENVIRONMENT_ANGLE;
use glam::{DQuat, DVec3, Vec3};
use phalanx::film::Aovs;
use phalanx::frame::{Accel, Aov, Engine, Integrator, Settings};
use phalanx::scene::{
    Environment, EnvironmentLight, EnvironmentMap, EnvironmentTexels, Material, Scene, UpAxis,
};
use std::sync::Arc;

/// An environment of any kind, placed anywhere.
pub fn random_environment(rng: &mut Rng) -> Environment {
    let light = if rng.once_in(4) {
        EnvironmentLight::Gradient {
            nadir: rng.color(),
            zenith: rng.color(),
        }
    } else {
        let (width, height) = (1 + rng.below(9) as u32, 1 + rng.below(6) as u32);
        let mut texels = match rng.below(3) {
            0 => EnvironmentTexels::Rgbe(Default::default()),
            1 => EnvironmentTexels::Half(Default::default()),
            _ => EnvironmentTexels::Float(Default::default()),
        };
        // Numbers that all three can tell.
        let mut number = || rng.below(128) as f32 / 32.0;
        let colors: Vec<[f32; 3]> = (0..width * height)
            .map(|_| [4.0, number(), number()])
            .collect();
        assert!(texels.extend(colors.into_iter()));
        EnvironmentLight::Map(Arc::new(EnvironmentMap {
            width,
            height,
            texels,
        }))
    };
    let up = UpAxis::ALL[rng.below(6)].1;
    let turn = f64::from(rng.range(-400.0, 400.0));
    let mut environment = Environment::new(light, up, turn);
    environment.scale = rng.magnitude(-2.0, 1.0);
    environment.is_background = !rng.once_in(3);
    environment
}

/// A map of this size in floats, of the radiance of each texel's direction in the frame of the y
/// axis.
fn map_of(width: u32, height: u32, radiance: impl Fn(DVec3) -> Vec3) -> EnvironmentLight {
    let mut texels = EnvironmentTexels::Float(Default::default());
    for row in 0..height {
        let polar = (f64::from(row) + 0.5) / f64::from(height) * std::f64::consts::PI;
        for column in 0..width {
            let turn = (f64::from(column) + 0.5) / f64::from(width) - 0.5;
            let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
            let dir = DVec3::new(polar.sin() * cos, polar.cos(), polar.sin() * sin);
            assert!(texels.extend([radiance(dir).to_array()].into_iter()));
        }
    }
    EnvironmentLight::Map(Arc::new(EnvironmentMap {
        width,
        height,
        texels,
    }))
}

/// A map of directions as colours.
fn map_of_directions(width: u32, height: u32) -> EnvironmentLight {
    map_of(width, height, |dir| (dir * 0.5 + 0.5).as_vec3())
}

/// Largest angle between a direction and the one that its colour tells, which is `frame` of it.
fn worst_angle(environment: &Environment, frame: impl Fn(DVec3) -> DVec3) -> f64 {
    let mut rng = Rng::new(3);
    let poles = [Vec3::Y, Vec3::NEG_Y, Vec3::NEG_X, Vec3::X, Vec3::Z];
    let mut near = Vec::new();
    for pole in poles {
        near.extend((0..2000).map(|k| {
            let away = rng.point(1.0) * if k % 2 == 0 { 0.02 } else { 2e-4 };
            (pole + away).normalize()
        }));
    }
    let mut rng = Rng::new(4);
    let all = (0..20_000).map(|_| rng.direction());
    let angle = |dir: Vec3| {
        let decoded = environment.radiance(dir).as_dvec3() * 2.0 - 1.0;
        frame(dir.as_dvec3()).angle_between(decoded)
    };
    near.into_iter()
        .chain(poles)
        .chain(all)
        .map(angle)
        .fold(0.0, f64::max)
}

/// Largest error of an angle by a map of this width.
fn most_angle(width: u32) -> f64 {
    let texel = std::f64::consts::TAU / f64::from(width);
    texel * texel + ENVIRONMENT_ANGLE
}

#[test]
fn a_map_of_directions_tells_every_direction() {
    for (width, height) in [(512, 256), (511, 255), (256, 256)] {
        let light = map_of_directions(width, height);
        let environment = Environment::new(light, UpAxis::Y, 0.0);
        let worst = worst_angle(&environment, |dir| dir);
        assert!(
            worst < most_angle(width.min(2 * height)),
            "{width}: {worst}"
        );
    }
}

#[test]
fn a_turned_map_is_the_scene_turned() {
    for turn in [90.0, 180.0, -90.0, 37.5, 765.0] {
        let environment = Environment::new(map_of_directions(512, 256), UpAxis::Y, turn);
        let back = DQuat::from_rotation_y(f64::to_radians(-turn));
        let worst = worst_angle(&environment, |dir| back * dir);
        assert!(worst < most_angle(512), "{turn}: {worst}");
    }
    for (name, up) in UpAxis::ALL {
        let environment = Environment::new(map_of_directions(512, 256), up, 0.0);
        let frame = up.frame();
        let worst = worst_angle(&environment, |dir| DVec3::from(frame.map(|a| a.dot(dir))));
        assert!(worst < most_angle(512), "{name}: {worst}");
    }
}

/// Quarters of a circle exchange axes and nothing else.
#[test]
fn a_quarter_turn_is_exact() {
    let sees = |turn, dir| {
        let light = map_of_directions(64, 32);
        Environment::new(light, UpAxis::Y, turn).radiance(dir)
    };
    let mut rng = Rng::new(5);
    for _ in 0..500 {
        let dir = rng.direction();
        let turned = Vec3::new(dir.z, dir.y, -dir.x);
        assert_eq!(sees(0.0, dir), sees(90.0, turned));
        assert_eq!(sees(360.0, dir), sees(0.0, dir));
    }
}

/// A mirror, a pane of glass and a matt ball before much background.
fn balls() -> Scene {
    let mut scene = Scene {
        width: 40,
        height: 30,
        background: Vec3::new(0.2, 0.5, 0.7),
        ..Scene::default()
    };
    scene.view.eye = Vec3::new(0.0, 0.5, 6.0);
    scene.lights.add_directional(Vec3::Y, Vec3::ONE);
    let materials = [
        (Vec3::splat(0.9), Vec3::ZERO),
        (Vec3::splat(0.1), Vec3::splat(0.8)),
        (Vec3::ZERO, Vec3::ZERO),
    ];
    for (k, (ks, kt)) in materials.into_iter().enumerate() {
        let row = scene.materials.push(&Material {
            kd: Vec3::splat(0.3),
            ks,
            kt,
            ior: 1.5,
            ..Material::DEFAULT
        });
        scene.add_sphere(Vec3::X * (k as f32 * 1.5 - 1.5), 0.7, row);
    }
    scene
}

fn frames(scene: &Scene, change: impl Fn(&mut Settings)) -> [phalanx::frame::Frame; 2] {
    [Engine::Scalar, Engine::Simd].map(|engine| {
        let mut settings = Settings {
            engine,
            record_hits: true,
            ..Settings::of(scene)
        };
        change(&mut settings);
        frame_of(scene, &Accel::build(scene, engine), settings)
    })
}

#[test]
fn a_constant_environment_is_the_background_of_its_color() {
    let mut scene = balls();
    let color = scene.background;
    let [want, packets] = frames(&scene, |_| {});
    assert_eq!(difference(&want, &packets), None);
    scene.background = Vec3::ZERO;
    let (nadir, zenith) = (color, color);
    for light in [
        EnvironmentLight::Gradient { nadir, zenith },
        map_of(16, 8, |_| color),
    ] {
        scene.environment = Some(Environment::new(light, UpAxis::Y, 33.0));
        for got in frames(&scene, |_| {}) {
            assert_eq!(difference(&want, &got), None);
        }
    }
}

#[test]
fn camera_rays_see_an_environment_that_is_the_background_and_nothing_else_changes() {
    let mut scene = balls();
    let [plain, _] = frames(&scene, |_| {});
    let with_alpha = |settings: &mut Settings| settings.aovs = Aovs::default().with(Aov::Alpha);
    let occlusion = |settings: &mut Settings| {
        settings.integrator = Integrator::Occlusion { distance: 2.0 };
    };
    let [dark, _] = frames(&scene, with_alpha);
    let [open, _] = frames(&scene, occlusion);
    let mut environment = Environment::new(map_of_directions(64, 32), UpAxis::Y, 0.0);
    let corner = |frame: &phalanx::frame::Frame| frame.film.planes[0][0];
    environment.is_background = false;
    scene.environment = Some(environment.clone());
    let [hidden, packets] = frames(&scene, |_| {});
    assert_eq!(difference(&hidden, &packets), None);
    assert_eq!(corner(&hidden), corner(&plain));
    assert!(difference(&hidden, &plain).is_some(), "mirrors see it");
    environment.is_background = true;
    scene.environment = Some(environment);
    let [seen, packets] = frames(&scene, |_| {});
    assert_eq!(difference(&seen, &packets), None);
    assert_ne!(corner(&seen), corner(&plain));
    // Matt surfaces are as before, and so is all of ambient occlusion.
    let matt = 2;
    let hits = seen.film.hits.as_ref().expect("recorded hits");
    let rows = (0..hits.prim_id.len()).filter(|&k| hits.prim_id[k] == matt);
    let rows: Vec<usize> = rows.collect();
    assert!(rows.len() > 20);
    assert!(
        rows.iter()
            .all(|&k| seen.film.planes[1][k] == plain.film.planes[1][k])
    );
    for got in frames(&scene, occlusion) {
        assert_eq!(difference(&open, &got), None);
    }
    // A picture with alpha is black where there is nothing.
    for got in frames(&scene, with_alpha) {
        assert_eq!(corner(&got), 0.0);
        assert_eq!(corner(&dark), 0.0);
    }
}
