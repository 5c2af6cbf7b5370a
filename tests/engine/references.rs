//! The course's scenes against independent renderings of them.

use crate::common::tolerances::{
    COVERAGE_SHARE, REFERENCE_LEVELS, REFERENCE_SHARE, REFERENCE_SPREAD,
};
use phalanx::formats::{Options, load};
use phalanx::frame::{Accel, Control, Engine, Frame, Settings, render};
use phalanx::render::NO_HIT;
use std::path::PathBuf;

/// The course's folder, if available.
fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/cse167");
    let there = folder.join("reference").is_dir();
    if !there {
        println!("skipped: {} is not there", folder.display());
    }
    there.then_some(folder)
}

struct ReferenceImage {
    width: u32,
    height: u32,
    /// RGB, row by row.
    bytes: Vec<u8>,
}

impl ReferenceImage {
    fn read(path: PathBuf) -> ReferenceImage {
        let picture = phalanx::image::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let high_bytes = |[r, g, b, _]: [u16; 4]| [r, g, b].map(|sample| (sample >> 8) as u8);
        ReferenceImage {
            width: picture.width,
            height: picture.height,
            bytes: picture.pixels.into_iter().flat_map(high_bytes).collect(),
        }
    }

    fn pixels(&self) -> impl Iterator<Item = &[u8]> {
        self.bytes.chunks(3)
    }
}

fn frame_of(folder: &std::path::Path, name: &str) -> Frame {
    let path = folder.join(name).with_extension("test");
    let scene = load(&path, &Options::default())
        .unwrap_or_else(|error| panic!("{error}"))
        .scene;
    let settings = Settings {
        record_hits: true,
        ..Settings::of(&scene)
    };
    let prepared = Accel::build(&scene, Engine::Simd);
    render(&scene, &prepared, &settings, &Control::default()).expect("a frame")
}

/// floor(255 c), c clamped to \[0, 1\]: the convention that the references share.
fn quantised(frame: &Frame) -> Vec<[i32; 3]> {
    let film = &frame.film;
    let count = film.planes[0].len();
    let level = |c: f32| (c.clamp(0.0, 1.0) * 255.0).floor() as i32;
    (0..count)
        .map(|i| [0, 1, 2].map(|k| level(film.planes[k][i])))
        .collect()
}

#[test]
fn colours_equal_the_median_of_the_references() {
    let Some(folder) = folder() else { return };
    for name in [
        "scene4-ambient",
        "scene4-diffuse",
        "scene4-emission",
        "scene5",
        "scene7",
    ] {
        let reference = |what: &str| {
            ReferenceImage::read(folder.join("reference").join(format!("{name}__{what}.png")))
        };
        let (median, spread) = (reference("consensus_median"), reference("spread"));
        let frame = frame_of(&folder, name);
        let size = (frame.film.width, frame.film.height);
        assert_eq!(size, (median.width, median.height), "{name}");
        assert_eq!(size, (spread.width, spread.height), "{name}");
        let ours = quantised(&frame);
        let (mut pixel, mut equal, mut exact) = (0, 0, 0);
        for ((ours, median), spread) in ours.iter().zip(median.pixels()).zip(spread.pixels()) {
            if spread.iter().any(|&s| s > REFERENCE_SPREAD) {
                continue;
            }
            pixel += 1;
            let away = (0..3).map(|k| (ours[k] - i32::from(median[k])).abs());
            let away = away.max().unwrap_or(0);
            equal += u32::from(away <= REFERENCE_LEVELS);
            exact += u32::from(away == 0);
        }
        let share = f64::from(equal) / f64::from(pixel);
        println!(
            "{name}: {:.4} % of {pixel} pixels within {REFERENCE_LEVELS}, {:.4} % exact",
            100.0 * share,
            100.0 * f64::from(exact) / f64::from(pixel)
        );
        let pixels = size.0 * size.1;
        assert!(
            pixel > pixels / 2,
            "{name}: the mask leaves {pixel} of {pixels}"
        );
        assert!(share >= REFERENCE_SHARE, "{name}: {share}");
    }
}

#[test]
fn coverage_equals_the_references() {
    let Some(folder) = folder() else { return };
    for (scene, author) in [
        ("scene1-camera1", "bzliu94"),
        ("scene1-camera2", "bzliu94"),
        ("scene1-camera3", "bzliu94"),
        ("scene1-camera4", "bzliu94"),
        ("scene1-camera4", "gabmech"),
        ("scene2-camera1", "bzliu94"),
        ("scene2-camera1", "lucyhu798"),
        ("scene2-camera3", "bzliu94"),
        ("scene2-camera3", "lucyhu798"),
        ("scene3", "bzliu94"),
        ("scene3", "friidryce"),
    ] {
        let path = folder
            .join("reference")
            .join(format!("{scene}__{author}.png"));
        let picture = ReferenceImage::read(path);
        let frame = frame_of(&folder, scene);
        let size = (frame.film.width, frame.film.height);
        assert_eq!(size, (picture.width, picture.height), "{scene} by {author}");
        let hits = frame.film.hits.as_ref().expect("recorded hits");
        let (mut equal, mut covered) = (0u32, 0u32);
        for (&prim_id, pixel) in hits.prim_id.iter().zip(picture.pixels()) {
            let theirs = pixel.iter().any(|&c| c > 0);
            covered += u32::from(theirs);
            equal += u32::from(theirs == (prim_id != NO_HIT));
        }
        let pixels = size.0 * size.1;
        let share = f64::from(equal) / f64::from(pixels);
        println!(
            "{scene} by {author}: coverage equal in {:.4} % of {pixels} pixels, {covered} covered",
            100.0 * share
        );
        assert!(
            covered > pixels / 100 && covered < pixels,
            "{scene} by {author}"
        );
        assert!(share >= COVERAGE_SHARE, "{scene} by {author}: {share}");
    }
}
