//! PNG files, in and out.

use super::encoder::Picture;
use super::file::replace_file;
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use ::png::{BitDepth, ColorType, DeflateCompression, EncodingError, Filter};
use phalanx_scene::shown_path;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// The reason why a picture could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file could not be written; a regular file that was there is still there.
    #[error("cannot write {}: {source}", shown_path(path))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file could not be read.
    #[error("cannot read {}: {source}", shown_path(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is no PNG, or a broken one, or one too large.
    #[error("{}: not a PNG picture that can be read: {reason}", shown_path(path))]
    Decode {
        /// The file.
        path: PathBuf,
        /// The decoder's message.
        reason: String,
    },
}

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

/// A picture in the form in which it is compared: RGBA, 16 bits a sample. An 8-bit sample s becomes
/// 257 s, and missing alpha becomes opaque.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Pixels, row by row from the top left.
    pub pixels: Vec<[u16; 4]>,
}

/// Reads a PNG of 8 or 16 bits a sample (grey, colour, palette, with alpha or without).
///
/// # Errors
/// [`PictureError::Read`] and [`PictureError::Decode`].
pub fn load(path: &Path) -> Result<Raster, PictureError> {
    let unreadable = |source| PictureError::Read {
        path: path.to_path_buf(),
        source,
    };
    let broken = |reason: String| PictureError::Decode {
        path: path.to_path_buf(),
        reason,
    };
    let bytes = read(path).map_err(unreadable)?;
    check_palette(&bytes).map_err(broken)?;
    let mut reader = ImageReader::with_format(io::Cursor::new(&bytes), ImageFormat::Png);
    reader.limits(limits());
    let decoder = reader.into_decoder().map_err(|e| broken(e.to_string()))?;
    let (width, height) = decoder.dimensions();
    // Checked before anything is allocated by that size.
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(broken(format!(
            "{width}x{height} pixels are more than {MAX_PIXELS}"
        )));
    }
    let picture = DynamicImage::from_decoder(decoder).map_err(|e| broken(e.to_string()))?;
    let pixels = picture.into_rgba16().pixels().map(|p| p.0).collect();
    Ok(Raster {
        width,
        height,
        pixels,
    })
}

/// The bytes of a file, read only as long as it may be a PNG. A device that never ends is not read
/// beyond its first bytes.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let mut bytes = Vec::new();
    (&mut file)
        .take(SIGNATURE.len() as u64)
        .read_to_end(&mut bytes)?;
    if bytes == SIGNATURE {
        file.take(MAX_BYTES).read_to_end(&mut bytes)?;
    }
    Ok(bytes)
}

/// First bytes of every PNG.
const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Bound on the bytes of a file: more than the largest picture takes, even where nothing can be
/// compressed.
const MAX_BYTES: u64 = MAX_PIXELS * 9;

/// Refuses a palette that is not whole colours, 1 to 256: the decoder takes its length to be right.
/// The decoder reports all other faults.
fn check_palette(bytes: &[u8]) -> Result<(), String> {
    let mut decoder = ::png::Decoder::new(io::Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let reader = decoder.read_info().ok();
    let info = reader.as_ref().map(|reader| reader.info());
    let indexed = info.filter(|info| info.color_type == ColorType::Indexed);
    let bytes = indexed.map_or(3, |info| info.palette.as_ref().map_or(0, |p| p.len()));
    match (3..=3 * 256).contains(&bytes) && bytes.is_multiple_of(3) {
        true => Ok(()),
        false => Err("its palette (PLTE) does not hold whole colours, 1 to 256".into()),
    }
}

/// Most pixels of a picture that is read: all of it is held in memory.
const MAX_PIXELS: u64 = 1 << 28;

/// Limits that leave memory for the largest picture, RGBA of 16 bits.
fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 8);
    limits
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn sixteen_bits_and_grey_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grey.png");
        let grey =
            ::image::ImageBuffer::<::image::Luma<u16>, _>::from_raw(2, 1, vec![3u16, 40_000]);
        grey.unwrap().save(&path).unwrap();
        let expected = [[3, 3, 3, 65_535], [40_000, 40_000, 40_000, 65_535]];
        assert_eq!(load(&path).unwrap().pixels, expected);
    }

    #[test]
    fn broken_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let whole = folder.path().join("whole.png");
        save_png(&whole, &ramp()).unwrap();
        let bytes = fs::read(&whole).unwrap();
        let path = folder.path().join("broken.png");
        for broken in [&b""[..], b"not a picture", &bytes[..bytes.len() / 2]] {
            fs::write(&path, broken).unwrap();
            let message = load(&path).unwrap_err().to_string();
            assert!(
                message.contains("broken.png: not a PNG picture"),
                "{message}"
            );
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
}
