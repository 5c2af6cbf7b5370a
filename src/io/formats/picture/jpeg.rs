//! JPEG, decoded at once. The decoder's SIMD is not built: its plain integer code gives the same
//! bytes everywhere.

use super::pixels::{DecodedImage, ImageHeader, TABLES, checked_sides, too_short};
use jpeg_decoder::{CodingProcess, Error, PixelFormat};
use std::io::{Chain, ErrorKind, Read};

/// A decoder that has read the header.
pub(super) type JpegDecoder<'a> = jpeg_decoder::Decoder<Chain<&'a [u8], &'static [u8]>>;

/// Bytes behind those of a file, which may lack the marker of its end: bits that no code begins
/// with, so that a picture of which more is missing fails, and the marker.
const END: &[u8] = b"\xff\x00\xff\x00\xff\x00\xff\x00\xff\x00\xff\x00\xff\x00\xff\x00\xff\xd9";

/// Marker of the start of a scan.
const SCAN: &[u8] = b"\xff\xda";

/// Bound on the pixels per byte of a JPEG, which spends at least a bit on the mean of 8×8 pixels.
const MAX_PIXELS_PER_BYTE: u64 = 8 * 64;
/// Bound on the scans of a picture, each of which may touch all of it for a few bytes. Encoders
/// make ten.
const MAX_SCANS: usize = 256;

/// Reads the header of a JPEG.
pub(super) fn open(bytes: &[u8]) -> Result<ImageHeader<JpegDecoder<'_>>, String> {
    let mut decoder =
        jpeg_decoder::Decoder::new(bytes.strip_suffix(b"\xff").unwrap_or(bytes).chain(END));
    decoder.read_info().map_err(plain)?;
    let info = decoder.info().ok_or("it has no size")?;
    let (width, height) = checked_sides(info.width.into(), info.height.into())?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels > bytes.len() as u64 * MAX_PIXELS_PER_BYTE {
        return Err(too_short(width, height));
    }
    if memchr::memmem::find_iter(bytes, SCAN)
        .nth(MAX_SCANS)
        .is_some()
    {
        return Err(format!("it has more than {MAX_SCANS} scans"));
    }
    let components = info.pixel_format.pixel_bytes() as u64;
    // Planes of whole blocks, and all coefficients of a progressive picture, of two bytes each.
    let blocks = u64::from(width.next_multiple_of(32)) * u64::from(height.next_multiple_of(32));
    let kept = match info.coding_process {
        CodingProcess::DctProgressive => 3,
        CodingProcess::DctSequential | CodingProcess::Lossless => 1,
    };
    Ok(ImageHeader {
        width,
        height,
        scratch: TABLES + blocks * components * kept + pixels * components,
        decoder,
    })
}

/// Decodes a picture.
pub(super) fn decode(mut decoder: JpegDecoder, image: &mut DecodedImage) -> Result<(), String> {
    let bytes = decoder.decode().map_err(plain)?;
    let format = decoder.info().map(|info| info.pixel_format);
    image.reserve(bytes.len() / format.map_or(1, |format| format.pixel_bytes()))?;
    match format {
        Some(PixelFormat::L8) => bytes.iter().for_each(|&grey| image.push([grey; 3], 255)),
        Some(PixelFormat::RGB24) => {
            let (pixels, _) = bytes.as_chunks();
            pixels.iter().for_each(|&rgb| image.push(rgb, 255));
        }
        Some(PixelFormat::CMYK32) => {
            let (pixels, _) = bytes.as_chunks();
            pixels
                .iter()
                .for_each(|&cmyk| image.push(of_inks(cmyk), 255));
        }
        Some(PixelFormat::L16) | None => return Err(UNREAD.into()),
    }
    Ok(())
}

/// Colour of four inks, of which each takes its share of what the others leave.
fn of_inks([cyan, magenta, yellow, black]: [u8; 4]) -> [u8; 3] {
    let left = |ink| u32::from(255 - ink);
    [cyan, magenta, yellow].map(|ink| ((left(ink) * left(black) + 127) / 255) as u8)
}

const UNREAD: &str = "it is a JPEG of a kind that is not read (lossless, arithmetically coded or of \
                      more than 8 bits): convert it to PNG";

/// The crate's message in plain words.
fn plain(error: Error) -> String {
    match error {
        Error::Unsupported(_) => UNREAD.into(),
        Error::Io(e) if e.kind() == ErrorKind::UnexpectedEof => "it ends too early".into(),
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
