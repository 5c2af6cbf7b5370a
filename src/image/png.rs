//! PNG files, for output.

use super::description::{BAND_ROWS, Depth, PictureFile};
use super::encoder::Picture;
use super::error::PictureError;
use super::zlib_strips::{StripStream, ZlibStrip};
use ::png::{
    BitDepth, ColorType, DeflateCompression, Encoder, EncodingError, Filter, ScaledFloat,
    SrgbRenderingIntent, chunk,
};
use phalanx_files::replace_file;
use phalanx_scene::film::Aov;
use phalanx_scene::{Transfer, map_on_pool};
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

/// Saves a picture as an 8-bit RGB PNG: whole, or not at all (see [`replace_file`]).
///
/// The bytes depend only on the picture: compression and filters are fixed, the compressor
/// (fdeflate) is plain integer code, and the checksums' SIMD variants differ only in speed. The
/// compressor takes a tenth of the time of the usual one, whose files are 10 to 22 % smaller
/// (`perf/notes/whole-frames.md`).
///
/// # Errors
/// [`PictureError::Write`].
pub fn save_png(path: &Path, picture: &Picture) -> Result<(), PictureError> {
    let written = replace_file(path, |out| write_picture(out, picture));
    written.map_err(PictureError::write(path))
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

fn write_picture(out: &mut dyn Write, picture: &Picture) -> io::Result<()> {
    let Picture { width, height, rgb } = picture;
    let pitch = 3 * *width as usize;
    let samples = |rows: Range<usize>| {
        let samples = rgb.get(rows.start * pitch..rows.end * pitch);
        // Too few samples are an error of the encoder.
        samples.unwrap_or_default().to_vec()
    };
    let rows: PngBand = (*height as usize, Box::new(samples));
    write_png(out, (*width, *height), None, &mut [Ok(rows)].into_iter())
}

/// Rows of a strip: bands end between two strips, so that these depend on the picture alone.
const STRIP_ROWS: usize = BAND_ROWS as usize;

/// The height of a band, and a function that encodes a range of its rows.
pub(super) type PngBand<'a> = (usize, Box<dyn Fn(Range<usize>) -> Vec<u8> + Sync + 'a>);

/// Writes the bands of a picture as they arrive: all threads encode, filter and compress strips of
/// the band, which are written in order. Without a description, samples are RGB of 8 bits, and the
/// file has no texts.
pub(super) fn write_png(
    out: &mut dyn Write,
    (width, height): (u32, u32),
    file: Option<&PictureFile>,
    bands: &mut dyn Iterator<Item = io::Result<PngBand>>,
) -> io::Result<()> {
    let write = || {
        let mut encoder = encoder(out, (width, height), file);
        if let Some(file) = file {
            describe(&mut encoder, file)?;
        }
        let (mut writer, mut stream) = (encoder.write_header()?, StripStream::START);
        for band in bands {
            let (height, samples) = band?;
            let strip = |k: usize| {
                let rows = k * STRIP_ROWS..height.min((k + 1) * STRIP_ROWS);
                compress((width, rows.len() as u32), file, &samples(rows))
            };
            for strip in map_on_pool(0..height.div_ceil(STRIP_ROWS), strip) {
                writer.write_chunk(chunk::IDAT, &stream.push(&strip?))?;
            }
        }
        writer.write_chunk(chunk::IDAT, &stream.end())?;
        writer.finish()
    };
    write().map_err(|error| match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    })
}

/// An encoder of this many columns and rows.
fn encoder<'a>(
    out: &'a mut dyn Write,
    (width, rows): (u32, u32),
    file: Option<&PictureFile>,
) -> Encoder<'static, &'a mut dyn Write> {
    let mut encoder = Encoder::new(out, width, rows);
    encoder.set_color(if file.is_some_and(|file| file.aovs.has(Aov::Alpha)) {
        ColorType::Rgba
    } else {
        ColorType::Rgb
    });
    encoder.set_depth(match file.map(|file| file.depth) {
        Some(Depth::Sixteen) => BitDepth::Sixteen,
        _ => BitDepth::Eight,
    });
    encoder
}

/// Compresses samples of this many columns and rows as a picture of their own, of which the first
/// row has a filter that does not need the row above.
fn compress(
    size: (u32, u32),
    file: Option<&PictureFile>,
    samples: &[u8],
) -> Result<ZlibStrip, EncodingError> {
    let rows = size.1 as usize;
    let (first, others) = samples.split_at(samples.len() / rows);
    let mut png = Vec::new();
    let mut encoder = encoder(&mut png, size, file);
    encoder.set_deflate_compression(DeflateCompression::FdeflateUltraFast);
    encoder.set_filter(Filter::Sub);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer_with_size(STRIP_CHUNK)?;
    stream.write_all(first)?;
    stream.set_filter(Filter::Paeth);
    stream.write_all(others)?;
    stream.finish()?;
    writer.finish()?;
    Ok(ZlibStrip::of_stream(
        &image_data(&png),
        samples.len() + rows,
    ))
}

