//! Picture files of every format.

use super::TestFolder;
use std::fs;

/// First bytes of files of each format.
const FORMATS: [(&str, &[u8]); 6] = [
    ("png", b"\x89PNG\r\n\x1a\n"),
    ("jpg", b"\xff\xd8\xff"),
    ("jpeg", b"\xff\xd8\xff"),
    ("exr", b"\x76\x2f\x31\x01"),
    ("hdr", b"#?RADIANCE\n"),
    ("pfm", b"PF\n40 24\n-1.0\n"),
];

#[test]
fn a_file_of_each_format_is_the_same_whatever_made_it() {
    let room = TestFolder::new();
    for (ending, magic) in FORMATS {
        let bytes = |options: &str| {
            room.ok(&format!("render a.test -o a.{ending} --spp 3 {options}"));
            fs::read(room.path().join(format!("a.{ending}"))).unwrap()
        };
        let scalar = bytes("--engine scalar");
        assert!(scalar.starts_with(magic), "{ending}");
        assert!(scalar == bytes("--threads 2 --tile 8"), "{ending}");
    }
}

#[test]
fn sixteen_bits_say_more_than_eight() {
    let room = TestFolder::new();
    let load = |options: &str| {
        room.ok(&format!("render a.test -o a.png {options}"));
        phalanx::image::load(&room.path().join("a.png"))
            .unwrap()
            .pixels
    };
    for tone in ["", "--transfer srgb --exposure 0.5"] {
        let eight = load(tone);
        let sixteen = load(&format!("{tone} --bits 16"));
        let mut between = 0;
        for (coarse, fine) in eight.as_flattened().iter().zip(sixteen.as_flattened()) {
            // Both are rounded down.
            let (coarse, fine) = (f64::from(*coarse) / 257.0, f64::from(*fine) / 257.0);
            assert!(
                fine - coarse > -0.01 && fine - coarse < 1.0,
                "{coarse} {fine}"
            );
            between += u32::from(fine > coarse);
        }
        assert!(between > 500, "{between} samples between two of 8 bits");
    }
}

#[test]
fn exposure_makes_a_picture_lighter() {
    let room = TestFolder::new();
    let samples = |options: &str| -> Vec<u16> {
        room.ok(&format!("render a.test -o a.png --bits 16 {options}"));
        let raster = phalanx::image::load(&room.path().join("a.png")).unwrap();
        raster.pixels.iter().flat_map(|p| p[..3].to_vec()).collect()
    };
    let plain = samples("");
    assert_eq!(samples("--exposure 0"), plain);
    let (halved, doubled) = (samples("--exposure=-1"), samples("--exposure 1"));
    let mut between = 0;
    for ((plain, halved), doubled) in plain.iter().zip(halved).zip(doubled) {
        match plain {
            // Above 1, and clamped.
            65_535 => assert!(halved >= 32_767 && doubled == 65_535, "{halved} {doubled}"),
            // Both are rounded down.
            &plain => {
                assert!(halved.abs_diff(plain / 2) <= 1, "{halved} of {plain}");
                assert!(doubled >= plain.saturating_mul(2), "{doubled} of {plain}");
                between += u32::from(plain > 2);
            }
        }
    }
    assert!(
        between > 500,
        "{between} samples that are neither black nor white"
    );
}
