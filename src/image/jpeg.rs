//! JPEG files, for output only.

use super::encoder::Picture;
use super::header::PictureHeader;
use super::png::io_error;
use ::image::codecs::jpeg::JpegEncoder;
use ::image::{ExtendedColorType, GenericImageView, Rgb};
use std::cell::RefCell;
use std::io::{self, Write};

/// Quality, out of 100: differences can be measured, but are hardly visible.
const QUALITY: u8 = 95;

/// A picture as the bytes of a JPEG file of this quality, out of 100, for viewing: without texts.
pub fn jpeg_bytes(picture: &Picture, quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let size = (picture.width, picture.height);
    let mut encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
    // Writing to memory does not fail; if it did, there would be no picture.
    match encoder.encode(&picture.rgb, size.0, size.1, ExtendedColorType::Rgb8) {
        Ok(()) => bytes,
        Err(_) => Vec::new(),
    }
}

/// Writes pictures of whole blocks of eight rows, one below the other, as they arrive.
pub(super) fn write_jpeg(
    out: &mut dyn Write,
    (width, height): (u32, u32),
    header: &PictureHeader,
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
    let out = CommentWriter {
        out,
        ahead: JFIF_BYTES,
        comment: comment(header),
    };
    let written = JpegEncoder::new_with_quality(out, QUALITY).encode_image(&view);
    match view.present.into_inner().failed {
        Some(error) => Err(error),
        None => written.map_err(io_error),
    }
}

/// Bytes of the first two segments of the encoder, SOI and APP0, which other programs expect there.
const JFIF_BYTES: usize = 20;

/// Maximum number of bytes of a comment: its length has 16 bits.
const MAX_COMMENT: usize = 65_533;

/// The texts of a header as a comment segment, one per line. Anything that does not fit is omitted.
fn comment(header: &PictureHeader) -> Vec<u8> {
    let texts = header.texts();
    let lines: Vec<&str> = texts.iter().map(|(_, text)| &text[..]).collect();
    let mut text = lines.join("\n");
    while text.len() > MAX_COMMENT {
        text.pop();
    }
    let mut segment = vec![0xff, 0xfe];
    segment.extend((text.len() as u16 + 2).to_be_bytes());
    segment.extend(text.bytes());
    segment
}

/// Inserts a comment into the bytes of an encoder that has none.
struct CommentWriter<'a> {
    out: &'a mut dyn Write,
    /// Bytes that come before the comment.
    ahead: usize,
    comment: Vec<u8>,
}

impl Write for CommentWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.ahead == 0 {
            return self.out.write(bytes);
        }
        let count = self.out.write(&bytes[..bytes.len().min(self.ahead)])?;
        self.ahead -= count;
        if self.ahead == 0 {
            self.out.write_all(&self.comment)?;
        }
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
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
    /// The reason why there are no more bands: the rest of the file is black, and is discarded.
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
            let index = (y - present.first) as usize * pitch + 3 * x as usize;
            if let Some([r, g, b]) = present.rgb.get(index..).and_then(<[u8]>::first_chunk) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::ImageFormat;

    #[test]
    fn the_comment_follows_the_head_and_the_picture_stays() {
        let picture = Picture {
            width: 9,
            height: 8,
            rgb: (0..9 * 8 * 3).map(|k| k as u8).collect(),
        };
        let written = |command: String| {
            let header = PictureHeader {
                command,
                ..PictureHeader::NONE
            };
            let mut bytes = Vec::new();
            write_jpeg(
                &mut bytes,
                (9, 8),
                &header,
                [Ok(picture.clone())].into_iter(),
            )
            .unwrap();
            bytes
        };
        let bytes = written("phalanx render ä".to_owned());
        assert_eq!(bytes[6..11], *b"JFIF\0");
        let text = format!("{}\nphalanx render ä", super::super::header::SOFTWARE);
        assert_eq!(bytes[20..24], [0xff, 0xfe, 0, text.len() as u8 + 2]);
        assert_eq!(bytes[24..24 + text.len()], *text.as_bytes());
        let mut plain = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut plain, QUALITY);
        let rgb = ::image::RgbImage::from_raw(9, 8, picture.rgb.clone()).unwrap();
        encoder.encode_image(&rgb).unwrap();
        assert_eq!(bytes[..20], plain[..20]);
        assert!(bytes[24 + text.len()..] == plain[20..]);
        // The longest comment is cut between two characters, and the file is still read.
        let long = written("ä".repeat(40_000));
        assert_eq!(long[20..22], [0xff, 0xfe]);
        let read = ::image::load_from_memory_with_format(&long, ImageFormat::Jpeg).unwrap();
        assert_eq!((read.width(), read.height()), (9, 8));
    }
}
