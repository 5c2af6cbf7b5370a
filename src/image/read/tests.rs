//! Tests of readers: the samples of every format, and broken files.

use super::super::bands::save_bands;
use super::super::description::{Crop, Depth, PictureFile};
use super::super::encoder::{Exposure, Picture, ToneCurve};
use super::super::error::PictureError;
use super::super::format::ImageFormat;
use super::super::png::save_png;
use super::super::test_film::{PLAIN_EXR, bits, film};
use super::raster::load;
use super::{PictureReader, SampleKind};
use phalanx_scene::OutputEncoding;
use phalanx_scene::film::{Aov, Aovs};
use std::fs;
use std::path::{Path, PathBuf};

fn ramp() -> Picture {
    let rgb = (0..7 * 5 * 3).map(|i| (i * 37 % 256) as u8).collect();
    Picture {
        width: 7,
        height: 5,
        rgb,
    }
}

#[test]
fn sixteen_bits_and_grey_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grey.png");
    let mut encoder = ::png::Encoder::new(fs::File::create(&path).unwrap(), 2, 1);
    encoder.set_depth(::png::BitDepth::Sixteen);
    let samples = [3u16, 40_000].map(u16::to_be_bytes);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(samples.as_flattened()).unwrap();
    writer.finish().unwrap();
    let expected = [[3, 3, 3, 65_535], [40_000, 40_000, 40_000, 65_535]];
    assert_eq!(load(&path).unwrap().pixels, expected);
}

#[test]
fn broken_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let complete = folder.path().join("whole.png");
    save_png(&complete, &ramp()).unwrap();
    let bytes = fs::read(&complete).unwrap();
    let path = folder.path().join("broken.png");
    let half = &bytes[..bytes.len() / 2];
    for (broken, reason) in [
        (&b""[..], "not a picture that can be read: it is empty"),
        (
            b"not a picture",
            "not a picture that can be read: it is none of",
        ),
        (
            half,
            "not a PNG picture that can be read: it ends too early",
        ),
    ] {
        fs::write(&path, broken).unwrap();
        let message = load(&path).unwrap_err().to_string();
        let reason = format!("broken.png: {reason}");
        assert!(message.contains(&reason), "{message}");
    }
    let missing = load(&folder.path().join("missing.png")).unwrap_err();
    assert!(matches!(missing, PictureError::Read { .. }));
    let folder_itself = load(folder.path()).unwrap_err();
    assert!(matches!(folder_itself, PictureError::Read { .. }));
}

#[test]
fn a_picture_too_large_is_refused_by_its_header() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.png");
    save_png(&path, &ramp()).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    // IHDR: width and height at 16 and 20, then its checksum at 29.
    bytes[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    let crc = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    fs::write(&path, bytes).unwrap();
    let message = load(&path).unwrap_err().to_string();
    assert!(message.contains("65536x65536"), "{message}");
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| {
            c >> 1 ^ (0xedb8_8320 & (c & 1).wrapping_neg())
        })
    })
}

/// Saves the film of the writers' tests, with layers where the format has them.
fn saved(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    let format = ImageFormat::of(&path).unwrap();
    let aovs = match format {
        ImageFormat::Exr => Aovs::NONE.with(Aov::Material).with(Aov::Ns),
        _ => Aovs::NONE,
    };
    let mut film = film().with_aovs(aovs);
    for (c, plane) in film.aov_planes.iter_mut().enumerate() {
        let numbered = plane.iter_mut().enumerate();
        numbered.for_each(|(k, sample)| *sample = f32::from_bits((k * (c + 1)) as u32));
    }
    let file = PictureFile {
        width: film.width,
        height: film.height,
        crop: None,
        format,
        aovs,
        origin: [0.0; 3],
        exposure: Exposure {
            stops: 0.0,
            curve: ToneCurve::Linear,
            encoding: OutputEncoding::SRGB,
        },
        depth: match format {
            ImageFormat::Exr => Depth::Standard,
            _ => Depth::Sixteen,
        },
        header: Default::default(),
    };
    save_bands(&path, &file, [Ok(film)]).unwrap();
    path
}

/// Rows may be requested in any order, and repeatedly.
#[test]
fn linear_formats_give_every_bit_from_any_row() {
    let folder = tempfile::tempdir().unwrap();
    let film = film();
    for name in ["a.exr", "a.pfm"] {
        let mut reader = PictureReader::open(&saved(folder.path(), name)).unwrap();
        let channels = reader.layout().channels.clone();
        let index = |name: &str| channels.iter().position(|c| c.name == name).unwrap();
        let rgb = ["R", "G", "B"].map(index);
        for rows in [0..1, 5..66, 66..67, 0..67, 63..65] {
            let planes = reader.read(rows.clone()).unwrap();
            for (k, y) in rows.enumerate() {
                for x in 0..70 {
                    let got = rgb.map(|c| planes[c][k * 70 + x as usize]);
                    assert_eq!(got, bits(&film, x, y), "{name} {x},{y}");
                }
            }
        }
        if name == "a.exr" {
            let material = index("material.id");
            assert_eq!(channels[material].kind, SampleKind::Integer);
            assert_eq!(channels.len(), 7);
            let planes = reader.read(0..67).unwrap();
            assert!(
                planes[material]
                    .iter()
                    .zip(0..)
                    .all(|(&got, k)| got == 4 * k)
            );
        }
        assert!(reader.read(60..68).is_err());
    }
}

