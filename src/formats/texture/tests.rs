use super::*;
use picture::tests::encoded;
use png::{BitDepth::Eight, ColorType};
use std::path::Path;

fn sampler(wrap: Wrap) -> TextureSampler {
    TextureSampler {
        wrap: [wrap; 2],
        nearest: false,
    }
}

#[test]
fn a_picture_stands_once_for_each_wrapping() {
    let folder = tempfile::tempdir().unwrap();
    let dot = encoded([1, 1], ColorType::Rgb, Eight, &[1, 2, 3]);
    std::fs::write(folder.path().join("dot.png"), &dot).unwrap();
    std::fs::write(folder.path().join("text.png"), "no picture").unwrap();
    let asset_dir = Folder::of(Path::new(&folder.path().join("scene")));
    let mut report = DiagnosticSink::binary();
    let span = Span::START;
    let mut library = TextureLibrary::new(&asset_dir);
    let (repeat, clamp) = (sampler(Wrap::Repeat), sampler(Wrap::Clamp));
    let mut named = |name, wrap| library.named(name, wrap, || span, &mut report);
    assert_eq!(named("dot.png", clamp), 0);
    assert_eq!(named("dot.png", repeat), 1);
    assert_eq!(named("dot.png", clamp), 0);
    for missing in ["text.png", "absent.png", "text.png", "absent.png"] {
        assert_eq!(named(missing, clamp), NO_TEXTURE);
    }
    let mut calls = 0;
    for _ in 0..2 {
        let bytes = || {
            calls += 1;
            Ok(Cow::Borrowed(&dot[..]))
        };
        let span = || unreachable!("nothing is wrong");
        let row = library.embedded(Embedded::Text(7), bytes, clamp, span, &mut report);
        assert_eq!(row, 2);
    }
    assert_eq!(calls, 1, "decoded once");
    let wraps: Vec<_> = library.into_textures().iter().map(|t| t.wrap).collect();
    assert_eq!(wraps, [clamp, repeat, clamp].map(|sampler| sampler.wrap));
    let warnings = report.finish().expect("no errors");
    let messages: Vec<&str> = warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(messages.len(), 2, "once for each: {messages:?}");
    assert!(messages[0].contains("`text.png`") && messages[0].contains("not a picture"));
}

#[test]
fn textures_count_before_they_are_decoded() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.png", "b.png"] {
        // A megabyte of pixels in a kilobyte.
        let bytes = encoded([1024, 1024], ColorType::Grayscale, Eight, &[7; 1 << 20]);
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let span = || Span::START;
    let repeat = sampler(Wrap::Repeat);
    let named = |most: u64, names: &[&str]| {
        let asset_dir = Folder::of(&folder.path().join("scene")).with_limit(Some(most));
        let mut report = DiagnosticSink::binary();
        let mut library = TextureLibrary::new(&asset_dir);
        for name in names {
            library.named(name, repeat, span, &mut report);
        }
        (asset_dir.memory().refusal(), report.finish().is_ok())
    };
    const EACH: u64 = 3 << 20;
    const ROOM: u64 = 2 << 20;
    assert_eq!(named(EACH + ROOM, &["a.png", "a.png"]), (None, true));
    assert_eq!(named(2 * EACH + ROOM, &["a.png", "b.png"]), (None, true));
    let (refused, read) = named(EACH + ROOM, &["a.png", "b.png"]);
    let refused = refused.expect("the second");
    assert!(refused.what.contains("`b.png`"), "{refused:?}");
    assert!(!read && refused.needed >= 2 * EACH && refused.allowed == EACH + ROOM);
    assert!(named(EACH, &["a.png"]).0.is_some());
}

