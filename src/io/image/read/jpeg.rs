//! JPEG, decoded as a whole. The decoder has no SIMD, so that every machine gets the same samples.

use super::super::format::ImageFormat;
use super::bytes::PictureBytes;
use super::layout::{
    PictureLayout, RowReader, SamplePlanes, TOO_SHORT, check_sides, check_whole, push_display,
};
use jpeg_decoder::{Error, PixelFormat};
use std::io::{ErrorKind, Read};
use std::ops::Range;

/// Most bytes of a file. The largest picture that is decoded takes a fifth of them.
const MAX_BYTES: u64 = 1 << 30;
/// Bound on the pixels per byte, of which a JPEG spends at least a bit on the mean of 8x8 pixels.
const MAX_PIXELS_PER_BYTE: u64 = 8 * 64;
/// Marker of the start of a scan.
const SCAN: &[u8] = b"\xff\xda";
/// Bound on the scans of a picture, each of which may touch all of it for a few bytes.
const MAX_SCANS: usize = 256;

/// Gives the rows of a decoded picture.
pub(super) struct JpegRows {
    width: usize,
    /// Samples of a pixel: one or three.
    samples: usize,
    decoded: Vec<u8>,
}

/// Decodes a JPEG.
pub(super) fn open_jpeg(bytes: PictureBytes) -> Result<(PictureLayout, JpegRows), String> {
    if bytes.len()? > MAX_BYTES {
        return Err("it has more than 1 GiB".into());
    }
    let mut file = Vec::new();
    let mut reader = bytes.reader()?.take(MAX_BYTES);
    reader.read_to_end(&mut file).map_err(|e| e.to_string())?;
    let mut decoder = jpeg_decoder::Decoder::new(&file[..]);
    decoder.read_info().map_err(plain)?;
    let info = decoder.info().ok_or("it has no size")?;
    let (width, height) = check_sides(info.width.into(), info.height.into())?;
    check_whole(width, height)?;
    if u64::from(width) * u64::from(height) > file.len() as u64 * MAX_PIXELS_PER_BYTE {
        return Err(TOO_SHORT.into());
    }
    if memchr::memmem::find_iter(&file, SCAN)
        .nth(MAX_SCANS)
        .is_some()
    {
        return Err(format!("it has more than {MAX_SCANS} scans"));
    }
    let samples = match info.pixel_format {
        PixelFormat::L8 => 1,
        PixelFormat::RGB24 => 3,
        PixelFormat::L16 | PixelFormat::CMYK32 => return Err(UNREAD.into()),
    };
    let decoded = decoder.decode().map_err(plain)?;
    let rows = JpegRows {
        width: width.try_into().unwrap_or(usize::MAX),
        samples,
        decoded,
    };
    Ok((PictureLayout::rgb(ImageFormat::Jpeg, (width, height)), rows))
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

const UNREAD: &str = "it is a JPEG of a kind that is not compared (inks, lossless, arithmetically \
                      coded or of more than 8 bits): convert it to PNG";

/// The crate's message in plain words.
fn plain(error: Error) -> String {
    match error {
        Error::Unsupported(_) => UNREAD.into(),
        Error::Io(e) if e.kind() == ErrorKind::UnexpectedEof => TOO_SHORT.into(),
        other => format!("it is broken: {other}"),
    }
}
