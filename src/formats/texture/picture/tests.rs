use super::pixels::TABLES;
use super::*;
use ::png::{BitDepth, ColorType};

const HALVED: &[u8] = include_bytes!("../../../../tests/pictures/halved.jpg");
const PROGRESSIVE: &[u8] = include_bytes!("../../../../tests/pictures/progressive.jpg");
const GREY: &[u8] = include_bytes!("../../../../tests/pictures/grey.jpg");
/// A picture of 16 bits a sample: 3000·x, 5000·y, 200·x·y.
const INTERLACED: &[u8] = include_bytes!("../../../../tests/pictures/interlaced.png");

fn pixels(bytes: &[u8]) -> Result<Vec<[u8; 3]>, String> {
    Ok(EncodedImage::open(bytes)?.decode()?.colors)
}

fn alpha(bytes: &[u8]) -> Result<Vec<u8>, String> {
    Ok(EncodedImage::open(bytes)?.decode()?.alpha)
}

/// A PNG of these samples.
pub(crate) fn encoded(
    [width, height]: [u32; 2],
    color: ColorType,
    depth: BitDepth,
    samples: &[u8],
) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut out, width, height);
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
        (HALVED, 0x8ef6_f311_ffbb_1e1f),
        (PROGRESSIVE, 0xeea1_7e9a_4971_fbb3),
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
    let alpha_of = |color, depth, samples: &[u8]| {
        alpha(&encoded([2, 1], color, depth, samples)).expect("a picture")
    };
    assert_eq!(alpha_of(Rgba, Eight, &[1, 2, 3, 255, 4, 5, 6, 7]), [255, 7]);
    assert_eq!(alpha_of(Rgba, Eight, &[1, 2, 3, 7, 4, 5, 6, 255]), [7, 255]);
    assert_eq!(alpha_of(Rgba, Eight, &[1, 2, 3, 255, 4, 5, 6, 255]), NONE);
    assert_eq!(alpha_of(Rgb, Eight, &[1, 2, 3, 4, 5, 6]), NONE);
    assert_eq!(alpha_of(GrayscaleAlpha, Eight, &[0, 9, 200, 0]), [9, 0]);
    let samples = [0u16, 9 * 257 + 128, 7, 65_534].map(u16::to_be_bytes);
    let wide = alpha_of(GrayscaleAlpha, Sixteen, samples.as_flattened());
    assert_eq!(wide, [9, 255]);
}

/// Checks the alpha of palettes, which may have fewer alpha entries than colours, and of a colour
/// that marks clear pixels.
#[test]
fn alpha_of_palettes_and_of_a_clear_colour_is_kept() {
    let alpha_of = |color, depth, clear: &'static [u8], samples: &[u8]| {
        let mut out = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut out, 4, 1);
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
    let indexed = alpha_of(ColorType::Indexed, Two, &[9, 0], &[0b0001_1000]);
    assert_eq!(indexed, [9, 0, 255, 9]);
    let grey = alpha_of(ColorType::Grayscale, Four, &[0, 5], &[0x05, 0x55]);
    assert_eq!(grey, [255, 0, 0, 0]);
    let key = [0, 1, 0, 2, 0, 3];
    let key: &'static [u8] = Box::leak(key.into());
    let colors = [1, 2, 3, 1, 2, 4, 1, 2, 3, 0, 0, 0];
    assert_eq!(
        alpha_of(ColorType::Rgb, Eight, key, &colors),
        [0, 255, 0, 255]
    );
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

/// Appends a chunk after the header, or at the end.
fn with_chunk(png: &[u8], chunk: &[u8], at_end: bool) -> Vec<u8> {
    let offset = if at_end { png.len() } else { 33 };
    [&png[..offset], chunk, &png[offset..]].concat()
}

