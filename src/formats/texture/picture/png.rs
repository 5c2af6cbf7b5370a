//! PNG, row by row: memory is touched only as far as rows have been decoded.

use super::pixels::{
    DecodedImage, EncodedImage, PictureDecoder, PixelLayout, TABLES, checked_sides,
};
use ::png::BitDepth;
use phalanx_image::decoders::png::{self, finish, plain};
use std::io::Cursor;

/// A decoder that has read all before the first row.
type PngReader<'a> = ::png::Reader<Cursor<&'a [u8]>>;

/// Reads the header of a PNG. Neither faults outside of the rows nor the length of the file lead to
/// rejection: a picture of one colour takes a thousandth of the bytes of its rows, and a row an
/// eighth of those of its pixels.
pub(super) fn open(bytes: &[u8]) -> Result<EncodedImage<'_>, String> {
    let reader = png::open(Cursor::new(bytes), checked_sides)?;
    let info = reader.info();
    Ok(EncodedImage {
        width: info.width,
        height: info.height,
        scratch: TABLES,
        decoder: Box::new(reader),
    })
}

/// Layout of the decoder's output.
fn layout(reader: &PngReader) -> PixelLayout {
    let (color, depth) = reader.output_color_type();
    PixelLayout {
        samples: color.samples(),
        wide: depth == BitDepth::Sixteen,
    }
}

impl PictureDecoder for PngReader<'_> {
    fn has_alpha(&self) -> bool {
        layout(self).has_alpha()
    }

    fn decode(
        mut self: Box<Self>,
        [width, height]: [usize; 2],
        image: &mut DecodedImage,
    ) -> Result<(), String> {
        let layout = layout(&self);
        if self.info().interlaced {
            return decode_interlaced(*self, [width, height], image);
        }
        for _ in 0..height {
            let row = self.next_row().map_err(plain)?;
            let row = row.ok_or(TOO_FEW_ROWS)?;
            image.reserve(width)?;
            layout.each(row.data(), |color, alpha| image.push(color, alpha));
        }
        finish(&mut self)
    }
}

const TOO_FEW_ROWS: &str = "it has too few rows";

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
    mut reader: PngReader,
    [width, height]: [usize; 2],
    image: &mut DecodedImage,
) -> Result<(), String> {
    let layout = layout(&reader);
    for [left, across, top, down] in ADAM7_PASSES {
        if left >= width {
            continue;
        }
        for y in (top..height).step_by(down) {
            let row = reader.next_interlaced_row().map_err(plain)?;
            let row = row.ok_or(TOO_FEW_ROWS)?;
            image.grow((y + 1) * width)?;
            let mut targets = (y * width + left..(y + 1) * width).step_by(across);
            layout.each(row.data(), |color, alpha| {
                if let Some(target) = targets.next() {
                    image.colors[target] = color;
                    image.set_alpha(target, alpha);
                }
            });
        }
    }
    image.grow(width * height)?;
    finish(&mut reader)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_told_in_plain_words() {
        let mut bytes = Vec::new();
        let encoder = ::png::Encoder::new(&mut bytes, 1, 1);
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(&[7]).expect("a picture");
        writer.finish().expect("a picture");
        let mut broken = bytes.clone();
        let data = bytes.windows(4).position(|w| w == b"IDAT").expect("one");
        let sum = data + 4 + usize::from(bytes[data - 1]);
        broken[sum] ^= 1;
        let reason = |bytes: &[u8]| {
            let decoded = open(bytes).and_then(EncodedImage::decode);
            decoded.map(|_| ()).expect_err("broken")
        };
        let message = reason(&broken);
        assert!(
            message.contains("CRC") && message.ends_with("IDAT chunk."),
            "{message}"
        );
        broken[data + 5] ^= 1;
        assert_eq!(
            reason(&broken),
            "it is broken: the compressed data are not a valid zlib stream"
        );
        assert_eq!(reason(&bytes[..data]), "it ends too early");
    }
}
