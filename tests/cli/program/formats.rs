//! Picture files of every format.

use super::TestFolder;
use phalanx::image::PictureReader;
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

/// Scene with a surface that is partly transparent, over nothing and over another one.
fn translucent() -> TestFolder {
    let room = TestFolder::new();
    room.write(
        "a.mtl",
        "newmtl a\nKd .2 .5 .9\nd .5\nnewmtl b\nKd .9 .5 .1\n",
    );
    room.write(
        "a.obj",
        "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nv -.5 -1.5 -.5\nv 1.5 -.5 -.5\nv .5 1.5 -.5\n\
         usemtl a\nf 1 2 3\nusemtl b\nf 4 5 6\n",
    );
    room
}

/// Every way to a picture gives the same bytes, with alpha in PNG and with half floats.
#[test]
fn alpha_and_halves_are_the_same_whatever_made_them() {
    let room = translucent();
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    for (ending, options) in [
        ("png", "--aov alpha"),
        ("png", "--aov alpha --bits 16"),
        ("exr", "--aov all,alpha --bits 16"),
    ] {
        let name = format!("a.{ending}");
        let options = format!("--size 150x130 --spp 4 --filter mitchell {options}");
        let made = |more: &str| {
            room.ok(&format!("render a.obj -o {name} {options} {more}"));
            bytes(&name)
        };
        let scalar = made("--engine scalar");
        for kernel in ["single", "packet8", "auto"] {
            let same = scalar == made(&format!("--kernel {kernel} --threads 2 --tile 8"));
            assert!(same, "{name} {kernel}");
        }
        // Tiles keep what both are made of, so that a second run traces nothing.
        for _ in 0..2 {
            assert!(scalar == made("--checkpoint a.ckpt"), "{name}");
        }
        fs::remove_file(room.path().join("a.ckpt")).unwrap();
        for (frames, more) in [("f", ""), ("g", "--engine scalar")] {
            room.ok(&format!(
                "render a.obj -o {frames}#.{ending} --frames 1..2 --turntable 8 {options} {more}"
            ));
        }
        for frame in [1, 2] {
            let [simd, scalar] = ["f", "g"].map(|f| bytes(&format!("{f}{frame}.{ending}")));
            assert!(simd == scalar, "{name}, frame {frame}");
        }
        let alpha = channel(&room, &format!("f1.{ending}"), "A");
        assert!(alpha.contains(&0.0) && alpha.iter().any(|a| *a > 0.9));
    }
}

/// Samples of a picture by the name of the channel, as numbers.
fn channel(room: &TestFolder, name: &str, channel: &str) -> Vec<f64> {
    let mut reader = PictureReader::open(&room.path().join(name)).unwrap();
    let layout = reader.layout().clone();
    let offset = layout.channels.iter().position(|c| c.name == channel);
    let offset = offset.unwrap_or_else(|| panic!("no {channel} in {name}"));
    let planes = reader.read(0..layout.height).unwrap();
    let samples = planes[offset].iter();
    samples
        .map(|bits| layout.channels[offset].kind.value(*bits))
        .collect()
}

#[test]
fn straight_alpha_times_colour_is_the_colour_of_openexr() {
    let room = translucent();
    let options = "--size 150x130 --spp 4 --aov alpha";
    room.ok(&format!("render a.obj -o a.exr {options}"));
    room.ok(&format!(
        "render a.obj -o a.png {options} --transfer none --bits 16"
    ));
    let [linear, png] = ["a.exr", "a.png"].map(|name| channel(&room, name, "A"));
    let partly = linear.iter().filter(|a| **a > 0.0 && **a < 1.0).count();
    assert!(partly > 500 && linear.contains(&0.0) && linear.contains(&1.0));
    for (a, straight) in linear.iter().zip(&png) {
        assert!((255.0 * a - straight).abs() < 0.01, "{a} {straight}");
    }
    for color in ["R", "G", "B"] {
        let [weighted, straight] = ["a.exr", "a.png"].map(|name| channel(&room, name, color));
        for (k, a) in linear.iter().enumerate() {
            // Colours above 1 are clamped.
            let want = weighted[k].min(*a);
            let got = straight[k] / 255.0 * a;
            assert!((want - got).abs() < 3e-5, "{color} {k}: {want} {got}");
        }
    }
    // A preview and a snapshot show the surfaces over black.
    room.ok(&format!("render a.obj -o b.png {options} --snapshot s.png"));
    assert!(channel(&room, "s.png", "A").iter().all(|a| *a == 255.0));
    assert_eq!(room.run("compare a.png b.png --tolerance 1").code, Some(4));
}

#[test]
fn halves_are_rounded_floats_and_other_layers_keep_their_bits() {
    let room = translucent();
    let options = "--size 150x130 --spp 3 --aov all,alpha --light 0,0,3,9e5,9,1e-4";
    room.ok(&format!("render a.obj -o whole.exr {options} --bits 32"));
    room.ok(&format!("render a.obj -o half.exr {options} --bits 16"));
    room.ok(&format!("render a.obj -o plain.exr {options}"));
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    assert!(bytes("whole.exr") == bytes("plain.exr"));
    assert!(bytes("half.exr").len() < bytes("whole.exr").len());
    for name in ["R", "A", "albedo.R", "direct.B"] {
        let [full, half] = ["whole.exr", "half.exr"].map(|file| channel(&room, file, name));
        assert!(full != half, "{name}");
        for (full, half) in full.iter().zip(half) {
            let most = 65_504.0;
            let error = (full.clamp(-most, most) - half).abs();
            assert!(error <= full.abs() / 2048.0 + 3e-8, "{name}: {full} {half}");
        }
    }
    let brightest = channel(&room, "half.exr", "R")
        .into_iter()
        .fold(0.0, f64::max);
    assert_eq!(brightest, 65_504.0);
    for name in [
        "Z",
        "P.X",
        "N.Y",
        "Ng.Z",
        "primitive.id",
        "CryptoObject00.R",
        "CryptoMaterial01.A",
    ] {
        let [full, half] = ["whole.exr", "half.exr"].map(|file| channel(&room, file, name));
        let bits = |samples: Vec<f64>| samples.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert!(bits(full) == bits(half), "{name}");
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
