//! PNG, row by row; interlaced ones as a whole.

use super::super::format::ImageFormat;
use super::bytes::{PictureBytes, ReadSeek};
use super::layout::{
    OpenedPicture, PictureLayout, RowReader, SamplePlanes, check_sides, check_whole, push_display,
};
use crate::decoders::TOO_SHORT;
use crate::decoders::png::{finish, open, plain};
use ::png::BitDepth;
use std::ops::Range;

type PngDecoder = ::png::Reader<Box<dyn ReadSeek>>;

/// Reads the rows of a PNG.
pub(super) struct PngRows {
    bytes: PictureBytes,
    decoder: PngDecoder,
    /// The row that comes next.
    next: u32,
    /// All bytes of an interlaced picture, once they are decoded.
    decoded: Option<Vec<u8>>,
}

/// Reads the header of a PNG.
pub(super) fn open_png(bytes: PictureBytes) -> OpenedPicture {
    let decoder = open(bytes.reader()?, check_sides)?;
    let (width, height) = decoder.info().size();
    let rows = PngRows {
        bytes,
        decoder,
        next: 0,
        decoded: None,
    };
    let layout = PictureLayout::rgb(ImageFormat::Png, (width, height));
    Ok((layout, Box::new(rows)))
}

impl PngRows {
    /// Samples of a pixel, and true if they have 16 bits.
    fn pixel(&self) -> (usize, bool) {
        let (color, depth) = self.decoder.output_color_type();
        (color.samples(), depth == BitDepth::Sixteen)
    }

    /// All bytes of an interlaced picture.
    fn decode_whole(&mut self) -> Result<Vec<u8>, String> {
        let (width, height) = self.decoder.info().size();
        check_whole(width, height)?;
        let size = self.decoder.output_buffer_size();
        let mut bytes = vec![0; size.ok_or("it is too large")?];
        self.decoder.next_frame(&mut bytes).map_err(plain)?;
        Ok(bytes)
    }

    /// Decodes the next row. After the last one, the checksums of the data are checked; a missing
    /// end is accepted.
    fn next_row(&mut self) -> Result<Vec<u8>, String> {
        let row = self.decoder.next_row().map_err(plain)?;
        let row = row.ok_or(TOO_SHORT)?.data().to_vec();
        self.next += 1;
        if self.next == self.decoder.info().height {
            finish(&mut self.decoder)?;
        }
        Ok(row)
    }
}

impl RowReader for PngRows {
    fn read(&mut self, rows: Range<u32>, planes: &mut SamplePlanes) -> Result<(), String> {
        let (samples, wide) = self.pixel();
        if self.decoder.info().interlaced {
            let image = match self.decoded.take() {
                Some(image) => image,
                None => self.decode_whole()?,
            };
            let row = image.len() / self.decoder.info().height as usize;
            let range = rows.start as usize * row..rows.end as usize * row;
            push_row(planes, &image[range], samples, wide);
            self.decoded = Some(image);
            return Ok(());
        }
        if rows.start < self.next {
            self.decoder = open(self.bytes.reader()?, check_sides)?;
            self.next = 0;
        }
        while self.next < rows.end {
            let needed = self.next >= rows.start;
            let row = self.next_row()?;
            if needed {
                push_row(planes, &row, samples, wide);
            }
        }
        Ok(())
    }
}

fn push_row(planes: &mut SamplePlanes, row: &[u8], samples: usize, wide: bool) {
    let mut pixel = [0; 4];
    let bytes = samples * if wide { 2 } else { 1 };
    for encoded in row.chunks_exact(bytes) {
        if wide {
            let words = encoded.as_chunks::<2>().0.iter();
            let words = words.map(|word| u16::from_be_bytes(*word));
            pixel.iter_mut().zip(words).for_each(|(s, word)| *s = word);
        } else {
            let words = encoded.iter().map(|byte| u16::from(*byte) * 257);
            pixel.iter_mut().zip(words).for_each(|(s, word)| *s = word);
        }
        push_display(planes, &pixel[..samples]);
    }
}
