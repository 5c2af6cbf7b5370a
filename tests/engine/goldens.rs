//! The standard scenes match their last reviewed pictures in `scenes/golden`, pixel for pixel.
//!
//! `PHALANX_BLESS=1 cargo test --release --test engine goldens::` rewrites the pictures; review
//! them before committing.

use phalanx::frame::{Accel, Control, Engine, Settings, render};
use phalanx::image::{Picture, encode, load, save_png};
use phalanx::scene::Scene;
use phalanx::standard::{self, CATALOGUE, Family};
use std::path::{Path, PathBuf};

fn golden(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/golden");
    folder.join(name).with_extension("png")
}

fn picture(scene: &Scene, engine: Engine, (width, height): (u32, u32)) -> Picture {
    let prepared = Accel::build(scene, engine);
    let settings = Settings {
        width,
        height,
        engine,
        threads: 2,
        ..Settings::of(scene)
    };
    let frame = render(scene, &prepared, &settings, &Control::default());
    encode(&frame.expect("nobody interrupts").film, scene.encoding)
}

/// Number of pixels that differ from the golden picture, which is rewritten first if requested.
fn differences(name: &str, picture: &Picture) -> usize {
    if std::env::var_os("PHALANX_BLESS").is_some() {
        save_png(&golden(name), picture).expect("a golden picture");
    }
    let want = load(&golden(name)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        (want.width, want.height),
        (picture.width, picture.height),
        "{name}"
    );
    let pixels = picture.rgb.chunks_exact(3).zip(&want.pixels);
    let equal = |(a, b): (&[u8], &[u16; 4])| (0..3).all(|c| u16::from(a[c]) * 257 == b[c]);
    pixels.filter(|&(a, b)| !equal((a, b))).count()
}

/// The databases at their default size, the modern scenes small, so that they render quickly.
#[test]
fn standard_scenes_look_as_they_did() {
    let mut wrong = Vec::new();
    for entry in CATALOGUE {
        let (spec, size) = match entry.family {
            Family::Spd => (format!("standard:{}", entry.name), (256, 256)),
            Family::Modern => (format!("standard:{}:20k", entry.name), (256, 192)),
        };
        let spec = standard::parse_spec(&spec).expect("a scene of the catalogue");
        let scene = standard::scene(spec, 0).expect("a scene that can be traced");
        let seen = picture(&scene, Engine::Simd, size);
        assert!(
            seen.rgb == picture(&scene, Engine::Scalar, size).rgb,
            "{}: the engines differ",
            entry.name
        );
        let differ = differences(entry.name, &seen);
        if differ > 0 {
            wrong.push(format!("{}: {differ} pixels differ", entry.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
