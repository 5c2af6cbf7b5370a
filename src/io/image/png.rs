//! PNG files, for output.

use super::encoder::Picture;
use super::error::PictureError;
use super::file::replace_file;
use ::png::{BitDepth, ColorType, DeflateCompression, EncodingError, Filter};
use std::io::{self, Write};
use std::path::Path;

/// Saves a picture as an 8-bit RGB PNG: whole, or not at all (see [`replace_file`]).
///
/// The bytes depend on the picture alone: compression and filter are fixed, the compressor
/// (fdeflate) is plain integer code, and the checksums' SIMD variants differ in speed only. The
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
    write_png(out, *width, *height, [Ok(rgb.clone())].into_iter())
}

/// Writes samples as they come, in chunks of whole rows.
pub(super) fn write_png(
    out: &mut dyn io::Write,
    width: u32,
    height: u32,
    bands: impl Iterator<Item = io::Result<Vec<u8>>>,
) -> io::Result<()> {
    write_samples(out, (width, height), BitDepth::Eight, bands)
}

/// Writes like [`write_png`], with 16 bits a sample.
pub(super) fn write_png_16(
    out: &mut dyn io::Write,
    width: u32,
    height: u32,
    bands: impl Iterator<Item = io::Result<Vec<u16>>>,
) -> io::Result<()> {
    let bytes = bands.map(|band| Ok(band?.iter().flat_map(|s| s.to_be_bytes()).collect()));
    write_samples(out, (width, height), BitDepth::Sixteen, bytes)
}

/// Bytes of a chunk of the file.
const CHUNK: usize = 1 << 20;

fn write_samples(
    out: &mut dyn io::Write,
    (width, height): (u32, u32),
    depth: BitDepth,
    bands: impl Iterator<Item = io::Result<Vec<u8>>>,
) -> io::Result<()> {
    let mut encoder = ::png::Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(depth);
    encoder.set_deflate_compression(DeflateCompression::FdeflateUltraFast);
    encoder.set_filter(Filter::Paeth);
    let mut writer = encoder.write_header().map_err(png_error)?;
    let mut rows = writer.stream_writer_with_size(CHUNK).map_err(png_error)?;
    for band in bands {
        rows.write_all(&band?)?;
    }
    rows.finish().map_err(png_error)?;
    writer.finish().map_err(png_error)
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
    use super::*;
    use std::fs;

    fn ramp() -> Picture {
        let rgb = (0..7 * 5 * 3).map(|i| (i * 37 % 256) as u8).collect();
        Picture {
            width: 7,
            height: 5,
            rgb,
        }
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

    /// The contract "same bytes on every build", held by a checksum (FNV-1a) of a whole file.
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