#[test]
fn alpha_is_kept_for_those_who_read_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, color, samples: &[u8]| {
        let bytes = encoded([2, 1], color, Eight, samples);
        std::fs::write(folder.path().join(name), bytes).unwrap();
    };
    file("leaf.png", ColorType::Rgba, &[255, 0, 0, 9, 1, 1, 1, 255]);
    file(
        "whole.png",
        ColorType::Rgba,
        &[1, 2, 3, 255, 90, 90, 90, 255],
    );
    file("white.png", ColorType::Grayscale, &[255, 255]);
    let asset_dir = Folder::of(&folder.path().join("scene"));
    let mut report = DiagnosticSink::binary();
    let span = || Span::START;
    let mut library = TextureLibrary::new(&asset_dir);
    let [repeat, clamp] = [Wrap::Repeat, Wrap::Clamp].map(sampler);
    let mut named = |name, wrap| library.named(name, wrap, span, &mut report);
    let leaves = [named("leaf.png", repeat), named("leaf.png", clamp)];
    let wholes = [named("whole.png", repeat), named("whole.png", clamp)];
    let white = named("white.png", clamp);
    assert_eq!(library.alpha_of(leaves[1]), leaves[1]);
    for none in [wholes[0], white, NO_TEXTURE] {
        assert_eq!(library.alpha_of(none), NO_TEXTURE);
    }
    for _ in 0..2 {
        let mut mask = |row| library.mask_of(row, span, &mut report);
        assert_eq!(mask(leaves[1]), leaves[1]);
        assert_eq!(mask(wholes[1]), wholes[1]);
        assert_eq!(mask(white), NO_TEXTURE);
        assert_eq!(mask(NO_TEXTURE), NO_TEXTURE);
    }
    let textures = library.into_textures();
    let alpha = textures.iter().map(|t| &t.alpha[..]);
    // Grey 90 keeps its value, and (1, 2, 3) is as bright as 2.
    let expected: [&[u8]; 5] = [&[], &[9, 255], &[], &[2, 90], &[]];
    assert!(alpha.eq(expected), "{textures:?}");
}

#[test]
fn alpha_counts_before_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, color, sample: &[u8]| {
        let bytes = encoded([1024, 1024], color, Eight, &sample.repeat(1 << 20));
        std::fs::write(folder.path().join(name), bytes).unwrap();
    };
    file("half.png", ColorType::GrayscaleAlpha, &[7, 128]);
    file("grey.png", ColorType::Grayscale, &[7]);
    let refused = |most: u64, name: &str| {
        let asset_dir = Folder::of(&folder.path().join("scene")).with_limit(Some(most));
        let mut report = DiagnosticSink::binary();
        let mut library = TextureLibrary::new(&asset_dir);
        let row = library.named(name, sampler(Wrap::Repeat), || Span::START, &mut report);
        library.mask_of(row, || Span::START, &mut report);
        assert_eq!(
            report.finish().is_err(),
            asset_dir.memory().refusal().is_some()
        );
        asset_dir.memory().refusal().map(|refusal| refusal.what)
    };
    const MEGABYTE: u64 = 1 << 20;
    let what = refused(4 * MEGABYTE, "half.png").expect("no room for its alpha and tables");
    assert!(what.contains("to decode"), "{what}");
    assert_eq!(refused(6 * MEGABYTE, "half.png"), None);
    assert_eq!(refused(5 * MEGABYTE, "grey.png"), None);
    // Tables and the file are lent only, so that a mask fits where they were.
    assert_eq!(refused(4 * MEGABYTE + 8192, "grey.png"), None);
}

#[test]
fn all_textures_together_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, width: u32| {
        let samples = vec![7; width as usize];
        let bytes = encoded([width, 1], ColorType::Grayscale, Eight, &samples);
        std::fs::write(folder.path().join(name), bytes).unwrap();
    };
    file("two.png", 2);
    file("three.png", 3);
    let asset_dir = Folder::of(&folder.path().join("scene"));
    let mut report = DiagnosticSink::binary();
    let span = || Span::START;
    let mut library = TextureLibrary::new(&asset_dir);
    library.texels_left = 4;
    let mut named = |name, wrap| library.named(name, wrap, span, &mut report);
    let [repeat, clamp, mirror] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror].map(sampler);
    assert_eq!(named("two.png", repeat), 0);
    assert_eq!(named("three.png", repeat), NO_TEXTURE);
    assert_eq!(named("./two.png", clamp), 1, "a copy");
    for _ in 0..2 {
        assert_eq!(named("two.png", mirror), NO_TEXTURE, "a copy too many");
    }
    assert_eq!(named(".//two.png", clamp), 1);
    let warnings = report.finish().expect("no errors");
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings[0]
            .message
            .contains("`three.png` is left out: with its 3×1 texels")
    );
}