#[test]
fn what_surrounds_the_rows_is_no_objection() {
    let samples = [1, 2, 3, 4, 5, 6];
    let plain = encoded([3, 2], ColorType::Grayscale, BitDepth::Eight, &samples);
    let expected = samples.map(|sample| [sample; 3]);
    let data = plain.windows(4).position(|w| w == b"IDAT").expect("one") - 4;
    let gamma = b"\0\0\0\x04gAMA\0\0\xb1\x8f\x0b\xfc\x61\x05";
    let wrong_sum = b"\0\0\0\x07tIME\x07\xe4\x01\x01\x01\x01\x01\x01\x02\x03\x04";
    let no_profile = b"\0\0\0\x04iCCPnone\x01\x02\x03\x04";
    let nothing = b"\0\0\0\0IDAT\x35\xaf\x06\x1e";
    for picture in [
        with_chunk(&plain, gamma, false),
        with_chunk(&plain, wrong_sum, false),
        with_chunk(&plain, no_profile, false),
        with_chunk(&plain, b"after the end", true),
        with_chunk(&plain, nothing, false),
        [&plain[..data], nothing, nothing, &plain[data..]].concat(),
        plain[..plain.len() - 12].to_vec(),
    ] {
        assert_eq!(pixels(&picture).as_deref(), Ok(&expected[..]));
    }
    let fewer = [&plain[..23], &[3], &plain[24..]].concat();
    assert!(pixels(&fewer).is_err());
}

/// Pictures of a ramp to the right, a ramp downward, and a chequer of 4×4 pixels.
#[test]
fn every_kind_of_jpeg_is_read() {
    for (name, bytes) in [
        (
            "cmyk",
            include_bytes!("../../../../tests/pictures/cmyk.jpg") as &[u8],
        ),
        (
            "ycck",
            include_bytes!("../../../../tests/pictures/ycck.jpg"),
        ),
        ("rgb", include_bytes!("../../../../tests/pictures/rgb.jpg")),
        (
            "scans",
            include_bytes!("../../../../tests/pictures/scans.jpg"),
        ),
        (
            "third",
            include_bytes!("../../../../tests/pictures/third.jpg"),
        ),
        (
            "fourth",
            include_bytes!("../../../../tests/pictures/fourth.jpg"),
        ),
        (
            "restarts",
            include_bytes!("../../../../tests/pictures/restarts.jpg"),
        ),
        (
            "fine chroma",
            include_bytes!("../../../../tests/pictures/fine_chroma.jpg"),
        ),
    ] {
        let texels = pixels(bytes).unwrap_or_else(|reason| panic!("{name}: {reason}"));
        let mut error = 0;
        for (i, &texel) in texels.iter().enumerate() {
            let (x, y) = (i % 21, i / 21);
            let painted = [
                x * 12,
                y * 19,
                if (x / 4 + y / 4) % 2 == 0 { 40 } else { 200 },
            ];
            error += (texel.iter().zip(painted))
                .map(|(&stored, painted)| stored.abs_diff(painted as u8) as usize)
                .sum::<usize>();
        }
        let mean = error as f64 / (21 * 13 * 3) as f64;
        assert!(mean < 20.0, "{name}: {mean}");
    }
    let cut = &HALVED[..HALVED.len() - 50];
    assert!(pixels(cut).is_err(), "not silently a part of it");
}

/// A TGA of 2×1 pixels, the left one first.
fn tga(kind: u8, depth: u8, flags: u8, data: &[u8]) -> Vec<u8> {
    let header = [
        0, 0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, depth, flags,
    ];
    [&header, data].concat()
}

#[test]
fn tga_is_read_by_its_header() {
    let decode = |bytes: &[u8]| {
        let image = EncodedImage::open(bytes).and_then(EncodedImage::decode);
        image.map(|image| (image.colors, image.alpha))
    };
    let two = vec![[3, 2, 1], [6, 5, 4]];
    let plain = tga(2, 24, 0, &[1, 2, 3, 4, 5, 6]);
    assert_eq!(decode(&plain), Ok((two.clone(), vec![])));
    let run = tga(10, 24, 0, &[0x81, 1, 2, 3]);
    assert_eq!(decode(&run), Ok((vec![[3, 2, 1]; 2], vec![])));
    let clear = tga(2, 32, 8, &[1, 2, 3, 0, 4, 5, 6, 9]);
    assert_eq!(decode(&clear), Ok((two.clone(), vec![0, 9])));
    let unused = tga(2, 32, 8, &[1, 2, 3, 0, 4, 5, 6, 0]);
    assert_eq!(decode(&unused), Ok((two, vec![])));
    let grey = tga(3, 8, 0, &[7, 8]);
    assert_eq!(decode(&grey), Ok((vec![[7; 3], [8; 3]], vec![])));
    let mut huge = plain.clone();
    huge[13] = 0x3f;
    assert!(decode(&huge).unwrap_err().contains("too short"));
    assert_eq!(decode(&plain[..20]).unwrap_err(), "it ends too early");
    for (field, value) in [(1, 2), (2, 4), (5, 1), (16, 12), (17, 0x80)] {
        let mut other = plain.clone();
        other[field] = value;
        assert!(
            decode(&other).unwrap_err().contains("not a picture"),
            "{field}"
        );
    }
}

