//! JPEG, decoded at once.

use super::pixels::{
    DecodedImage, EncodedImage, PictureDecoder, PixelLayout, TABLES, checked_sides,
};
use jpeg_decoder::CodingProcess;
use phalanx_image::decoders::jpeg::{self, JpegDecoder};

/// Reads the header of a JPEG.
pub(super) fn open(bytes: &[u8]) -> Result<EncodedImage<'_>, String> {
    let (decoder, info) = jpeg::open(bytes, checked_sides)?;
    let (width, height) = (u32::from(info.width), u32::from(info.height));
    let pixels = u64::from(width) * u64::from(height);
    let components = info.pixel_format.pixel_bytes() as u64;
    // Planes of whole blocks, and all coefficients of a progressive picture, of two bytes each.
    let blocks = u64::from(width.next_multiple_of(32)) * u64::from(height.next_multiple_of(32));
    let copies = match info.coding_process {
        CodingProcess::DctProgressive => 3,
        CodingProcess::DctSequential | CodingProcess::Lossless => 1,
    };
    Ok(EncodedImage {
        width,
        height,
        scratch: TABLES + blocks * components * copies + pixels * components,
        decoder: Box::new(decoder),
    })
}

impl PictureDecoder for JpegDecoder<'_> {
    fn has_alpha(&self) -> bool {
        false
    }

    fn decode(self: Box<Self>, _: [usize; 2], image: &mut DecodedImage) -> Result<(), String> {
        let (samples, of_pixel) = jpeg::decode(*self)?;
        image.reserve(samples.len() / of_pixel)?;
        let layout = PixelLayout {
            samples: of_pixel,
            wide: false,
        };
        layout.each(&samples, |color, alpha| image.push(color, alpha));
        Ok(())
    }
}