#[test]
fn radiance_pictures_are_decoded_by_bands_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = saved(folder.path(), "a.hdr");
    let decoder =
        ::image::codecs::hdr::HdrDecoder::new(std::io::Cursor::new(fs::read(&path).unwrap()));
    let complete = ::image::DynamicImage::from_decoder(decoder.unwrap()).unwrap();
    let complete = complete.into_rgb32f();
    let mut reader = PictureReader::open(&path).unwrap();
    for rows in [3..67, 0..67, 66..67] {
        let planes = reader.read(rows.clone()).unwrap();
        for (k, y) in rows.enumerate() {
            for x in 0..70u32 {
                let want = complete.get_pixel(x, y).0.map(f32::to_bits);
                let got = [0, 1, 2].map(|c| planes[c][k * 70 + x as usize]);
                assert_eq!(got, want, "{x},{y}");
            }
        }
    }
}

/// All pixels of a coloured PNG file, decoded at once.
fn complete_png(path: &Path) -> Vec<[u16; 4]> {
    let mut decoder = ::png::Decoder::new(std::io::Cursor::new(fs::read(path).unwrap()));
    decoder.set_transformations(::png::Transformations::EXPAND | ::png::Transformations::ALPHA);
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(frame.color_type, ::png::ColorType::Rgba);
    let samples: Vec<u16> = match frame.bit_depth {
        ::png::BitDepth::Sixteen => {
            let pairs = bytes.as_chunks::<2>().0.iter();
            pairs.map(|&pair| u16::from_be_bytes(pair)).collect()
        }
        _ => bytes.iter().map(|&s| 257 * u16::from(s)).collect(),
    };
    samples.as_chunks::<4>().0.to_vec()
}

#[test]
fn pictures_for_a_screen_are_read_as_others_read_them() {
    let folder = tempfile::tempdir().unwrap();
    let png = saved(folder.path(), "a.png");
    assert_eq!(load(&png).unwrap().pixels, complete_png(&png));
    // Decoders of JPEG round differently.
    let jpeg = saved(folder.path(), "a.jpg");
    let complete = ::image::open(&jpeg).unwrap().into_rgba16();
    for (got, want) in load(&jpeg).unwrap().pixels.iter().zip(complete.pixels()) {
        let near = got
            .iter()
            .zip(want.0)
            .all(|(&s, t)| s.abs_diff(t) <= 3 * 257);
        assert!(near, "{got:?} {want:?}");
    }
    // Interlaced files are decoded as a whole; alpha and palettes become RGBA.
    let pictures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/pictures");
    let interlaced = pictures.join("interlaced.png");
    let want = complete_png(&interlaced);
    assert_eq!(load(&interlaced).unwrap().pixels, want);
    let exr = saved(folder.path(), "a.exr");
    let refused = load(&exr).unwrap_err().to_string();
    assert!(refused.contains("linear radiance"), "{refused}");
}

/// Reads all of a file. An error is as good as a picture; a panic is not.
fn read_whole(path: &Path) -> Result<(), PictureError> {
    let mut reader = PictureReader::open(path)?;
    let height = reader.layout().height;
    // Mutated headers may claim many rows; the first are enough.
    reader.read(0..height.min(256)).map(drop)
}

#[test]
fn broken_files_of_every_format_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken");
    let mut random = 1u64;
    for ending in ["png", "jpg", "exr", "hdr", "pfm"] {
        let complete = fs::read(saved(folder.path(), &format!("a.{ending}"))).unwrap();
        fs::write(&path, &complete).unwrap();
        read_whole(&path).unwrap();
        for k in 0..40 {
            fs::write(&path, &complete[..complete.len() * k / 41]).unwrap();
            // JPEG decoders fill in missing data.
            assert!(
                read_whole(&path).is_err() || ending == "jpg",
                "{ending} {k}"
            );
        }
        for k in 0..MUTANTS {
            let mut mutant = complete.clone();
            for _ in 0..1 + k % 4 {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                let header = (random >> 20).is_multiple_of(2);
                let length = if header { mutant.len().min(512) } else { mutant.len() };
                let index = (random >> 33) as usize % length;
                mutant[index] = match random >> 30 & 3 {
                    0 => 0,
                    1 => 255,
                    2 => mutant[index] ^ 1 << (random >> 25 & 7),
                    _ => (random >> 56) as u8,
                };
            }
            fs::write(&path, &mutant).unwrap();
            let _ = read_whole(&path);
        }
    }
}