#[test]
fn bmp_is_read_with_alpha_where_it_has_some() {
    let decode = |depth: u8, data: &[u8]| {
        let (mut bytes, start) = (b"BM".to_vec(), 14 + 40);
        bytes.extend(
            [0u32, 0, start, 40, 2, 1]
                .iter()
                .flat_map(|n| n.to_le_bytes()),
        );
        bytes.extend([1, 0, depth, 0]);
        bytes.resize(start as usize, 0);
        bytes.extend(data);
        let image = EncodedImage::open(&bytes).and_then(EncodedImage::decode);
        image.map(|image| (image.colors, image.alpha))
    };
    let two = vec![[3, 2, 1], [6, 5, 4]];
    let expected = Ok((two, vec![]));
    assert_eq!(decode(24, &[1, 2, 3, 4, 5, 6, 0, 0]), expected);
    assert_eq!(decode(32, &[1, 2, 3, 0, 4, 5, 6, 0]), expected);
    assert_eq!(decode(24, &[1, 2, 3]).unwrap_err(), "it ends too early");
}

#[test]
fn webp_is_read() {
    let lossless = include_bytes!("../../../../tests/pictures/lossless.webp");
    let image = EncodedImage::open(lossless).and_then(EncodedImage::decode);
    let image = image.expect("a picture");
    for (i, (&texel, &alpha)) in image.colors.iter().zip(&image.alpha).enumerate() {
        let (x, y) = (i % 21, i / 21);
        let blue = if (x / 4 + y / 4) % 2 == 0 { 40 } else { 200 };
        assert_eq!(texel, [x * 12, y * 19, blue].map(|c| c as u8), "{x} {y}");
        let expected = if x < 10 { 255 } else { x * 5 };
        assert_eq!(usize::from(alpha), expected, "{x} {y}");
    }
    let lossy = include_bytes!("../../../../tests/pictures/lossy.webp");
    let texels = pixels(lossy).expect("a picture");
    for (i, [red, green, _]) in texels.iter().enumerate() {
        assert!(red.abs_diff((i % 21 * 12) as u8) < 64, "{i}: {red}");
        assert!(green.abs_diff((i / 21 * 19) as u8) < 64, "{i}: {green}");
    }
    assert!(pixels(&lossy[..lossy.len() - 90]).is_err());
}

#[test]
fn pictures_of_other_kinds_are_named() {
    for (bytes, name) in [
        (
            b"GIF89a..." as &[u8],
            "a GIF picture, which is not read: convert it to PNG",
        ),
        (b"DDS |...", "a DDS picture"),
        (b"\xabKTX 20\xbb\r\n", "a KTX2 picture"),
        (b"II*\0....", "a TIFF picture"),
        (b"#?RADIANCE\n", "an HDR picture"),
        (b"\x76\x2f\x31\x01....", "an OpenEXR picture"),
        (b"\0\0\0\x20ftypavif", "an AVIF picture"),
        (b"", "it is empty"),
        (b"a text", "not a picture of a kind that is read"),
    ] {
        let refused = pixels(bytes).expect_err("not read");
        assert!(refused.contains(name), "{refused}");
    }
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
    let baseline = TABLES + (32 * 32 + 21 * 13) * 3;
    assert_eq!(EncodedImage::open(HALVED).map(|p| p.scratch), Ok(baseline));
    let progressive = EncodedImage::open(PROGRESSIVE).map(|p| p.scratch);
    assert_eq!(progressive, Ok(baseline + 32 * 32 * 3 * 2));
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

#[test]
fn a_jpeg_may_lack_the_marker_of_its_end_alone() {
    for picture in [HALVED, PROGRESSIVE, GREY] {
        let end = picture.len();
        for missing in [1, 2] {
            assert_eq!(
                pixels(&picture[..end - missing]),
                pixels(picture),
                "{missing}"
            );
        }
        for missing in [4, 12, 40, 100] {
            assert!(pixels(&picture[..end - missing]).is_err(), "{missing}");
        }
    }
}
