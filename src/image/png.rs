//! PNG files, for output.

use super::description::{Depth, PictureFile};
use super::encoder::Picture;
use super::error::PictureError;
use ::png::{
    BitDepth, ColorType, DeflateCompression, EncodingError, Filter, ScaledFloat,
    SrgbRenderingIntent,
};
use phalanx_files::replace_file;
use phalanx_scene::Transfer;
use phalanx_scene::film::Aov;
use std::io::{self, Write};
use std::path::Path;

/// Saves a picture as an 8-bit RGB PNG: whole, or not at all (see [`replace_file`]).
///
/// The bytes depend only on the picture: compression and filter are fixed, the compressor
/// (fdeflate) is plain integer code, and the checksums' SIMD variants differ only in speed. The
/// compressor takes a tenth of the time of the usual one, whose files are 10 to 22 % smaller
/// (`perf/notes/whole-frames.md`).
///
/// # Errors
/// [`PictureError::Write`].
pub fn save_png(path: &Path, picture: &Picture) -> Result<(), PictureError> {
    let written = replace_file(path, |out| write_picture(out, picture));
    written.map_err(|source| PictureError::Write {
        path: path.to_path_buf(),
        source,
    })
}

/// A picture as the bytes of a PNG file.
pub fn png_bytes(picture: &Picture) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Writing to memory does not fail; if it did, there would be no picture.
    match write_picture(&mut bytes, picture) {
        Ok(()) => bytes,
        Err(_) => Vec::new(),
    }
}

fn write_picture(out: &mut dyn io::Write, picture: &Picture) -> io::Result<()> {
    let Picture { width, height, rgb } = picture;
    let samples = [Ok(rgb.clone())].into_iter();
    write_png(out, (*width, *height), None, samples)
}

/// Bytes of a chunk of the file.
const CHUNK: usize = 1 << 20;

/// Writes the samples of a picture as they arrive, in chunks of whole rows. Without a description,
/// they are RGB of 8 bits, and the file has no texts.
pub(super) fn write_png(
    out: &mut dyn io::Write,
    (width, height): (u32, u32),
    file: Option<&PictureFile>,
    bands: impl Iterator<Item = io::Result<Vec<u8>>>,
) -> io::Result<()> {
    let mut encoder = ::png::Encoder::new(out, width, height);
    encoder.set_color(match file.is_some_and(|file| file.aovs.has(Aov::Alpha)) {
        true => ColorType::Rgba,
        false => ColorType::Rgb,
    });
    encoder.set_depth(match file.map(|file| file.depth) {
        Some(Depth::Sixteen) => BitDepth::Sixteen,
        _ => BitDepth::Eight,
    });
    encoder.set_deflate_compression(DeflateCompression::FdeflateUltraFast);
    encoder.set_filter(Filter::Paeth);
    if let Some(file) = file {
        describe(&mut encoder, file).map_err(png_error)?;
    }
    let mut writer = encoder.write_header().map_err(png_error)?;
    let mut rows = writer.stream_writer_with_size(CHUNK).map_err(png_error)?;
    for band in bands {
        rows.write_all(&band?)?;
    }
    rows.finish().map_err(png_error)?;
    writer.finish().map_err(png_error)
}

/// 1/2.2 in units of 1/100000, PNG's value for the sRGB curve.
const SRGB_GAMMA: u32 = 45_455;

/// 1 in units of 1/100000.
const LINEAR_GAMMA: u32 = 100_000;

/// Adds the chunks that describe the meaning of samples, and the texts. sRGB is accompanied by
/// gAMA, for programs that only support that.
fn describe<W: io::Write>(
    encoder: &mut ::png::Encoder<W>,
    file: &PictureFile,
) -> Result<(), EncodingError> {
    let gamma = match file.exposure.encoding.transfer {
        Transfer::Srgb => {
            encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
            SRGB_GAMMA
        }
        Transfer::None => LINEAR_GAMMA,
    };
    encoder.set_source_gamma(ScaledFloat::from_scaled(gamma));
    for (keyword, text) in file.header.texts() {
        match text.is_ascii() {
            true => encoder.add_text_chunk(keyword.to_owned(), text)?,
            false => encoder.add_itxt_chunk(keyword.to_owned(), text)?,
        }
    }
    Ok(())
}

