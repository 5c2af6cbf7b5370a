use super::*;
use png::{BitDepth, ColorType};

const HALVED: &[u8] = include_bytes!("../../../tests/pictures/halved.jpg");
const PROGRESSIVE: &[u8] = include_bytes!("../../../tests/pictures/progressive.jpg");
const GREY: &[u8] = include_bytes!("../../../tests/pictures/grey.jpg");
/// A picture of 16 bits a sample: 3000·x, 5000·y, 200·x·y.
const INTERLACED: &[u8] = include_bytes!("../../../tests/pictures/interlaced.png");

fn pixels(bytes: &[u8]) -> Result<Vec<[u8; 3]>, String> {
    Ok(EncodedImage::open(bytes)?.decode()?.colors)
}

fn alpha(bytes: &[u8]) -> Result<Vec<u8>, String> {
    Ok(EncodedImage::open(bytes)?.decode()?.alpha)
}

/// A PNG of these samples.
pub(in crate::formats) fn encoded(
    [width, height]: [u32; 2],
    color: ColorType,
    depth: BitDepth,
    samples: &[u8],
) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == ColorType::Indexed {
        encoder.set_palette(&[1, 2, 3, 4, 5, 6][..]);
    }
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(samples).expect("a picture");
    drop(writer);
    out
}

/// FNV-1a hash.
fn hash(pixels: &[[u8; 3]]) -> u64 {
    let bytes = pixels.iter().flatten();
    bytes.fold(0xcbf2_9ce4_8422_2325, |h, &b| {
        (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3)
    })
}

#[test]
fn a_jpeg_decodes_to_the_same_bytes_on_every_build() {
    for (bytes, expected) in [
        (HALVED, 0x38a6_379d_341c_816a),
        (PROGRESSIVE, 0xfaa5_6fa3_5769_1093),
        (GREY, 0x19e5_6f92_a072_6fd6),
    ] {
        let picture = EncodedImage::open(bytes).expect("a picture");
        assert_eq!((picture.width, picture.height), (21, 13));
        let hash = hash(&picture.decode().expect("a picture").colors);
        assert_eq!(hash, expected, "{hash:#x}");
    }
    // A ramp to the right, a ramp downward, and a chequer, as they were painted.
    let texels = pixels(PROGRESSIVE).expect("a picture");
    for (i, &[red, green, _]) in texels.iter().enumerate() {
        assert!(red.abs_diff((i % 21 * 12) as u8) < 48, "{i}: {red}");
        assert!(green.abs_diff((i / 21 * 19) as u8) < 48, "{i}: {green}");
    }
    let grey = pixels(GREY).expect("a picture");
    assert!(grey.iter().all(|[r, g, b]| r == g && g == b));
}

#[test]
fn every_png_becomes_srgb_bytes() {
    let two = |color, depth, samples: &[u8]| {
        pixels(&encoded([2, 1], color, depth, samples)).expect("a picture")
    };
    use BitDepth::{Eight, One, Sixteen};
    let expected = [[0, 0, 0], [200, 200, 200]];
    assert_eq!(two(ColorType::Grayscale, Eight, &[0, 200]), expected);
    let alpha = two(ColorType::GrayscaleAlpha, Eight, &[0, 9, 200, 0]);
    assert_eq!(alpha, expected);
    let samples = [0u16, 200 * 257].map(u16::to_be_bytes);
    let wide = two(ColorType::Grayscale, Sixteen, samples.as_flattened());
    assert_eq!(wide, expected);
    let color = two(ColorType::Rgba, Eight, &[1, 2, 3, 0, 4, 5, 6, 255]);
    assert_eq!(color, [[1, 2, 3], [4, 5, 6]]);
    let indexed = two(ColorType::Indexed, One, &[0x40]);
    assert_eq!(indexed, [[1, 2, 3], [4, 5, 6]]);
}

#[test]
fn alpha_is_kept_where_a_pixel_is_not_whole() {
    use BitDepth::{Eight, Sixteen};
    use ColorType::{GrayscaleAlpha, Rgb, Rgba};
    const NONE: [u8; 0] = [];
    let of = |color, depth, samples: &[u8]| {
        alpha(&encoded([2, 1], color, depth, samples)).expect("a picture")
    };
    assert_eq!(of(Rgba, Eight, &[1, 2, 3, 255, 4, 5, 6, 7]), [255, 7]);
    assert_eq!(of(Rgba, Eight, &[1, 2, 3, 7, 4, 5, 6, 255]), [7, 255]);
    assert_eq!(of(Rgba, Eight, &[1, 2, 3, 255, 4, 5, 6, 255]), NONE);
    assert_eq!(of(Rgb, Eight, &[1, 2, 3, 4, 5, 6]), NONE);
    assert_eq!(of(GrayscaleAlpha, Eight, &[0, 9, 200, 0]), [9, 0]);
    let samples = [0u16, 9 * 257 + 128, 7, 65_534].map(u16::to_be_bytes);
    let wide = of(GrayscaleAlpha, Sixteen, samples.as_flattened());
    assert_eq!(wide, [9, 255]);
}

