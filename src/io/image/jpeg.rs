//! JPEG files, for output only.

use super::encoder::Picture;
use super::png::io_error;
use ::image::codecs::jpeg::JpegEncoder;
use ::image::{GenericImageView, Rgb};
use std::cell::RefCell;
use std::io;

/// Quality, out of 100: differences can be measured, but hardly seen.
const QUALITY: u8 = 95;

/// Writes pictures of whole blocks of eight rows, one below the other, as they come.
pub(super) fn write_jpeg(
    out: &mut dyn io::Write,
    width: u32,
    height: u32,
    bands: impl Iterator<Item = io::Result<Picture>>,
) -> io::Result<()> {
    let view = JpegSource {
        width,
        height,
        present: RefCell::new(BandWindow {
            bands,
            first: 0,
            rgb: Vec::new(),
            failed: None,
        }),
    };
    let written = JpegEncoder::new_with_quality(out, QUALITY).encode_image(&view);
    match view.present.into_inner().failed {
        Some(error) => Err(error),
        None => written.map_err(io_error),
    }
}

/// Bands in the form that the encoder reads: it requests pixels, eight rows at a time, from the
/// top.
struct JpegSource<I> {
    width: u32,
    height: u32,
    present: RefCell<BandWindow<I>>,
}

/// The band that is being read.
struct BandWindow<I> {
    bands: I,
    /// The band's first row in the picture.
    first: u32,
    rgb: Vec<u8>,
    /// The reason why there are no more bands: the rest of the file is black, and is thrown away.
    failed: Option<io::Error>,
}

impl<I: Iterator<Item = io::Result<Picture>>> GenericImageView for JpegSource<I> {
    type Pixel = Rgb<u8>;

    fn dimensions(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn get_pixel(&self, x: u32, y: u32) -> Rgb<u8> {
        let mut present = self.present.borrow_mut();
        let pitch = 3 * self.width as usize;
        loop {
            let at = (y - present.first) as usize * pitch + 3 * x as usize;
            if let Some([r, g, b]) = present.rgb.get(at..).and_then(<[u8]>::first_chunk) {
                return Rgb([*r, *g, *b]);
            }
            if present.failed.is_some() {
                return Rgb([0; 3]);
            }
            present.advance(pitch);
        }
    }
}

impl<I: Iterator<Item = io::Result<Picture>>> BandWindow<I> {
    fn advance(&mut self, pitch: usize) {
        let rows = self.rgb.len() / pitch;
        match self.bands.next() {
            Some(Ok(band)) => {
                self.first += rows as u32;
                self.rgb = band.rgb;
            }
            Some(Err(error)) => self.failed = Some(error),
            None => self.failed = Some(io::Error::other("rows are missing")),
        }
    }
}
