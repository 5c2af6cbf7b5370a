//! PNG, row by row; interlaced ones as a whole.

use super::super::format::ImageFormat;
use super::bytes::{PictureBytes, ReadSeek};
use super::layout::{
    PictureLayout, RowReader, SamplePlanes, TOO_SHORT, check_sides, check_whole, push_display,
};
use ::png::{BitDepth, ColorType, DecodingError, Transformations};
use std::io::ErrorKind;
use std::ops::Range;

type PngDecoder = ::png::Reader<Box<dyn ReadSeek>>;

/// Reads the rows of a PNG.
pub(super) struct PngRows {
    bytes: PictureBytes,
    decoder: PngDecoder,
    width: u32,
    height: u32,
    /// The row that comes next.
    next: u32,
    /// All bytes of an interlaced picture, once they are decoded.
    whole: Option<Vec<u8>>,
}

/// Reads the header of a PNG.
pub(super) fn open_png(bytes: PictureBytes) -> Result<(PictureLayout, PngRows), String> {
    let decoder = start(&bytes)?;
    let info = decoder.info();
    let (width, height) = check_sides(info.width.into(), info.height.into())?;
    let rows = PngRows {
        bytes,
        decoder,
        width,
        height,
        next: 0,
        whole: None,
    };
    Ok((PictureLayout::rgb(ImageFormat::Png, (width, height)), rows))
}

/// A decoder that has read all before the first row.
fn start(bytes: &PictureBytes) -> Result<PngDecoder, String> {
    let mut decoder = ::png::Decoder::new(bytes.reader()?);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    let reader = decoder.read_info().map_err(plain)?;
    let info = reader.info();
    let palette = info.palette.as_deref().unwrap_or_default();
    // Checked here, because the crate takes a palette's length to be right.
    let colors = (3..=3 * 256).contains(&palette.len()) && palette.len().is_multiple_of(3);
    match info.color_type != ColorType::Indexed || colors {
        true => Ok(reader),
        false => Err("its palette (PLTE) does not hold whole colours, 1 to 256".into()),
    }
}

impl PngRows {
    /// Samples of a pixel, and true if they have 16 bits.
    fn pixel(&self) -> (usize, bool) {
        let (color, depth) = self.decoder.output_color_type();
        (color.samples(), depth == BitDepth::Sixteen)
    }

    /// All bytes of an interlaced picture.
    fn decode_whole(&mut self) -> Result<Vec<u8>, String> {
        check_whole(self.width, self.height)?;
        let size = self.decoder.output_buffer_size();
        let mut bytes = vec![0; size.ok_or("it is too large")?];
        self.decoder.next_frame(&mut bytes).map_err(plain)?;
        Ok(bytes)
    }

    /// Decodes the next row. After the last one, the sums of the data are checked; an end that is
    /// missing is no objection.
    fn next_row(&mut self) -> Result<Vec<u8>, String> {
        let row = self.decoder.next_row().map_err(plain)?;
        let row = row.ok_or(TOO_SHORT)?.data().to_vec();
        self.next += 1;
        if self.next == self.height {
            match self.decoder.next_row() {
                Err(DecodingError::IoError(_)) | Ok(_) => {}
                Err(error) => return Err(plain(error)),
            }
        }
        Ok(row)
    }
}

impl RowReader for PngRows {
    fn read(&mut self, rows: Range<u32>, planes: &mut SamplePlanes) -> Result<(), String> {
        let (samples, wide) = self.pixel();
        if self.decoder.info().interlaced {
            let whole = match self.whole.take() {
                Some(whole) => whole,
                None => self.decode_whole()?,
            };
            let row = whole.len() / self.height as usize;
            let range = rows.start as usize * row..rows.end as usize * row;
            push_row(planes, &whole[range], samples, wide);
            self.whole = Some(whole);
            return Ok(());
        }
        if rows.start < self.next {
            self.decoder = start(&self.bytes)?;
            self.next = 0;
        }
        while self.next < rows.end {
            let wanted = self.next >= rows.start;
            let row = self.next_row()?;
            if wanted {
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
        match wide {
            true => {
                let words = encoded.as_chunks::<2>().0.iter();
                let words = words.map(|word| u16::from_be_bytes(*word));
                pixel.iter_mut().zip(words).for_each(|(s, word)| *s = word);
            }
            false => {
                let words = encoded.iter().map(|byte| u16::from(*byte) * 257);
                pixel.iter_mut().zip(words).for_each(|(s, word)| *s = word);
            }
        }
        push_display(planes, &pixel[..samples]);
    }
}

/// The crate's message in plain words.
fn plain(error: DecodingError) -> String {
    match error {
        DecodingError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => TOO_SHORT.into(),
        DecodingError::IoError(e) => e.to_string(),
        other => format!("it is broken: {other}"),
    }
}
