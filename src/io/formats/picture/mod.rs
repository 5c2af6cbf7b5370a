//! Pictures to sRGB bytes and alpha. The size is known before anything is decoded. The format is
//! told by the first bytes and not by the file's name.

mod jpeg;
mod kind;
mod others;
mod png;
#[cfg(test)]
pub(super) mod tests;

use self::jpeg::JpegDecoder;
use self::others::WholeImageDecoder;
use self::png::PngReader;
use phalanx_scene::MAX_TEXTURE_SIDE;

/// A picture of which the header has been read.
pub(super) struct EncodedImage<'a> {
    /// Pixels in a row, 1 to [`MAX_TEXTURE_SIDE`].
    pub(super) width: u32,
    /// Rows, 1 to [`MAX_TEXTURE_SIDE`].
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

/// Bytes of a decoder's tables and rows.
const TABLES: u64 = 1 << 20;

const BROKEN_PALETTE: &str = "its palette (PLTE) does not hold whole colours, 1 to 256";

impl<'a> EncodedImage<'a> {
    /// Reads the header of a picture.
    pub(super) fn open(bytes: &'a [u8]) -> Result<EncodedImage<'a>, String> {
        match bytes {
            _ if bytes.starts_with(kind::PNG) => png::open(bytes),
            _ if bytes.starts_with(kind::JPEG) => jpeg::open(bytes),
            _ if bytes.starts_with(kind::BMP) => others::open_bmp(bytes),
            _ if kind::is_webp(bytes) => others::open_webp(bytes),
            // A TGA has no magic number, so that it comes last.
            _ if others::is_tga(bytes) => others::open_tga(bytes),
            _ => Err(kind::refusal(bytes)),
        }
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Bytes that alpha takes, unless all pixels turn out to be whole.
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

/// The pixels of a picture. Memory grows as they come, because a header may claim anything.
#[derive(Default)]
pub(super) struct DecodedImage {
    /// sRGB bytes.
    pub(super) colors: Vec<[u8; 3]>,
    /// Share of each pixel that is there, in 255ths; empty if all are whole.
    pub(super) alpha: Vec<u8>,
}

impl DecodedImage {
    /// Makes room for further pixels.
    fn reserve(&mut self, pixels: usize) -> Result<(), String> {
        let room = self.colors.try_reserve(pixels);
        room.map_err(|_| "there is no memory for it".into())
    }

    /// Appends black pixels up to a number of them.
    fn grow(&mut self, pixels: usize) -> Result<(), String> {
        let more = pixels.saturating_sub(self.colors.len());
        self.reserve(more)?;
        self.colors.resize(self.colors.len() + more, [0; 3]);
        Ok(())
    }

    #[inline]
    fn push(&mut self, color: [u8; 3], alpha: u8) {
        self.colors.push(color);
        self.set_alpha(self.colors.len() - 1, alpha);
    }

    /// Sets the alpha of a pixel. Alpha takes memory from the first pixel on that is not whole.
    #[inline]
    fn set_alpha(&mut self, pixel: usize, alpha: u8) {
        if alpha != 255 || pixel < self.alpha.len() {
            if self.alpha.len() <= pixel {
                self.alpha.resize(pixel + 1, 255);
            }
            self.alpha[pixel] = alpha;
        }
    }
}

/// Layout of a pixel in the decoder's output.
#[derive(Clone, Copy)]
struct PixelLayout {
    samples: usize,
    wide: bool,
}

impl PixelLayout {
    fn has_alpha(self) -> bool {
        self.samples == 2 || self.samples == 4
    }

    /// Calls a function with the colour and alpha of each pixel of a row.
    fn each(self, row: &[u8], then: impl FnMut([u8; 3], u8)) {
        match self.wide {
            false => self.each_with::<1>(row, |[byte]| byte, then),
            // The nearest 8-bit value: 65535 is 255 · 257.
            true => {
                let nearest = |bytes| ((u32::from(u16::from_be_bytes(bytes)) + 128) / 257) as u8;
                self.each_with::<2>(row, nearest, then);
            }
        }
    }

    fn each_with<const BYTES: usize>(
        self,
        row: &[u8],
        byte: impl Fn([u8; BYTES]) -> u8,
        mut then: impl FnMut([u8; 3], u8),
    ) {
        let (samples, _) = row.as_chunks::<BYTES>();
        let pixels = samples.chunks_exact(self.samples);
        match self.samples {
            1 => pixels.for_each(|p| then([byte(p[0]); 3], 255)),
            2 => pixels.for_each(|p| then([byte(p[0]); 3], byte(p[1]))),
            3 => pixels.for_each(|p| then([0, 1, 2].map(|k| byte(p[k])), 255)),
            _ => pixels.for_each(|p| then([0, 1, 2].map(|k| byte(p[k])), byte(p[3]))),
        }
    }
}

fn checked_sides(width: u64, height: u64) -> Result<(u32, u32), String> {
    let side = 1..=u64::from(MAX_TEXTURE_SIDE);
    match side.contains(&width) && side.contains(&height) {
        true => Ok((width as u32, height as u32)),
        false => Err(format!(
            "its size is {width}×{height}, but a side may have 1 to {MAX_TEXTURE_SIDE} texels"
        )),
    }
}

fn too_short(width: u32, height: u32) -> String {
    format!("it is too short for its {width}×{height} texels")
}
