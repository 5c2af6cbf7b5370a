//! Glossy reflection.

use super::{planes, plate, red, sampled, scene};
use crate::common::tolerances::SAMPLED_CAP;
use phalanx::frame::Settings;

const MIRROR: &str = "ambient 0 0 0\nspecular .5 .5 .5\n";

/// An emissive ball with its centre `distance` away along (x, y, z), seen in a mirror of this
/// gloss.
fn of_a_ball(gloss: &str, [x, y, z]: [f64; 3], distance: f64, radius: f64) -> f64 {
    let [bx, scaled, bz] = [x, y, z].map(|c| c * distance);
    // The eye is nearer than the ball.
    let [ex, ey, ez] = [-x, y, z].map(|c| c * 0.5);
    let ball = format!(
        "ambient 0 0 0\nspecular 0 0 0\nemission 1 1 1\nsphere {bx} {scaled} {bz} {radius}\n"
    );
    let body = format!("maxdepth 1\n{MIRROR}{gloss}\n{}{ball}", plate(0, 0.0, -9e3));
    red(&scene(&format!("{ex} {ey} {ez}"), "0 0 0", &body), 4096)
}

/// Within the angle a of the mirror direction lies 1 - cosⁿ⁺¹ a of the lobe, and a ball of radius r
/// seen from d covers sin a = r/d.
#[test]
fn a_ball_in_the_mirror_direction_has_its_share_of_the_lobe() {
    for direction in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [-0.28, 0.0, 0.96]] {
        for gloss in [1.0f64, 8.0, 60.0, 2000.0] {
            for radius in [0.3, 1.0, 2.5] {
                let (distance, n) = (10.0f64, gloss);
                let sin = radius / distance;
                let cos = libm::sqrt(1.0 - sin * sin);
                let want = 0.5 * (1.0 - libm::pow(cos, n + 1.0));
                let got = of_a_ball(&format!("gloss {gloss}"), direction, distance, radius);
                assert!(
                    (got - want).abs() < 0.5 * SAMPLED_CAP,
                    "{direction:?}, gloss {gloss}, radius {radius}: {got}, not {want}"
                );
            }
        }
    }
}

/// Rays of the lobe that would go through the surface are reflected back. At grazing angles all
/// rays still reach the sky above, and none the dark below.
#[test]
fn nothing_goes_through_the_surface() {
    let cellar = format!("specular 0 0 0\n{}", plate(4, -1.0, -9e3));
    let sky = format!("{cellar}emission 1 1 1\nsphere 0 0 0 5000\n");
    for gloss in ["gloss 0.5", "gloss 5", "gloss 0"] {
        let body = format!("maxdepth 1\n{MIRROR}{gloss}\n{}{sky}", plate(0, 0.0, -9e3));
        assert_eq!(red(&scene("-3 0 0.5", "0 0 0", &body), 256), 0.5, "{gloss}");
    }
}

/// No gloss, and a gloss of 0, are the perfect mirror, bit for bit and with one sample.
#[test]
fn a_gloss_of_zero_is_a_perfect_mirror() {
    let with = |gloss: &str| {
        let ball = "ambient 0 0 0\nspecular 0 0 0\nemission 1 .5 .25\nsphere 1 0 1 .5\n";
        let body = format!("{MIRROR}{gloss}\n{}{ball}", plate(0, 0.0, -9e3));
        let scene = scene("-3 0 3", "0 0 0", &body);
        let settings = Settings {
            width: 32,
            height: 24,
            ..sampled(&scene, 1)
        };
        let mut wide = scene.clone();
        wide.view.fovy = 50.0;
        planes(&wide, &settings)
    };
    assert_eq!(with(""), with("gloss 0"));
    assert_eq!(with(""), with("gloss 5\ngloss 0"));
    assert_ne!(with(""), with("gloss 5"));
    // As narrow as a lobe can be.
    assert_eq!(with(""), with("gloss 1e30"));
}
