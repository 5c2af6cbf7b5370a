//! Ambient occlusion.

use super::{planes, sampled, scene};
use crate::common::tolerances::SAMPLED_CAP;
use phalanx::frame::{Integrator, Settings};
use phalanx::scene::Scene;

/// Two triangles in the plane z = `height`, 200 wide: rays start off a surface by some millionths
/// of its size, which must be negligible compared with the objects on it.
fn floor(first: usize, height: f64) -> String {
    let [a, b, c, d] = std::array::from_fn(|k| first + k);
    let corners = [[-100, -100], [100, -100], [100, 100], [-100, 100]];
    let corners = corners.map(|[x, y]| format!("vertex {x} {y} {height}\n"));
    format!("{}tri {a} {b} {c}\ntri {a} {c} {d}\n", corners.concat())
}

/// Openness at the origin, on a floor with something around it.
fn openness(around: &str, distance: f32) -> f64 {
    let body = format!("{}{around}", floor(0, 0.0));
    let scene = scene("-0.3 0.1 0.5", "0 0 0", &body);
    f64::from(open(&scene, 4096, distance)[0][0])
}

fn open(scene: &Scene, spp: u32, distance: f32) -> [Vec<f32>; 3] {
    let settings = Settings {
        integrator: Integrator::Occlusion { distance },
        ..sampled(scene, spp)
    };
    planes(scene, &settings)
}

/// A wall of height h with its foot on a line at distance a, in a given direction, as long as the
/// floor.
fn wall(a: f64, h: f64, degrees: f64) -> String {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let corner = |along: f64, up: f64| {
        let (x, y) = (a * cos - along * sin, a * sin + along * cos);
        format!("vertex {x} {y} {up}\n")
    };
    let corners = [
        corner(-90.0, 0.0),
        corner(90.0, 0.0),
        corner(90.0, h),
        corner(-90.0, h),
    ];
    format!("{}tri 4 5 6\ntri 4 6 7\n", corners.concat())
}

fn assert_open(got: f64, want: f64, what: &str) {
    assert!(
        (got - want).abs() < SAMPLED_CAP,
        "{what}: {got}, not {want}"
    );
}

/// Seen from the floor, a wall of height h at distance a covers (1 - a/√(a² + h²))/2 of the
/// cosine-weighted sky: half, if it is infinite.
#[test]
fn a_wall_takes_up_to_half_of_the_sky() {
    for (a, h, degrees) in [
        (1.0, 90.0, 0.0),
        (1.0, 90.0, 37.0),
        (0.5, 0.5, 120.0),
        (2.0, 1.0, -80.0),
    ] {
        let got = openness(&wall(a, h, degrees), f32::INFINITY);
        let want = 1.0 - 0.5 * (1.0 - a / libm::sqrt(a * a + h * h));
        assert_open(got, want, &format!("a wall {h} high, {a} away"));
    }
}

/// A ball of radius r overhead at distance d covers r²/d² of it.
#[test]
fn a_ball_takes_the_square_of_its_sine() {
    for (d, r) in [(2.0f64, 1.0f64), (1.0, 0.3), (5.0, 4.4)] {
        let got = openness(&format!("sphere 0 0 {d} {r}\n"), f32::INFINITY);
        assert_open(
            got,
            1.0 - r * r / (d * d),
            &format!("a ball of {r}, {d} away"),
        );
    }
}

/// Ceiling at height h: the part farther away than D lies beyond the angle of cosine h/D, which
/// leaves h²/D² of the sky open.
#[test]
fn what_is_too_far_away_does_not_count() {
    let ceiling = floor(4, 0.75);
    for distance in [0.25f32, 0.7, 0.8, 1.5, 6.0] {
        let share = (0.75 / f64::from(distance)).min(1.0);
        let got = openness(&ceiling, distance);
        assert_open(got, share * share, &format!("within {distance}"));
    }
    // The ceiling ends 100 away, beyond which a ten-thousandth of the sky is.
    assert!(openness(&ceiling, f32::INFINITY) < 1e-3);
}

/// Tilted normals send no ray through the surface, whatever is below; the distance is in the file's
/// units.
#[test]
fn rays_stay_outside_and_units_are_the_files() {
    let leaning = "vertexnormal -90 -90 0 2 0 1\nvertexnormal 90 -90 0 2 0 1\nvertexnormal 0 90 0 2 0 1\ntrinormal 0 1 2\n";
    let body = format!("{leaning}{}", floor(0, -1.0));
    let scene = scene("-0.3 0.1 0.5", "0 0 0", &body);
    assert_eq!(open(&scene, 256, f32::INFINITY)[0], [1.0]);
    let picture = |unit: f32| {
        let text = format!(
            "size 24 16\ncamera 0 {} {} 0 0 0 0 0 1 40\nsphere 0 0 0 {unit}\nsphere {} 0 0 {unit}\n",
            -6.0 * unit,
            2.0 * unit,
            1.5 * unit
        );
        let scene = phalanx::formats::read_test(&text).expect("a scene").scene;
        (scene.scale, open(&scene, 4, 0.5 * unit))
    };
    let (same, scaled) = (picture(1.0), picture(1.099_511_6e12));
    assert!(same.0 == 1.0 && scaled.0 != 1.0);
    assert_eq!(same.1, scaled.1);
}

/// Colours and lights do not matter, and misses show the background.
#[test]
fn only_shapes_matter() {
    let body = "ambient .1 .2 .3\nspecular 1 1 1\npoint 0 0 9 1 1 1\nsphere 0 0 0 1\n";
    let mut scene = scene("0 0 5", "0 0 0", body);
    scene.view.fovy = 40.0;
    scene.background = glam::Vec3::new(0.25, 0.5, 0.125);
    (scene.width, scene.height) = (16, 16);
    let [red, green, blue] = open(&scene, 1, f32::INFINITY);
    for (k, ((r, g), b)) in red.iter().zip(&green).zip(&blue).enumerate() {
        let seen = [*r, *g, *b];
        assert!(
            seen == [1.0; 3] || seen == [0.25, 0.5, 0.125],
            "{k}: {seen:?}"
        );
    }
    assert_eq!((red[0], red[8 * 16 + 8]), (0.25, 1.0));
}
