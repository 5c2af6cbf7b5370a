//! PNG and JPEG pictures to sRGB bytes. The size is known before anything is decoded, and rows are
//! decoded one by one into their final memory.

use phalanx_scene::MAX_TEXTURE_SIDE;
use png::{BitDepth, Transformations};
use std::io::Cursor;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// A picture of which the header has been read.
pub(super) struct EncodedImage<'a> {
    /// Pixels in a row, 1 to [`MAX_TEXTURE_SIDE`].
    pub(super) width: u32,
    /// Rows, 1 to [`MAX_TEXTURE_SIDE`].
    pub(super) height: u32,
    /// Bytes that decoding takes beyond the pixels.
    pub(super) scratch: u64,
    decoder: Decoder<'a>,
}

enum Decoder<'a> {
    Png(Box<png::Reader<Cursor<&'a [u8]>>>),
    Jpeg(Box<JpegDecoder<ZCursor<&'a [u8]>>>),
}

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG: &[u8] = b"\xff\xd8\xff";

/// Bound on the pixels per byte of a PNG: more than deflate can make of a byte (1032). A picture's
/// size is trusted only as far as its bytes allow.
const MAX_PNG_RATIO: u64 = 1040;
/// Bound on the pixels per byte of a JPEG, which spends at least a bit on the mean of 8×8 pixels.
const MAX_JPEG_PIXELS_PER_BYTE: u64 = 8 * 64;
/// Bytes of a decoder's tables and rows.
const TABLES: u64 = 1 << 20;

impl<'a> EncodedImage<'a> {
    /// Reads the header of a picture. The format does not depend on the file's name.
    pub(super) fn open(bytes: &'a [u8]) -> Result<EncodedImage<'a>, String> {
        if bytes.starts_with(PNG) {
            open_png(bytes)
        } else if bytes.starts_with(JPEG) {
            open_jpeg(bytes)
        } else {
            Err("it is neither a PNG nor a JPEG picture".into())
        }
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Bytes that alpha takes, unless all pixels turn out to be whole.
    pub(super) fn alpha_bytes(&self) -> u64 {
        match &self.decoder {
            Decoder::Png(reader) if PixelLayout::of(reader).has_alpha() => self.pixels(),
            Decoder::Png(_) | Decoder::Jpeg(_) => 0,
        }
    }

    /// All pixels, the uppermost row first. Grey becomes equal components, 16 bits become the
    /// nearest 8, and colour profiles are ignored.
    pub(super) fn decode(self) -> Result<DecodedImage, String> {
        let (width, height) = (self.width as usize, self.height as usize);
        let mut image = DecodedImage::with_room_for(width * height)?;
        match self.decoder {
            Decoder::Png(reader) if reader.info().interlaced => {
                decode_interlaced(*reader, width, height, &mut image)?;
            }
            Decoder::Png(mut reader) => {
                let layout = PixelLayout::of(&reader);
                while let Some(row) = reader.next_row().map_err(|e| e.to_string())? {
                    layout.each(row.data(), |color, alpha| image.push(color, alpha));
                }
            }
            Decoder::Jpeg(mut decoder) => {
                image.colors.resize(width * height, [0; 3]);
                let decoded = decoder.decode_into(image.colors.as_flattened_mut());
                decoded.map_err(|e| e.to_string())?;
            }
        }
        match image.colors.len() == width * height {
            true => Ok(image),
            false => Err("it decodes to another size than it claims".into()),
        }
    }
}

/// The pixels of a picture.
pub(super) struct DecodedImage {
    /// sRGB bytes.
    pub(super) colors: Vec<[u8; 3]>,
    /// Share of each pixel that is there, in 255ths; empty if all are whole.
    pub(super) alpha: Vec<u8>,
}

impl DecodedImage {
    fn with_room_for(pixels: usize) -> Result<DecodedImage, String> {
        let mut colors = Vec::new();
        let room = colors.try_reserve_exact(pixels);
        room.map_err(|_| "there is no memory for it")?;
        Ok(DecodedImage {
            colors,
            alpha: Vec::new(),
        })
    }

    #[inline]
    fn push(&mut self, color: [u8; 3], alpha: u8) {
        self.colors.push(color);
        self.set_alpha(self.colors.len() - 1, alpha);
    }

    /// Alpha takes memory from the first pixel on that is not whole.
    #[inline]
    fn set_alpha(&mut self, pixel: usize, alpha: u8) {
        if alpha != 255 && self.alpha.is_empty() {
            self.alpha = vec![255; self.colors.capacity()];
        }
        if let Some(there) = self.alpha.get_mut(pixel) {
            *there = alpha;
        }
    }
}

fn open_png(bytes: &[u8]) -> Result<EncodedImage<'_>, String> {
    let broken = |error: png::DecodingError| error.to_string();
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(broken)?;
    let (width, height) = checked_sides(header.width.into(), header.height.into())?;
    let row_bits = u64::from(width) * header.bits_per_pixel() as u64;
    if row_bits.div_ceil(8) * u64::from(height) > bytes.len() as u64 * MAX_PNG_RATIO {
        return Err(short(width, height));
    }
    let reader = decoder.read_info().map_err(broken)?;
    // Checked here, because the crate takes a palette's length to be right.
    let (info, indexed) = (reader.info(), png::ColorType::Indexed);
    let palette = info.palette.as_deref().unwrap_or_default();
    if info.color_type == indexed && !is_palette(palette) {
        return Err("its palette (PLTE) does not hold whole colours, 1 to 256".into());
    }
    Ok(EncodedImage {
        width,
        height,
        scratch: TABLES,
        decoder: Decoder::Png(Box::new(reader)),
    })
}

/// Returns true if these are 1 to 256 colours of three bytes each.
fn is_palette(bytes: &[u8]) -> bool {
    (3..=3 * 256).contains(&bytes.len()) && bytes.len().is_multiple_of(3)
}

/// Start and step of the pixels of a PNG's passes: columns, then rows.
const ADAM7_PASSES: [[usize; 4]; 7] = [
    [0, 8, 0, 8],
    [4, 8, 0, 8],
    [0, 4, 4, 8],
    [2, 4, 0, 4],
    [0, 2, 2, 4],
    [1, 2, 0, 2],
    [0, 1, 1, 2],
];

fn decode_interlaced(
    mut reader: png::Reader<Cursor<&[u8]>>,
    width: usize,
    height: usize,
    image: &mut DecodedImage,
) -> Result<(), String> {
    let layout = PixelLayout::of(&reader);
    for [left, across, top, down] in ADAM7_PASSES {
        if left >= width {
            continue;
        }
        for y in (top..height).step_by(down) {
            let row = reader.next_interlaced_row().map_err(|e| e.to_string())?;
            let row = row.ok_or("it has too few rows")?;
            // Memory is touched as far as rows have come.
            if image.colors.len() < (y + 1) * width {
                image.colors.resize((y + 1) * width, [0; 3]);
            }
            let mut targets = (y * width + left..(y + 1) * width).step_by(across);
            layout.each(row.data(), |color, alpha| {
                if let Some(target) = targets.next() {
                    image.colors[target] = color;
                    image.set_alpha(target, alpha);
                }
            });
        }
    }
    image.colors.resize(width * height, [0; 3]);
    Ok(())
}

/// Layout of a pixel in the decoder's output.
#[derive(Clone, Copy)]
struct PixelLayout {
    samples: usize,
    wide: bool,
}

impl PixelLayout {
    fn of(reader: &png::Reader<Cursor<&[u8]>>) -> PixelLayout {
        let (color, depth) = reader.output_color_type();
        PixelLayout {
            samples: color.samples(),
            wide: depth == BitDepth::Sixteen,
        }
    }

    fn has_alpha(self) -> bool {
        self.samples == 2 || self.samples == 4
    }

    /// Calls a function with the colour and alpha of each pixel of a row.
    fn each(self, row: &[u8], then: impl FnMut([u8; 3], u8)) {
        match self.wide {
            false => self.each_with::<1>(row, |[byte]| byte, then),
            // The nearest 8-bit value: 65535 is 255 · 257.
            true => {
                let nearest = |bytes| ((u32::from(u16::from_be_bytes(bytes)) + 128) / 257) as u8;
                self.each_with::<2>(row, nearest, then);
            }
        }
    }

    fn each_with<const BYTES: usize>(
        self,
        row: &[u8],
        byte: impl Fn([u8; BYTES]) -> u8,
        mut then: impl FnMut([u8; 3], u8),
    ) {
        let (samples, _) = row.as_chunks::<BYTES>();
        let pixels = samples.chunks_exact(self.samples);
        match self.samples {
            1 => pixels.for_each(|p| then([byte(p[0]); 3], 255)),
            2 => pixels.for_each(|p| then([byte(p[0]); 3], byte(p[1]))),
            3 => pixels.for_each(|p| then([0, 1, 2].map(|k| byte(p[k])), 255)),
            _ => pixels.for_each(|p| then([0, 1, 2].map(|k| byte(p[k])), byte(p[3]))),
        }
    }
}

/// Opens a JPEG. The decoder's SIMD variants are neither built nor used: its plain integer code
/// gives the same bytes everywhere.
fn open_jpeg(bytes: &[u8]) -> Result<EncodedImage<'_>, String> {
    let broken = |error: zune_jpeg::errors::DecodeErrors| error.to_string();
    let options = DecoderOptions::new_safe()
        .set_strict_mode(false)
        .set_max_width(MAX_TEXTURE_SIDE as usize)
        .set_max_height(MAX_TEXTURE_SIDE as usize)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let (width, height) = decoder.dimensions().ok_or("it has no size")?;
    let (width, height) = checked_sides(width as u64, height as u64)?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels > bytes.len() as u64 * MAX_JPEG_PIXELS_PER_BYTE {
        return Err(short(width, height));
    }
    // A picture of several scans keeps all coefficients, and so does a progressive one of any
    // number of scans: two bytes each, in whole blocks.
    let info = decoder.info();
    let progressive = info.as_ref().is_none_or(|info| info.sof.is_progressive());
    let components = info.map_or(4, |info| u64::from(info.components));
    let blocks = u64::from(width.next_multiple_of(32)) * u64::from(height.next_multiple_of(32));
    let kept = match progressive || scans(bytes) > 1 {
        true => blocks * components * 2,
        false => 0,
    };
    Ok(EncodedImage {
        width,
        height,
        scratch: TABLES + kept,
        decoder: Decoder::Jpeg(Box::new(decoder)),
    })
}

/// Number of scans, including those of a thumbnail.
fn scans(bytes: &[u8]) -> usize {
    memchr::memmem::find_iter(bytes, b"\xff\xda")
        .take(2)
        .count()
}

fn checked_sides(width: u64, height: u64) -> Result<(u32, u32), String> {
    let side = 1..=u64::from(MAX_TEXTURE_SIDE);
    match side.contains(&width) && side.contains(&height) {
        true => Ok((width as u32, height as u32)),
        false => Err(format!(
            "its size is {width}×{height}, but a side may have 1 to {MAX_TEXTURE_SIDE} texels"
        )),
    }
}

fn short(width: u32, height: u32) -> String {
    format!("it is too short for its {width}×{height} texels")
}

#[cfg(test)]
#[path = "picture_tests.rs"]
pub(super) mod tests;
