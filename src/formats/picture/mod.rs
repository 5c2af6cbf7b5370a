//! Pictures to sRGB bytes and alpha. The size is known before anything is decoded. The format is
//! identified by the first bytes, not by the file's name.

mod jpeg;
mod magic;
mod others;
mod pixels;
mod png;
#[cfg(test)]
pub(super) mod tests;

use self::others::WholeImageDecoder;
use self::pixels::{DecodedImage, ImageHeader};
use self::png::PngReader;
use phalanx_image::decoders::jpeg::JpegDecoder;

/// A picture of which the header has been read.
pub(super) struct EncodedImage<'a> {
    /// Pixels in a row, 1 to [`phalanx_scene::MAX_TEXTURE_SIDE`].
    pub(super) width: u32,
    /// Rows, 1 to [`phalanx_scene::MAX_TEXTURE_SIDE`].
    pub(super) height: u32,
    /// Bytes that decoding takes beyond the pixels.
    pub(super) scratch: u64,
    decoder: Decoder<'a>,
}

enum Decoder<'a> {
    Png(Box<PngReader<'a>>),
    Jpeg(Box<JpegDecoder<'a>>),
    WholeImage(WholeImageDecoder<'a>),
}

impl<'a> EncodedImage<'a> {
    /// Reads the header of a picture.
    pub(super) fn open(bytes: &'a [u8]) -> Result<EncodedImage<'a>, String> {
        match bytes {
            _ if bytes.starts_with(magic::PNG) => Ok(Self::of(png::open(bytes)?, |decoder| {
                Decoder::Png(Box::new(decoder))
            })),
            _ if bytes.starts_with(magic::JPEG) => Ok(Self::of(jpeg::open(bytes)?, |decoder| {
                Decoder::Jpeg(Box::new(decoder))
            })),
            _ if bytes.starts_with(magic::BMP) => {
                Ok(Self::of(others::open_bmp(bytes)?, Decoder::WholeImage))
            }
            _ if magic::is_webp(bytes) => {
                Ok(Self::of(others::open_webp(bytes)?, Decoder::WholeImage))
            }
            // A TGA has no magic number, so that it comes last.
            _ if others::is_tga(bytes) => {
                Ok(Self::of(others::open_tga(bytes)?, Decoder::WholeImage))
            }
            _ => Err(magic::refusal(bytes)),
        }
    }

    fn of<D>(header: ImageHeader<D>, decoder: impl FnOnce(D) -> Decoder<'a>) -> EncodedImage<'a> {
        EncodedImage {
            width: header.width,
            height: header.height,
            scratch: header.scratch,
            decoder: decoder(header.decoder),
        }
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Bytes for alpha, unless all pixels turn out to be opaque.
    pub(super) fn alpha_bytes(&self) -> u64 {
        match &self.decoder {
            Decoder::Png(reader) if png::layout(reader).has_alpha() => self.pixels(),
            Decoder::WholeImage(other) if other.layout().has_alpha() => self.pixels(),
            _ => 0,
        }
    }

    /// All pixels, the uppermost row first. Grey becomes equal components, 16 bits become the
    /// nearest 8, and colour profiles are ignored.
    pub(super) fn decode(self) -> Result<DecodedImage, String> {
        let (width, height) = (self.width as usize, self.height as usize);
        let mut image = DecodedImage::default();
        match self.decoder {
            Decoder::Png(reader) => png::decode(*reader, [width, height], &mut image)?,
            Decoder::Jpeg(decoder) => jpeg::decode(*decoder, &mut image)?,
            Decoder::WholeImage(decoder) => decoder.decode(&mut image)?,
        }
        if image.colors.len() != width * height {
            return Err("it decodes to another size than it claims".into());
        }
        if !image.alpha.is_empty() {
            image.alpha.resize(width * height, 255);
        }
        image.colors.shrink_to_fit();
        image.alpha.shrink_to_fit();
        Ok(image)
    }
}
