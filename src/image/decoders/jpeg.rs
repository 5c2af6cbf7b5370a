//! JPEG, decoded at once. The decoder is built without SIMD: its plain integer code gives the same
//! samples everywhere.

use super::{CheckSides, TOO_SHORT};
use jpeg_decoder::{Decoder, Error, ImageInfo, PixelFormat};
use std::io::{Chain, ErrorKind, Read};

/// A decoder that has read the header.
pub type JpegDecoder<'a> = Decoder<Chain<&'a [u8], &'static [u8]>>;

/// Bytes appended to those of a file, which may lack its end marker: bits that no code begins with,
/// so that a picture with more missing fails, and the marker.
const END: &[u8] = b"\xff\x00\xff\x00\xff\x00\xff\x00\xff\x00\xff\x00\xff\x00\xff\x00\xff\xd9";

/// Marker of the start of a scan.
const SCAN: &[u8] = b"\xff\xda";

/// Bound on the pixels per byte of a JPEG, which spends at least a bit on the mean of 8×8 pixels.
const MAX_PIXELS_PER_BYTE: u64 = 8 * 64;
/// Bound on the scans of a picture, each of which may touch all of it for a few bytes. Encoders
/// write ten.
const MAX_SCANS: usize = 256;

const UNREAD: &str = "it is a JPEG of a kind that is not read (lossless, arithmetically coded or of \
                      more than 8 bits): convert it to PNG";

/// Reads the header of a JPEG.
pub fn open(bytes: &[u8], check: CheckSides) -> Result<(JpegDecoder<'_>, ImageInfo), String> {
    let mut decoder = Decoder::new(bytes.strip_suffix(b"\xff").unwrap_or(bytes).chain(END));
    decoder.read_info().map_err(plain)?;
    let info = decoder.info().ok_or("it has no size")?;
    let (width, height) = check(info.width.into(), info.height.into())?;
    if u64::from(width) * u64::from(height) > bytes.len() as u64 * MAX_PIXELS_PER_BYTE {
        return Err(format!("it is too short for its {width}×{height} pixels"));
    }
    let mut scans = memchr::memmem::find_iter(bytes, SCAN);
    if scans.nth(MAX_SCANS).is_some() {
        return Err(format!("it has more than {MAX_SCANS} scans"));
    }
    Ok((decoder, info))
}

/// Decodes a picture to samples of 8 bits, and returns their number per pixel: 1 for a grey
/// picture, 3 for colour. Inks become red, green and blue.
pub fn decode(mut decoder: JpegDecoder) -> Result<(Vec<u8>, usize), String> {
    let mut samples = decoder.decode().map_err(plain)?;
    match decoder.info().map(|info| info.pixel_format) {
        Some(PixelFormat::L8) => Ok((samples, 1)),
        Some(PixelFormat::RGB24) => Ok((samples, 3)),
        Some(PixelFormat::CMYK32) => {
            let pixels = samples.len() / 4;
            for k in 0..pixels {
                let inks = [0, 1, 2, 3].map(|ink| samples[4 * k + ink]);
                samples[3 * k..3 * k + 3].copy_from_slice(&of_inks(inks));
            }
            samples.truncate(3 * pixels);
            Ok((samples, 3))
        }
        Some(PixelFormat::L16) | None => Err(UNREAD.into()),
    }
}

/// Colour of four inks, each of which absorbs its share of the light left by the others.
fn of_inks([cyan, magenta, yellow, black]: [u8; 4]) -> [u8; 3] {
    let left = |ink| u32::from(255 - ink);
    [cyan, magenta, yellow].map(|ink| ((left(ink) * left(black) + 127) / 255) as u8)
}

/// The crate's message in plain words.
fn plain(error: Error) -> String {
    match error {
        Error::Unsupported(_) => UNREAD.into(),
        Error::Io(e) if e.kind() == ErrorKind::UnexpectedEof => TOO_SHORT.into(),
        other => {
            let reason = other.to_string();
            match reason.trim_start_matches("invalid JPEG format: ") {
                // The bits of [`END`] are no code.
                "failed to decode huffman code" => "it ends too early, or is broken".into(),
                reason => format!("it is broken: {reason}"),
            }
        }
    }
}
