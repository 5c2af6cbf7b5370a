//! Portable float maps. Their rows run from bottom to top, and each is found by its position.

use super::super::format::ImageFormat;
use super::bytes::PictureBytes;
use super::layout::{OpenedPicture, PictureLayout, RowReader, SamplePlanes, check_sides};
use crate::decoders::TOO_SHORT;
use std::io::{Read, SeekFrom};
use std::ops::Range;

/// Maximum number of bytes of a header.
const MAX_HEADER: u64 = 256;

/// Reads the rows of a portable float map.
pub(super) struct PfmRows {
    bytes: PictureBytes,
    width: usize,
    height: u32,
    /// Position of the lowest row.
    start: u64,
    /// Samples of a pixel: one or three.
    samples: usize,
    big_endian: bool,
}

/// Reads the header of a portable float map: its kind, width, height and scale, whose sign gives
/// the byte order.
pub(super) fn open_pfm(bytes: PictureBytes) -> OpenedPicture {
    let mut head = Vec::new();
    let read = bytes.reader()?.take(MAX_HEADER).read_to_end(&mut head);
    read.map_err(|e| e.to_string())?;
    let mut offset = 0;
    let mut word = || {
        let space = |b: &u8| b.is_ascii_whitespace();
        let start = offset + head[offset..].iter().position(|b| !space(b))?;
        let end = start + head[start..].iter().position(space)?;
        offset = end;
        std::str::from_utf8(&head[start..end]).ok()
    };
    let fields = (word(), word(), word(), word());
    let (Some(kind), Some(width), Some(height), Some(scale)) = fields else {
        return Err("its header is broken: it has too few numbers".into());
    };
    let number = |text: &str| text.parse::<u64>().ok();
    let sides = number(width).zip(number(height));
    let (width, height) = sides.ok_or("its header is broken: its size is no number")?;
    let scale: f32 = scale.parse().unwrap_or(0.0);
    if scale == 0.0 || !scale.is_finite() {
        return Err("its header is broken: its scale is no number".into());
    }
    let (width, height) = check_sides(width, height)?;
    let mut rows = PfmRows {
        width: width as usize,
        height,
        // One character of white space ends the header.
        start: offset as u64 + 1,
        samples: if kind == "PF" { 3 } else { 1 },
        big_endian: scale > 0.0,
        bytes,
    };
    let samples = rows.row_bytes() as u64 * u64::from(height);
    let length = rows.bytes.len()?;
    if length < rows.start + samples {
        return Err(TOO_SHORT.into());
    }
    // Some end the line as on Windows, or have a space before its end.
    if let Some([b'\r' | b' ', b'\n']) = head.get(offset..offset + 2)
        && length > rows.start + samples
    {
        rows.start += 1;
    }
    let layout = PictureLayout::rgb(ImageFormat::Pfm, (width, height));
    Ok((layout, Box::new(rows)))
}

impl PfmRows {
    fn row_bytes(&self) -> usize {
        self.width * self.samples * size_of::<f32>()
    }
}

impl RowReader for PfmRows {
    fn read(&mut self, rows: Range<u32>, planes: &mut SamplePlanes) -> Result<(), String> {
        let mut reader = self.bytes.reader()?;
        let below = u64::from(self.height - rows.end);
        let start = self.start + below * self.row_bytes() as u64;
        reader
            .seek(SeekFrom::Start(start))
            .map_err(|e| e.to_string())?;
        let mut data = vec![0; self.row_bytes() * rows.len()];
        reader.read_exact(&mut data).map_err(|_| TOO_SHORT)?;
        for row in data.chunks_exact(self.row_bytes()).rev() {
            for (k, word) in row.as_chunks::<4>().0.iter().enumerate() {
                let bits = if self.big_endian {
                    u32::from_be_bytes(*word)
                } else {
                    u32::from_le_bytes(*word)
                };
                match self.samples {
                    1 => planes.iter_mut().for_each(|plane| plane.push(bits)),
                    samples => planes[k % samples].push(bits),
                }
            }
        }
        Ok(())
    }
}