/// Mutants of each format.
const MUTANTS: usize = 300;

#[test]
fn sizes_without_samples_are_refused_before_they_are_allocated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("claim");
    for (claim, reason) in [
        (&b"PF\n65536 65536\n-1.0\n"[..], "it ends too early"),
        (b"PF\n70000 2\n-1.0\n", "70000x2 is out of range"),
        (b"PF\n2 2\n0\n", "its scale is no number"),
        (b"PF\n2\n", "too few numbers"),
        (b"#?RADIANCE\n\n-Y 4000000000 +X 2\n", "out of range"),
        (b"#?RADIANCE\n\n-Y 2 +X 0\n", "out of range"),
        (b"\x76\x2f\x31\x01\x02\0\0\0\0", "not an OpenEXR picture"),
    ] {
        fs::write(&path, claim).unwrap();
        let message = read_whole(&path).unwrap_err().to_string();
        assert!(message.contains(reason), "{message}");
    }
}

/// A crop is the whole picture with nothing around it, at its place, in any rows.
#[test]
fn a_data_window_is_laid_into_its_display_window() {
    let folder = tempfile::tempdir().unwrap();
    let film = film();
    for corner in [(8, 6), (0, 0), (30, 33)] {
        let file = PictureFile {
            width: film.width,
            height: film.height,
            crop: Some(Crop {
                corner,
                of: (100, 100),
            }),
            ..PLAIN_EXR
        };
        let path = folder.path().join("a.exr");
        save_bands(&path, &file, [Ok(film.clone())]).unwrap();
        let mut reader = PictureReader::open(&path).unwrap();
        let layout = reader.layout().clone();
        assert_eq!(
            (layout.width, layout.height, layout.corner),
            (100, 100, (0, 0))
        );
        let red = layout.channels.iter().position(|c| c.name == "R").unwrap();
        for rows in [90..100, 0..50, 50..90] {
            let planes = reader.read(rows.clone()).unwrap();
            for (k, &sample) in planes[red].iter().enumerate() {
                let (x, y) = (k as u32 % 100, rows.start + k as u32 / 100);
                let place = x.checked_sub(corner.0).zip(y.checked_sub(corner.1));
                let place = place.filter(|place| place.0 < film.width && place.1 < film.height);
                let want = place.map_or(0, |(x, y)| bits(&film, x, y)[0]);
                assert_eq!(sample, want, "{x},{y} of {corner:?}");
            }
        }
    }
}

/// One row of eight pixels, each of radiance 1.
fn radiance(head: &str) -> Vec<u8> {
    let mut file = format!("{head}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n").into_bytes();
    file.extend([[128, 128, 128, 129]; 8].as_flattened());
    file
}

#[test]
fn radiance_is_what_it_was_before_its_exposure_and_correction() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    for (head, want) in [
        ("#?RADIANCE\n", [1.0; 3]),
        ("#?RGBE\n", [1.0; 3]),
        ("#?RADIANCE\nEXPOSURE=2\nEXPOSURE= 2.0\n", [0.25; 3]),
        (
            "#?RADIANCE\nCOLORCORR=2 1 0.5\nEXPOSURE=0.5\n",
            [1.0, 2.0, 4.0],
        ),
    ] {
        fs::write(&path, radiance(head)).unwrap();
        let planes = PictureReader::open(&path).unwrap().read(0..1).unwrap();
        let got = [0, 1, 2].map(|c| f32::from_bits(planes[c][7]));
        assert_eq!(got, want, "{head}");
    }
    fs::write(&path, radiance("#?RADIANCE\nEXPOSURE=0\n")).unwrap();
    let message = PictureReader::open(&path).err().unwrap().to_string();
    assert!(message.contains("no number above 0"), "{message}");
}

#[test]
fn the_rows_of_a_float_map_begin_where_its_length_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pfm");
    for head in [
        "PF\n2 1\n-1.0\n",
        "PF\r\n2 1\r\n-1.0\r\n",
        "PF\n2 1\n-1.0 \n",
    ] {
        let samples: Vec<u8> = (1..=6u32).flat_map(|k| (k as f32).to_le_bytes()).collect();
        fs::write(&path, [head.as_bytes(), &samples].concat()).unwrap();
        let planes = PictureReader::open(&path).unwrap().read(0..1).unwrap();
        let red = [0, 1].map(|x| f32::from_bits(planes[0][x]));
        assert_eq!(red, [1.0, 4.0], "{head:?}");
    }
    // A first sample that looks like white space, and a byte behind the last.
    let samples = [[b' ', 0, 0, 0x3f]; 6];
    fs::write(
        &path,
        [b"PF\n2 1\n-1.0\n", samples.as_flattened(), b"\n"].concat(),
    )
    .unwrap();
    let planes = PictureReader::open(&path).unwrap().read(0..1).unwrap();
    assert_eq!(planes[0][1], u32::from_le_bytes(samples[1]));
}
