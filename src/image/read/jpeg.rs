//! JPEG, decoded as a whole.

use super::super::format::ImageFormat;
use super::bytes::PictureBytes;
use super::layout::{
    OpenedPicture, PictureLayout, RowReader, SamplePlanes, check_sides, check_whole, push_display,
};
use crate::decoders::{TOO_SHORT, jpeg};
use std::io::Read;
use std::ops::Range;

/// Maximum number of bytes of a file. The largest picture that is decoded takes a fifth of them.
const MAX_BYTES: u64 = 1 << 30;

/// Returns the rows of a decoded picture.
pub(super) struct JpegRows {
    width: usize,
    /// Samples of a pixel: one or three.
    samples: usize,
    decoded: Vec<u8>,
}

/// Decodes a JPEG.
pub(super) fn open_jpeg(bytes: PictureBytes) -> OpenedPicture {
    if bytes.len()? > MAX_BYTES {
        return Err("it has more than 1 GiB".into());
    }
    let mut file = Vec::new();
    let mut reader = bytes.reader()?.take(MAX_BYTES);
    reader.read_to_end(&mut file).map_err(|e| e.to_string())?;
    let (decoder, info) = jpeg::open(&file, check_sides)?;
    let (width, height) = (u32::from(info.width), u32::from(info.height));
    check_whole(width, height)?;
    let (decoded, samples) = jpeg::decode(decoder)?;
    let rows = JpegRows {
        width: info.width.into(),
        samples,
        decoded,
    };
    let layout = PictureLayout::rgb(ImageFormat::Jpeg, (width, height));
    Ok((layout, Box::new(rows)))
}

impl RowReader for JpegRows {
    fn read(&mut self, rows: Range<u32>, planes: &mut SamplePlanes) -> Result<(), String> {
        let row = self.width * self.samples;
        let range = rows.start as usize * row..rows.end as usize * row;
        let samples = self.decoded.get(range).ok_or(TOO_SHORT)?;
        for pixel in samples.chunks_exact(self.samples) {
            match *pixel {
                [r, g, b] => push_display(planes, &[r, g, b].map(|s| u16::from(s) * 257)),
                ref grey => push_display(planes, &[u16::from(grey[0]) * 257]),
            }
        }
        Ok(())
    }
}
