//! Effects that are random and averaged over the samples of a pixel (Cook, Porter and Carpenter,
//! "Distributed Ray Tracing", 1984), in both engines and against closed forms.

mod gloss;
mod lens;
mod lights;
mod occlusion;

use phalanx::formats::read_test;
use phalanx::frame::{Accel, Control, Engine, Sampling, Settings, render};
use phalanx::scene::Scene;

/// A picture of one small pixel, with camera rays from `eye` to approximately `target` (both as in
/// a file), with up along y.
fn scene(eye: &str, target: &str, body: &str) -> Scene {
    let text = format!("size 1 1\ncamera {eye} {target} 0 1 0 0.001\n{body}");
    match read_test(&text) {
        Ok(loaded) => loaded.scene,
        Err(errors) => panic!("{text}\n{errors:#?}"),
    }
}

/// The settings of a scene with `spp` samples per pixel.
fn sampled(scene: &Scene, spp: u32) -> Settings {
    Settings {
        sampling: Sampling {
            spp,
            ..Sampling::CENTER
        },
        ..Settings::of(scene)
    }
}

/// The picture's planes, after asserting that both engines agree.
fn planes(scene: &Scene, settings: &Settings) -> [Vec<f32>; 3] {
    let [simd, scalar] = [Engine::Simd, Engine::Scalar].map(|engine| {
        let settings = Settings {
            engine,
            ..settings.clone()
        };
        let prepared = Accel::build(scene, engine);
        render(scene, &prepared, &settings, &Control::default()).expect("a frame")
    });
    assert_eq!(simd.film, scalar.film);
    assert_eq!(simd.stats.rays, scalar.stats.rays);
    simd.film.planes
}

/// The red of the first pixel.
fn red(scene: &Scene, spp: u32) -> f64 {
    f64::from(planes(scene, &sampled(scene, spp))[0][0])
}

/// Two triangles in the plane z = `height`, from `left` to far right, seen from both sides.
fn plate(first: usize, height: f64, left: f64) -> String {
    let [a, b, c, d] = std::array::from_fn(|k| first + k);
    format!(
        "vertex {left} -9e3 {height}\nvertex 9e3 -9e3 {height}\nvertex 9e3 9e3 {height}\nvertex {left} 9e3 {height}\n\
         tri {a} {b} {c}\ntri {a} {c} {d}\n"
    )
}
