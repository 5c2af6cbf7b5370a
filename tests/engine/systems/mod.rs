//! The systems of the design document, with a test named after each, in both engines and against
//! closed forms.

mod cones;
mod lighting;
mod primitives;
mod recursion;
mod view;

use glam::{DVec3, Vec3};
use phalanx::formats::read_test;
use phalanx::frame::{Accel, Control, Engine, Settings, render};
use phalanx::render::RayCounts;
use phalanx::scene::Scene;

/// A picture of one pixel, with a camera ray from `eye` to `target` (both as in a file), with up
/// along y.
fn scene(eye: &str, target: &str, body: &str) -> Scene {
    let text = format!("size 1 1\ncamera {eye} {target} 0 1 0 30\n{body}");
    match read_test(&text) {
        Ok(loaded) => loaded.scene,
        Err(errors) => panic!("{text}\n{errors:#?}"),
    }
}

/// The pixel's radiance and the number of rays, after asserting that both engines agree.
fn shot(scene: &Scene) -> (Vec3, RayCounts) {
    shot_of_weight(scene, 0.0)
}

/// The same, without rays below this weight.
fn shot_of_weight(scene: &Scene, min_weight: f32) -> (Vec3, RayCounts) {
    let rendered_by = |engine: Engine| {
        let settings = Settings {
            engine,
            min_weight: Some(min_weight),
            ..Settings::of(scene)
        };
        let prepared = Accel::build(scene, engine);
        let frame = render(scene, &prepared, &settings, &Control::default()).expect("a frame");
        (Vec3::from(frame.film.pixel(0, 0)), frame.stats.rays)
    };
    let (simd, scalar) = (rendered_by(Engine::Simd), rendered_by(Engine::Scalar));
    let bits = |(radiance, rays): (Vec3, RayCounts)| (radiance.to_array().map(f32::to_bits), rays);
    assert_eq!(bits(simd), bits(scalar), "simd {simd:?}, scalar {scalar:?}");
    simd
}

fn assert_near(got: Vec3, want: DVec3, relative: f64, what: &str) {
    let error = (got.as_dvec3() - want).abs();
    let allowed = want.abs() * relative;
    assert!(error.cmple(allowed).all(), "{what}: {got}, not {want}");
}

/// Two triangles in the plane z = `height`, 20 wide, counter-clockwise from above, or from below.
fn floor(height: f32, facing_up: bool) -> String {
    let corners = format!(
        "vertex -10 -10 {height}\nvertex 10 -10 {height}\nvertex 10 10 {height}\nvertex -10 10 {height}\n"
    );
    let faces = if facing_up { "tri 0 1 2\ntri 0 2 3\n" } else { "tri 4 6 5\ntri 4 7 6\n" };
    corners + faces
}
