//! TGA, BMP and WebP, decoded at once by the crate `image`.

use super::pixels::{
    DecodedImage, EncodedImage, PictureDecoder, PixelLayout, TABLES, checked_sides, too_short,
};
use image::codecs::{bmp::BmpDecoder, tga::TgaDecoder, webp::WebPDecoder};
use image::{ImageDecoder, ImageError};
use phalanx_image::decoders::io_reason;
use std::error::Error;
use std::io::Cursor;

/// A decoder that has read the header.
struct WholeImageDecoder<'a> {
    decoder: Box<dyn ImageDecoder + 'a>,
    format: &'static str,
}

/// Name of a format in which a few bytes can encode a picture of one colour and any size.
const WEBP: &str = "WebP";
/// Longest run of pixels that a BMP or a TGA has in a byte.
const MAX_RUN: u64 = 128;

/// Reads the header of a BMP.
pub(super) fn open_bmp(bytes: &[u8]) -> Result<EncodedImage<'_>, String> {
    let decoder = BmpDecoder::new(Cursor::new(bytes)).map_err(|e| plain(e, "BMP"))?;
    opened(Box::new(decoder), "BMP", Some(bytes.len()), 4)
}

/// Reads the header of a TGA.
pub(super) fn open_tga(bytes: &[u8]) -> Result<EncodedImage<'_>, String> {
    let decoder = TgaDecoder::new(Cursor::new(bytes)).map_err(|e| plain(e, "TGA"))?;
    opened(Box::new(decoder), "TGA", Some(bytes.len()), 4)
}

/// Reads the header of a WebP. Its decoder keeps a frame of four bytes per pixel, and tables of a
/// sixteenth of a frame each.
pub(super) fn open_webp(bytes: &[u8]) -> Result<EncodedImage<'_>, String> {
    let decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(|e| plain(e, WEBP))?;
    if decoder.has_animation() {
        return Err("it is an animated WebP picture, which is not read: convert it to PNG".into());
    }
    opened(Box::new(decoder), WEBP, None, 6)
}

/// The picture of a decoder that keeps some bytes per pixel. A file of known length backs its size
/// by that.
fn opened<'a>(
    decoder: Box<dyn ImageDecoder + 'a>,
    format: &'static str,
    length: Option<usize>,
    bytes_per_pixel: u64,
) -> Result<EncodedImage<'a>, String> {
    let (width, height) = decoder.dimensions();
    let (width, height) = checked_sides(width.into(), height.into())?;
    let pixels = u64::from(width) * u64::from(height);
    if length.is_some_and(|length| pixels > length as u64 * MAX_RUN) {
        return Err(too_short(width, height));
    }
    Ok(EncodedImage {
        width,
        height,
        scratch: TABLES + decoder.total_bytes() + pixels * bytes_per_pixel,
        decoder: Box::new(WholeImageDecoder { decoder, format }),
    })
}

impl WholeImageDecoder<'_> {
    /// Layout of the decoder's output.
    fn layout(&self) -> PixelLayout {
        PixelLayout {
            samples: self.decoder.color_type().channel_count().into(),
            wide: false,
        }
    }
}

impl PictureDecoder for WholeImageDecoder<'_> {
    fn has_alpha(&self) -> bool {
        self.layout().has_alpha()
    }

    fn decode(self: Box<Self>, _: [usize; 2], image: &mut DecodedImage) -> Result<(), String> {
        let (layout, format) = (self.layout(), self.format);
        let mut bytes = Vec::new();
        let size = self.decoder.total_bytes() as usize;
        let room = bytes.try_reserve_exact(size);
        room.map_err(|_| "there is no memory for it")?;
        bytes.resize(size, 0);
        self.decoder
            .read_image_boxed(&mut bytes)
            .map_err(|e| plain(e, format))?;
        image.reserve(bytes.len() / layout.samples)?;
        layout.each(&bytes, |color, alpha| image.push(color, alpha));
        // Programs without alpha in a TGA or BMP write zeros there.
        if format != WEBP && image.alpha.iter().all(|&alpha| alpha == 0) {
            image.alpha = Vec::new();
        }
        Ok(())
    }
}

/// Returns true for the header of a TGA, which has no magic number: its fields have few values, and
/// those that describe a palette are 0 without one.
pub(super) fn is_tga(bytes: &[u8]) -> bool {
    let Some(header) = bytes.first_chunk::<18>() else {
        return false;
    };
    let [palette, kind, depth, flags] = [1, 2, 16, 17].map(|offset| header[offset]);
    let mapped = kind & 7 == 1;
    let palette_is_right = match palette {
        0 => !mapped && header[5..8] == [0; 3],
        1 => [15, 16, 24, 32].contains(&header[7]),
        _ => false,
    };
    let depths: &[u8] = if mapped { &[8, 16] } else { &[8, 15, 16, 24, 32] };
    let sides = [12, 14].map(|offset| u16::from_le_bytes([header[offset], header[offset + 1]]));
    palette_is_right
        && [1, 2, 3, 9, 10, 11].contains(&kind)
        && depths.contains(&depth)
        && !sides.contains(&0)
        && flags & 0xc0 == 0
}

/// The crate's message in plain words.
fn plain(error: ImageError, format: &str) -> String {
    match error {
        ImageError::IoError(e) => io_reason(&e),
        ImageError::Unsupported(_) => {
            format!("it is a {format} picture of a kind that is not read: convert it to PNG")
        }
        // Reasons for a WebP are numbers in brackets.
        ImageError::Decoding(e) if format != WEBP => match e.source() {
            Some(reason) => format!("it is broken: {reason}"),
            None => BROKEN.into(),
        },
        _ => BROKEN.into(),
    }
}

const BROKEN: &str = "it is broken";
