//! Radiance RGBE, decoded by bands: as the decoder reads whole files, each band gets a header of
//! its own.

use super::super::format::ImageFormat;
use super::bytes::{PictureBytes, ReadSeek};
use super::layout::{OpenedPicture, PictureLayout, RowReader, SamplePlanes, check_sides};
use crate::decoders::io_reason;
use ::image::codecs::hdr::HdrDecoder;
use ::image::{ImageDecoder, ImageError};
use std::io::{BufRead, Cursor, Read};
use std::ops::Range;

/// Maximum number of bytes of a header.
const MAX_HEADER: u64 = 1 << 16;
/// Maximum number of bytes of a header's first line.
const MAX_MAGIC: u64 = 32;
/// Rows that are decoded at once.
const BAND: u32 = 64;

/// Reads the rows of a Radiance RGBE file.
pub(super) struct HdrRows {
    bytes: PictureBytes,
    reader: Box<dyn ReadSeek>,
    width: u32,
    /// The row that comes next.
    next: u32,
    /// Factors of red, green and blue that restore the original radiance.
    scale: [f32; 3],
}

/// Reads the header of a Radiance RGBE file.
pub(super) fn open_hdr(bytes: PictureBytes) -> OpenedPicture {
    let mut reader = bytes.reader()?;
    let ((width, height), scale) = skip_header(&mut *reader)?;
    let (width, height) = check_sides(width.into(), height.into())?;
    let rows = HdrRows {
        bytes,
        reader,
        width,
        next: 0,
        scale,
    };
    let layout = PictureLayout::rgb(ImageFormat::Hdr, (width, height));
    Ok((layout, Box::new(rows)))
}

/// Reads a header, after which the first row begins: width and height, and the factors that pixels
/// must be multiplied by. `EXPOSURE` and `COLORCORR` are factors that have been applied, once for
/// each occurrence ("Radiance File Formats", G. Ward).
fn skip_header(reader: &mut dyn ReadSeek) -> Result<((u32, u32), [f32; 3]), String> {
    // The decoder accepts only one of the two magic words.
    let mut magic = Vec::new();
    let line = reader.take(MAX_MAGIC).read_until(b'\n', &mut magic);
    line.map_err(|e| e.to_string())?;
    let file = Cursor::new(b"#?RADIANCE\n").chain(reader);
    let decoder = HdrDecoder::new(file.take(MAX_HEADER)).map_err(plain)?;
    let head = decoder.metadata();
    let exposure = head.exposure.unwrap_or(1.0);
    let scale = <[f32; 3]>::from(head.color_correction.unwrap_or((1.0, 1.0, 1.0)));
    let scale = scale.map(|factor| 1.0 / (factor * exposure));
    if scale.iter().all(|scale| scale.is_finite() && *scale > 0.0) {
        Ok((decoder.dimensions(), scale))
    } else {
        Err("its EXPOSURE or COLORCORR is no number above 0".into())
    }
}

impl HdrRows {
    /// The next rows, three floats per pixel.
    fn band(&mut self, rows: u32) -> Result<Vec<[u32; 3]>, String> {
        let header = format!(
            "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {rows} +X {}\n",
            self.width
        );
        let file = header.as_bytes().chain(&mut self.reader);
        let decoder = HdrDecoder::new(file).map_err(plain)?;
        let mut pixels = vec![[0f32; 3]; rows as usize * self.width as usize];
        decoder
            .read_image(bytemuck::cast_slice_mut(&mut pixels))
            .map_err(plain)?;
        self.next += rows;
        let scaled =
            |pixel: [f32; 3]| std::array::from_fn(|c| (pixel[c] * self.scale[c]).to_bits());
        Ok(pixels.into_iter().map(scaled).collect())
    }
}

impl RowReader for HdrRows {
    fn read(&mut self, rows: Range<u32>, planes: &mut SamplePlanes) -> Result<(), String> {
        if rows.start < self.next {
            self.reader = self.bytes.reader()?;
            skip_header(&mut *self.reader)?;
            self.next = 0;
        }
        while self.next < rows.end {
            let needed = self.next >= rows.start;
            let end = if needed { rows.end } else { rows.start };
            let band = self.band(BAND.min(end - self.next))?;
            if needed {
                for (c, plane) in planes.iter_mut().enumerate() {
                    plane.extend(band.iter().map(|pixel| pixel[c]));
                }
            }
        }
        Ok(())
    }
}

/// The crate's message in plain words.
fn plain(error: ImageError) -> String {
    match error {
        ImageError::IoError(e) => io_reason(&e),
        ImageError::Unsupported(_) => {
            "its rows or pixels are in another order or encoding than -Y +X and rgbe: save it anew"
                .into()
        }
        other => format!("it is broken: {other}"),
    }
}
