//! Soft shadows.

use super::{planes, plate, red, sampled, scene};
use crate::common::tolerances::{HIDDEN_SHARE, SAMPLED_EDGE, SMOOTH_MEAN};

const WHITE: &str = "ambient 0 0 0\ndiffuse 1 1 1\n";

/// A light at height 1,000, 20 wide, centred above x = 0; a plate half way up hides everything to
/// its right. From x on the floor, the plate's edge is seen at -x on the light.
fn half_hidden(light: &str, x: f64) -> f64 {
    let body = format!(
        "{light}\n{WHITE}{}{}",
        plate(0, 0.0, -9e3),
        plate(4, 500.0, 0.0)
    );
    let place = format!("{x} 0");
    red(
        &scene(&format!("{place} 2"), &format!("{place} 0"), &body),
        1024,
    )
}

/// Light from such a height comes straight down: the cosine is 1 to within 1e-4.
#[test]
fn the_penumbra_of_a_rectangle_is_linear() {
    for light in [
        "rectlight -10 -10 1000 20 0 0 0 20 0 1 1 1",
        "rectlight 10 10 1000 0 -20 0 -20 0 0 1 1 1",
        // Slanted along the edge: any parallelogram will do.
        "rectlight -10 -10 1000 20 0 0 0 20 3 1 1 1",
        "translate 0 0 900\nscale 10 5 100\nrectlight -1 -2 1 2 0 0 0 4 0 1 1 1\nscale .1 .2 .01\ntranslate 0 0 -900",
    ] {
        for x in [-30.0, -10.5, -7.0, -1.25, 0.0, 4.0, 9.0, 10.5, 25.0] {
            let want = ((10.0 - x) / 20.0f64).clamp(0.0, 1.0);
            let got = half_hidden(light, x);
            let most = SAMPLED_EDGE + 1e-4;
            assert!(
                (got - want).abs() < most,
                "{light} at {x}: {got}, not {want}"
            );
        }
    }
}

/// The same for a sphere: its area between two parallel planes depends only on their distance
/// (Archimedes).
#[test]
fn the_penumbra_of_a_sphere_is_linear() {
    for light in [
        "spherelight 0 0 1000 10 1 1 1",
        "rotate 1 2 3 40\nscale 2 2 2\nspherelight 0 0 0 5 1 1 1",
    ] {
        // The second is rotated about the origin, so the translation comes first.
        let light = if light.starts_with("rotate") {
            format!("pushTransform\ntranslate 0 0 1000\n{light}\npopTransform")
        } else {
            light.to_owned()
        };
        for x in [-30.0, -10.5, -7.0, -1.25, 0.0, 4.0, 9.0, 10.5, 25.0] {
            let want = ((10.0 - x) / 20.0f64).clamp(0.0, 1.0);
            let got = half_hidden(&light, x);
            let most = HIDDEN_SHARE + 1e-4;
            assert!(
                (got - want).abs() < most,
                "{light} at {x}: {got}, not {want}"
            );
        }
    }
}

/// Light from a sphere's surface that falls with the square of the distance behaves like gravity:
/// as if all of it came from the centre (Newton's shell theorem).
#[test]
fn a_sphere_shines_as_its_middle() {
    for (x, y, z, radius) in [
        (0.0, 0.0, 2.0, 1.0f64),
        (3.0, -1.0, 1.0, 0.9),
        (1.0, 1.0, 1.0, 1e-6),
    ] {
        let body = format!(
            "attenuation 0 0 1\nspherelight {x} {y} {z} {radius} 1 2 4\n{WHITE}{}",
            plate(0, 0.0, -9e3)
        );
        let got = red(&scene("0 0 50", "0 0 0", &body), 4096);
        let distance: f64 = libm::sqrt(x * x + y * y + z * z);
        let want = z / (distance * distance * distance);
        assert!(
            (got - want).abs() < SMOOTH_MEAN * want,
            "{x} {y} {z} {radius}: {got}, not {want}"
        );
    }
}

/// With it, a rectangle's light on a parallel plane is the solid angle that it covers, divided by
/// its area: from below a corner, atan(a b / (h √(a² + b² + h²))).
#[test]
fn a_rectangle_shines_as_its_solid_angle() {
    for (a, b, h) in [(1.0f64, 1.0f64, 1.0f64), (3.0, 0.5, 2.0), (0.1, 4.0, 4.0)] {
        let body = format!(
            "attenuation 0 0 1\nrectlight 0 0 {h} {a} 0 0 0 {b} 0 1 2 4\n{WHITE}{}",
            plate(0, 0.0, -9e3)
        );
        let got = red(&scene("0 0 50", "0 0 0", &body), 4096);
        let want = libm::atan(a * b / (h * libm::sqrt(a * a + b * b + h * h))) / (a * b);
        assert!(
            (got - want).abs() < SMOOTH_MEAN * want,
            "{a} {b} {h}: {got}, not {want}"
        );
    }
}

/// One shadow ray per light and sample, to the same point of the light in every sample only for a
/// point light; the two lights' points are independent.
#[test]
fn pixels_lights_and_samples_choose_for_themselves() {
    let lights =
        "rectlight -10 -10 1000 20 0 0 0 20 0 1 0 0\nrectlight -10 -10 1000 20 0 0 0 20 0 0 1 0\n";
    let body = format!(
        "{lights}{WHITE}{}{}",
        plate(0, 0.0, -9e3),
        plate(4, 500.0, 0.0)
    );
    let mut scene = scene("0 0 2", "0 0 0", &body);
    (scene.width, scene.height) = (64, 64);
    let [red, green, _] = planes(&scene, &sampled(&scene, 1));
    let seen = |one: bool, other: bool| {
        let both = red.iter().zip(&green);
        both.filter(|&(&r, &g)| (r > 0.5, g > 0.5) == (one, other))
            .count()
    };
    // A quarter of 4,096 each; the deviation is 28, and five of them are one in a million.
    for (one, other) in [(true, true), (true, false), (false, true), (false, false)] {
        let count = seen(one, other);
        assert!(count.abs_diff(1024) < 140, "{one} {other}: {count}");
    }
}