/// Bytes of a chunk of a strip's own picture.
const STRIP_CHUNK: usize = 1 << 16;

/// The contents of all IDAT chunks of a file.
fn image_data(png: &[u8]) -> Vec<u8> {
    let (mut data, mut rest) = (Vec::with_capacity(png.len()), &png[8..]);
    while let Some((length, chunk)) = rest.split_first_chunk() {
        let end = 4 + u32::from_be_bytes(*length) as usize;
        if chunk.starts_with(&chunk::IDAT.0) {
            data.extend_from_slice(&chunk[4..end]);
        }
        rest = &chunk[end + 4..];
    }
    data
}

/// 1/2.2 in units of 1/100000, PNG's value for the sRGB curve.
const SRGB_GAMMA: u32 = 45_455;

/// 1 in units of 1/100000.
const LINEAR_GAMMA: u32 = 100_000;

/// Adds the chunks that describe the meaning of samples, and the texts. sRGB is accompanied by
/// gAMA, for programs that only support that.
fn describe<W: Write>(encoder: &mut Encoder<W>, file: &PictureFile) -> Result<(), EncodingError> {
    let gamma = match file.exposure.encoding.transfer {
        Transfer::Srgb => {
            encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
            SRGB_GAMMA
        }
        Transfer::None => LINEAR_GAMMA,
    };
    encoder.set_source_gamma(ScaledFloat::from_scaled(gamma));
    for (keyword, text) in file.header.texts() {
        if text.is_ascii() {
            encoder.add_text_chunk(keyword.to_owned(), text)?
        } else {
            encoder.add_itxt_chunk(keyword.to_owned(), text)?
        }
    }
    Ok(())
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
    use ::png::Decoder;
    use phalanx_scene::film::Aovs;
    use phalanx_scene::{OutputEncoding, Quantize};
    use std::fs;
    use std::io::Cursor;

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
            let band: PngBand = (5, Box::new(|_| ramp().rgb));
            write_png(&mut bytes, (7, 5), Some(&file), &mut [Ok(band)].into_iter()).unwrap();
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

    /// The samples of a file, once all of its checksums have been checked.
    fn decoded(png: &[u8]) -> Vec<u8> {
        let mut decoder = Decoder::new(Cursor::new(png));
        decoder.ignore_checksums(false);
        let mut reader = decoder.read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut samples).unwrap();
        reader.finish().unwrap();
        samples
    }

    /// Samples of several kinds: black, white, ramps, noise, and noise of few values.
    fn contents(count: usize) -> [Vec<u8>; 5] {
        let noise = |k: usize| (k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as u8;
        let all = |sample: &dyn Fn(usize) -> u8| (0..count).map(sample).collect();
        [
            all(&|_| 0),
            all(&|_| 255),
            all(&|k| (k / 5) as u8),
            all(&noise),
            all(&|k| noise(k) & 3),
        ]
    }

    #[test]
    fn strips_are_one_picture() {
        let sizes = (1..20).map(|k| (k, 20 - k as usize));
        let sizes = sizes.chain([63, 64, 65, 200].map(|height| (3, height)));
        for (width, height) in sizes.chain([(700, 129)]) {
            for (aovs, depth, bytes) in [
                (Aovs::NONE, Depth::Standard, 3),
                (Aovs::NONE.with(Aov::Alpha), Depth::Standard, 4),
                (Aovs::NONE, Depth::Sixteen, 6),
                (Aovs::NONE.with(Aov::Alpha), Depth::Sixteen, 8),
            ] {
                let pitch = width as usize * bytes;
                let file = PictureFile {
                    aovs,
                    depth,
                    ..PLAIN_EXR
                };
                for samples in contents(pitch * height) {
                    let mut png = Vec::new();
                    let rows =
                        |rows: Range<usize>| samples[rows.start * pitch..rows.end * pitch].to_vec();
                    let band: PngBand = (height, Box::new(rows));
                    let bands = &mut [Ok(band)].into_iter();
                    write_png(&mut png, (width, height as u32), Some(&file), bands).unwrap();
                    assert!(
                        decoded(&png) == samples,
                        "{width}x{height} {aovs:?} {depth:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_picture_of_too_few_samples_is_an_error() {
        let mut short = ramp();
        short.rgb.pop();
        assert!(png_bytes(&short).is_empty());
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

    const PIN: u64 = 8_605_428_200_904_913_427;
}