fn png_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// The I/O error of an error in encoding a picture.
pub(super) fn io_error(error: ::image::ImageError) -> io::Error {
    match error {
        ::image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::super::read::load;
    use super::super::test_film::PLAIN_EXR;
    use super::*;
    use crate::PictureHeader;
    use phalanx_scene::{OutputEncoding, Quantize};
    use std::fs;

    fn ramp() -> Picture {
        let rgb = (0..7 * 5 * 3).map(|i| (i * 37 % 256) as u8).collect();
        Picture {
            width: 7,
            height: 5,
            rgb,
        }
    }

    /// The chunks of a file before its samples: their types and contents.
    fn chunks(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
        let mut rest = &bytes[b"\x89PNG\r\n\x1a\n".len()..];
        let mut all = Vec::new();
        loop {
            let length = u32::from_be_bytes(*rest.first_chunk().unwrap()) as usize;
            let kind = String::from_utf8(rest[4..8].to_vec()).unwrap();
            if kind == "IDAT" {
                return all;
            }
            all.push((kind, rest[8..8 + length].to_vec()));
            rest = &rest[12 + length..];
        }
    }

    #[test]
    fn the_file_tells_its_curve_and_its_texts() {
        let header = PictureHeader {
            scene: "ä.test".to_owned(),
            command: "phalanx render x\u{0}".to_owned(),
            ..PictureHeader::NONE
        };
        let version = concat!("Software\0phalanx ", env!("CARGO_PKG_VERSION"));
        for (transfer, gamma, srgb) in [
            (Transfer::None, 100_000u32, None),
            (Transfer::Srgb, 45_455, Some(vec![1u8])),
        ] {
            let quantize = Quantize::Floor;
            let file = PictureFile {
                exposure: OutputEncoding { transfer, quantize }.into(),
                header: header.clone(),
                ..PLAIN_EXR
            };
            let mut bytes = Vec::new();
            write_png(
                &mut bytes,
                (7, 5),
                Some(&file),
                [Ok(ramp().rgb)].into_iter(),
            )
            .unwrap();
            let chunks = chunks(&bytes);
            let all = |kind: &str| -> Vec<&[u8]> {
                let those = chunks.iter().filter(|(other, _)| other == kind);
                those.map(|(_, content)| &content[..]).collect()
            };
            assert_eq!(all("gAMA"), [gamma.to_be_bytes()]);
            assert_eq!(all("sRGB").first().map(|intent| intent.to_vec()), srgb);
            let texts = [version.as_bytes(), b"Comment\0phalanx render x"];
            assert_eq!(all("tEXt"), texts);
            assert_eq!(all("iTXt"), ["Title\0\0\0\0\0ä.test".as_bytes()]);
        }
        assert_eq!(chunks(&png_bytes(&ramp())).len(), 1, "IHDR alone");
    }

    #[test]
    fn what_is_saved_is_what_is_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ramp.png");
        save_png(&path, &ramp()).unwrap();
        let raster = load(&path).unwrap();
        assert_eq!((raster.width, raster.height), (7, 5));
        let wide = |p: &[u8]| [p[0], p[1], p[2], 255].map(|s| u16::from(s) * 257);
        let expected: Vec<_> = ramp().rgb.chunks_exact(3).map(wide).collect();
        assert_eq!(raster.pixels, expected);
    }

    /// The contract "same bytes on every build", checked by a checksum (FNV-1a) of a whole file.
    #[test]
    fn the_bytes_of_a_file_are_pinned() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ramp.png");
        save_png(&path, &ramp()).unwrap();
        let hash = fs::read(&path)
            .unwrap()
            .iter()
            .fold(0xcbf2_9ce4_8422_2325_u64, |h, &b| {
                (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
            });
        assert_eq!(hash, PIN);
    }

    const PIN: u64 = 17_519_977_720_008_669_062;
}
