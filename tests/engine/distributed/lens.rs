//! Depth of field.

use super::{planes, sampled};
use crate::common::tolerances::{BLUR_WIDTH, PLACE};
use phalanx::formats::read_test;
use phalanx::frame::{Lens, LensError, Settings};
use phalanx::scene::Scene;

/// Pixels along a side, and the increase in slope from one to the next.
const SIDE: u32 = 48;
const SLOPE: f64 = 0.004;

/// A picture along -z from the origin of an emissive ball, which looks equally large from every
/// direction; lengths are scaled by `unit`.
fn ball([x, y, z]: [f64; 3], radius: f64, unit: f32) -> Scene {
    let half = f64::from(SIDE) * SLOPE / 2.0;
    let fovy = 2.0 * libm::atan(half).to_degrees();
    let [x, y, z, radius] = [x, y, z, radius].map(|c| c as f32 * unit);
    let text = format!(
        "size {SIDE} {SIDE}\ncamera 0 0 0 0 0 {} 0 1 0 {fovy}\nambient 0 0 0\nemission 1 1 1\nsphere {x} {y} {z} {radius}\n",
        -unit
    );
    match read_test(&text) {
        Ok(loaded) => loaded.scene,
        Err(errors) => panic!("{text}\n{errors:#?}"),
    }
}

fn through(scene: &Scene, spp: u32, aperture: f32, focus: f32) -> Settings {
    Settings {
        lens: Some(Lens { aperture, focus }),
        ..sampled(scene, spp)
    }
}

/// Mean and variance of a picture along its rows and columns, from its centre, in pixels.
fn moments(red: &[f32]) -> [[f64; 2]; 2] {
    let middle = f64::from(SIDE) / 2.0;
    let (mut all, mut sums) = (0.0, [[0.0; 2]; 2]);
    for (k, &c) in (0..).zip(red) {
        let weight = f64::from(c);
        let places = [k % SIDE, k / SIDE].map(|p| f64::from(p) + 0.5 - middle);
        all += weight;
        for (sum, place) in sums.iter_mut().zip(places) {
            sum[0] += weight * place;
            sum[1] += weight * place * place;
        }
    }
    sums.map(|[first, second]| {
        let mean = first / all;
        [mean, second / all - mean * mean]
    })
}

/// A small object at distance d is spread over a disc of diameter A |d - f|/d in the plane of focus
/// (the lens equation, by similar triangles), seen from distance f. The variance along an axis is a
/// quarter of the squared radius; those of the object itself and of the square pixel are added.
#[test]
fn the_blur_is_as_wide_as_the_lens_equation_says() {
    let (aperture, focus) = (0.2f64, 5.0f64);
    for (position, radius) in [
        ([0.0, 0.0, -10.0], 0.05),
        ([0.0, 0.0, -2.5], 0.02),
        ([0.1, -0.05, -40.0], 0.3),
        ([0.3, 0.2, -5.0], 0.05),
    ] {
        let [x, y, z] = position;
        let distance: f64 = -z;
        let scene = ball(position, radius, 1.0);
        let settings = through(&scene, 1024, aperture as f32, focus as f32);
        let [red, ..] = planes(&scene, &settings);
        let blur = 0.5 * aperture * (distance - focus).abs() / distance / focus;
        let own = radius / distance;
        let variance = (blur * blur + own * own) / 4.0 / (SLOPE * SLOPE) + 1.0 / 12.0;
        // The blur of out-of-focus objects must dominate.
        assert!(blur > 1.5 * own || distance == focus);
        let [across, down] = moments(&red);
        for ([mean, got], want) in [(across, x / distance), (down, -y / distance)] {
            let want = want / SLOPE;
            assert!(
                (mean - want).abs() < 0.05,
                "{position:?}: at {mean}, not {want}"
            );
            assert!(
                (got - variance).abs() < BLUR_WIDTH * variance,
                "{position:?}: variance {got}, not {variance}"
            );
        }
    }
}

/// A lens of diameter 0 is the pinhole, bit for bit.
#[test]
fn an_aperture_of_zero_is_a_pinhole() {
    let scene = ball([0.3, 0.2, -5.0], 0.3, 1.0);
    for spp in [1, 4] {
        let pinhole = planes(&scene, &sampled(&scene, spp));
        assert_eq!(planes(&scene, &through(&scene, spp, 0.0, 2.0)), pinhole);
        assert_ne!(planes(&scene, &through(&scene, spp, 0.1, 2.0)), pinhole);
    }
}

/// Aperture and focus are in the file's units, even if the scene was scaled when it was read.
#[test]
fn lenses_scale_with_the_scene() {
    let picture = |unit: f32| {
        let scene = ball([0.3, 0.2, -5.0], 0.3, unit);
        let settings = through(&scene, 4, 0.1 * unit, 2.0 * unit);
        (scene.scale, planes(&scene, &settings))
    };
    let (unit, same) = picture(1.0);
    assert_eq!(unit, 1.0);
    for scale in [1.099_511_6e12, 9.094_947e-13] {
        let (unit, scaled) = picture(scale);
        assert!(unit != 1.0, "{scale}: {unit}");
        assert_eq!(scaled, same, "{scale}");
    }
}

/// All rays of a point in the picture meet at one point of the plane of focus, which is
/// perpendicular to the view direction.
#[test]
fn rays_through_the_lens_meet_in_the_plane_of_focus() {
    let mut scene = ball([0.0, 0.0, -5.0], 0.3, 1.0);
    scene.view.eye = glam::Vec3::new(1.0, 2.0, 3.0);
    let camera = through(&scene, 1, 0.5, 4.0)
        .camera(&scene)
        .expect("a camera");
    let back = scene.view.basis().expect("a frame").w;
    for (row, column) in [(24.0, 24.0), (0.5, 7.25), (47.5, 47.5)] {
        let straight = camera.direction(row, column);
        let want = camera.eye + straight * (4.0 / -straight.dot(back));
        for lens_point in [[0.0, 0.0], [1.0, 0.0], [-0.6, 0.8], [0.1, -0.9]] {
            let (org, dir) = camera.through_lens(row, column, lens_point);
            let away = org - camera.eye;
            let off = f32::hypot(lens_point[0], lens_point[1]) * 0.25;
            assert!((away.length() - off).abs() < PLACE && away.dot(back).abs() < PLACE);
            let met = org + dir * (4.0 / -dir.dot(back));
            assert!(
                (met - want).length() < 8.0 * PLACE,
                "{lens_point:?}: {met} {want}"
            );
        }
    }
}

#[test]
fn impossible_lenses_are_refused() {
    let scene = ball([0.0, 0.0, -5.0], 0.3, 1.0);
    for (aperture, focus, want) in [
        (-1.0, 1.0, LensError::Aperture),
        (f32::NAN, 1.0, LensError::Aperture),
        (f32::INFINITY, 1.0, LensError::Aperture),
        (1.0, 0.0, LensError::Focus),
        (1.0, f32::INFINITY, LensError::Focus),
        (1.0, 1e-4, LensError::TooWide),
        (1e30, 1e30, LensError::TooWide),
    ] {
        let refused = through(&scene, 1, aperture, focus).camera(&scene).err();
        assert_eq!(refused, Some(want.into()), "{aperture} {focus}");
    }
}