/// Checks the alpha of palettes, which may have fewer entries of it than colours, and of a colour
/// that stands for clear pixels.
#[test]
fn alpha_of_palettes_and_of_a_clear_colour_is_kept() {
    let of = |color, depth, clear: &'static [u8], samples: &[u8]| {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, 4, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == ColorType::Indexed {
            encoder.set_palette(&[1, 2, 3, 4, 5, 6, 7, 8, 9][..]);
        }
        encoder.set_trns(clear);
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(samples).expect("a picture");
        writer.finish().expect("a picture");
        alpha(&out).expect("a picture")
    };
    use BitDepth::{Eight, Four, Two};
    let indexed = of(ColorType::Indexed, Two, &[9, 0], &[0b0001_1000]);
    assert_eq!(indexed, [9, 0, 255, 9]);
    let grey = of(ColorType::Grayscale, Four, &[0, 5], &[0x05, 0x55]);
    assert_eq!(grey, [255, 0, 0, 0]);
    let key = [0, 1, 0, 2, 0, 3];
    let key: &'static [u8] = Box::leak(key.into());
    let colors = [1, 2, 3, 1, 2, 4, 1, 2, 3, 0, 0, 0];
    assert_eq!(of(ColorType::Rgb, Eight, key, &colors), [0, 255, 0, 255]);
}

#[test]
fn pixels_of_an_interlaced_png_find_their_places() {
    let near = |sample: usize| ((sample % 65_536) as f64 * 255.0 / 65_535.0).round() as u8;
    let pixels = pixels(INTERLACED).expect("a picture");
    assert_eq!(pixels.len(), 21 * 13);
    for (k, &pixel) in pixels.iter().enumerate() {
        let (x, y) = (k % 21, k / 21);
        assert_eq!(
            pixel,
            [3000 * x, 5000 * y, 200 * x * y].map(near),
            "{x} {y}"
        );
    }
    let cut = &INTERLACED[..INTERLACED.len() / 2];
    assert!(
        super::EncodedImage::open(cut)
            .and_then(EncodedImage::decode)
            .is_err()
    );
}

/// Checks that a picture of one value may take a thousandth of the bytes of its pixels, at any
/// depth.
#[test]
fn even_pictures_are_no_shorter_than_they_claim() {
    for (color, depth, bytes) in [
        (ColorType::Indexed, BitDepth::One, 2048 / 8),
        (ColorType::Indexed, BitDepth::Four, 2048 / 2),
        (ColorType::Rgba, BitDepth::Eight, 2048 * 4),
    ] {
        let even = encoded([2048, 2048], color, depth, &vec![0; bytes * 2048]);
        assert_eq!(pixels(&even).map(|p| p.len()), Ok(2048 * 2048), "{color:?}");
    }
}

#[test]
fn what_decoding_takes_is_known_before() {
    let even = encoded(
        [64, 64],
        ColorType::Grayscale,
        BitDepth::Eight,
        &[7; 64 * 64],
    );
    assert_eq!(EncodedImage::open(&even).map(|p| p.scratch), Ok(TABLES));
    assert_eq!(EncodedImage::open(HALVED).map(|p| p.scratch), Ok(TABLES));
    let progressive = EncodedImage::open(PROGRESSIVE).map(|p| p.scratch);
    assert_eq!(progressive, Ok(TABLES + 32 * 32 * 3 * 2));
}

#[test]
fn a_size_is_believed_as_far_as_the_bytes_reach() {
    let mut huge = encoded([4, 4], ColorType::Grayscale, BitDepth::Eight, &[7; 16]);
    let side = huge.windows(4).position(|w| w == b"IHDR").unwrap() + 4;
    huge[side..side + 4].copy_from_slice(&16_000u32.to_be_bytes());
    huge[side + 4..side + 8].copy_from_slice(&16_000u32.to_be_bytes());
    assert!(pixels(&huge).is_err());
    huge[side..side + 4].copy_from_slice(&16_385u32.to_be_bytes());
    assert!(pixels(&huge).is_err());
    let mut jpeg = HALVED.to_vec();
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap() + 5;
    jpeg[frame..frame + 4].copy_from_slice(&[0x3f, 0xff, 0x3f, 0xff]);
    let refused = pixels(&jpeg).map(|_| "a picture");
    assert!(refused.unwrap_err().contains("too short"));
}
