//! A frame of a scene built in code, as a PNG file:
//! `cargo run --release --example render_png -- picture.png`.

use phalanx::frame::{Accel, Control, Engine, Settings, render};
use phalanx::glam::Vec3;
use phalanx::image::{encode, save_png};
use phalanx::scene::{Material, OutputEncoding, Scene, View};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene();
    scene.validate()?;
    let settings = Settings {
        threads: std::thread::available_parallelism()?.get(),
        ..Settings::of(&scene)
    };
    let accel = Accel::build(&scene, Engine::Simd);
    let frame = render(&scene, &accel, &settings, &Control::default())?;

    let path = PathBuf::from(std::env::args().nth(1).unwrap_or("picture.png".into()));
    save_png(&path, &encode(&frame.film, scene.encoding))?;
    let rays = frame.stats.rays;
    println!(
        "{}: {} camera and {} shadow rays",
        path.display(),
        rays.primary,
        rays.shadow
    );
    Ok(())
}

/// A mirror and seven coloured balls on a floor, one light.
fn scene() -> Scene {
    let mut scene = Scene::new();
    (scene.width, scene.height, scene.max_depth) = (640, 400, 4);
    scene.encoding = OutputEncoding::SRGB;
    scene.background = Vec3::new(0.3, 0.4, 0.6);
    scene.view = View {
        eye: Vec3::new(0.0, 3.0, 8.0),
        center: Vec3::new(0.0, 0.8, 0.0),
        up: Vec3::Y,
        fovy: 35.0,
        ortho: None,
    };
    let matte = |color: Vec3| Material {
        ka: color * 0.1,
        kd: color,
        ..Material::default()
    };
    let floor = scene.materials.push(&matte(Vec3::splat(0.7)));
    let mirror = scene.materials.push(&Material {
        ka: Vec3::ZERO,
        ks: Vec3::splat(0.9),
        shininess: 200.0,
        ..Material::default()
    });
    let [a, b, c, d] = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]]
        .map(|[x, z]: [f32; 2]| Vec3::new(x, 0.0, z));
    scene.add_triangle([a, c, b], None, floor);
    scene.add_triangle([a, d, c], None, floor);
    scene.add_sphere(Vec3::new(0.0, 1.2, 0.0), 1.2, mirror);
    for k in 0..7 {
        let (sin, cos) = (k as f32 / 7.0 * std::f32::consts::TAU).sin_cos();
        let color = Vec3::new(0.5 + 0.4 * cos, 0.5 + 0.4 * sin, 0.5 - 0.4 * cos);
        let material = scene.materials.push(&matte(color));
        scene.add_sphere(Vec3::new(2.2 * sin, 0.4, 2.2 * cos), 0.4, material);
    }
    let white = Vec3::splat(1.0);
    scene
        .lights
        .add_point(Vec3::new(-4.0, 7.0, 5.0), white, Vec3::X);
    scene
}
