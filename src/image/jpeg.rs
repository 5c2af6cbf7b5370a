//! JPEG files, out only.

use super::png::io_error;
use super::tone::Picture;
use ::image::ExtendedColorType;
use ::image::codecs::jpeg::JpegEncoder;
use std::io;

/// Of 100: differences can be measured, and hardly seen.
const QUALITY: u8 = 95;

pub(super) fn write_jpeg(writer: &mut dyn io::Write, picture: &Picture) -> io::Result<()> {
    let Picture { width, height, rgb } = picture;
    let mut encoder = JpegEncoder::new_with_quality(writer, QUALITY);
    let written = encoder.encode(rgb, *width, *height, ExtendedColorType::Rgb8);
    written.map_err(io_error)
}
