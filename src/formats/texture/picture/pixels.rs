//! Pixels as they come out of decoders, and what is known before they do.

use phalanx_scene::MAX_TEXTURE_SIDE;

/// A picture of which the header has been read.
pub(crate) struct EncodedImage<'a> {
    /// Pixels in a row, 1 to [`MAX_TEXTURE_SIDE`].
    pub(crate) width: u32,
    /// Rows, 1 to [`MAX_TEXTURE_SIDE`].
    pub(crate) height: u32,
    /// Bytes that decoding takes beyond the pixels.
    pub(crate) scratch: u64,
    pub(super) decoder: Box<dyn PictureDecoder + 'a>,
}

/// The decoder of a picture's format, which has read the header.
pub(super) trait PictureDecoder {
    fn has_alpha(&self) -> bool;

    /// Decodes all pixels of a picture of this width and height, the uppermost row first.
    fn decode(self: Box<Self>, size: [usize; 2], image: &mut DecodedImage) -> Result<(), String>;
}

impl EncodedImage<'_> {
    /// Number of pixels.
    pub(crate) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Bytes for alpha, unless all pixels turn out to be opaque.
    pub(crate) fn alpha_bytes(&self) -> u64 {
        if self.decoder.has_alpha() { self.pixels() } else { 0 }
    }

    /// All pixels, the uppermost row first. Grey becomes equal components, 16 bits become the
    /// nearest 8, and colour profiles are ignored.
    pub(crate) fn decode(self) -> Result<DecodedImage, String> {
        let (width, height) = (self.width as usize, self.height as usize);
        let mut image = DecodedImage::default();
        self.decoder.decode([width, height], &mut image)?;
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

/// Bytes of a decoder's tables and rows.
pub(super) const TABLES: u64 = 1 << 20;

/// The pixels of a picture. Memory grows as they come, because a header may claim anything.
#[derive(Default)]
pub(crate) struct DecodedImage {
    /// sRGB bytes.
    pub(crate) colors: Vec<[u8; 3]>,
    /// Alpha of each pixel, in 255ths; empty if all are opaque.
    pub(crate) alpha: Vec<u8>,
}

impl DecodedImage {
    /// Makes room for further pixels.
    pub(super) fn reserve(&mut self, pixels: usize) -> Result<(), String> {
        let room = self.colors.try_reserve(pixels);
        room.map_err(|_| "there is no memory for it".into())
    }

    /// Appends black pixels up to a number of them.
    pub(super) fn grow(&mut self, pixels: usize) -> Result<(), String> {
        let more = pixels.saturating_sub(self.colors.len());
        self.reserve(more)?;
        self.colors.resize(self.colors.len() + more, [0; 3]);
        Ok(())
    }

    #[inline]
    pub(super) fn push(&mut self, color: [u8; 3], alpha: u8) {
        self.colors.push(color);
        self.set_alpha(self.colors.len() - 1, alpha);
    }

    /// Sets the alpha of a pixel. Alpha takes memory from the first pixel that is not opaque.
    #[inline]
    pub(super) fn set_alpha(&mut self, pixel: usize, alpha: u8) {
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
pub(super) struct PixelLayout {
    /// Samples of a pixel: grey, grey and alpha, RGB, or RGBA.
    pub(super) samples: usize,
    /// True for samples of two bytes, the higher one first.
    pub(super) wide: bool,
}

impl PixelLayout {
    pub(super) fn has_alpha(self) -> bool {
        self.samples == 2 || self.samples == 4
    }

    /// Calls a function with the colour and alpha of each pixel of a row.
    pub(super) fn each(self, row: &[u8], then: impl FnMut([u8; 3], u8)) {
        if self.wide {
            // The nearest 8-bit value: 65535 is 255 · 257.

            let nearest = |bytes| ((u32::from(u16::from_be_bytes(bytes)) + 128) / 257) as u8;
            self.each_with::<2>(row, nearest, then);
        } else {
            self.each_with::<1>(row, |[byte]| byte, then)
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

/// The sides of a picture, if a texture may have them.
pub(super) fn checked_sides(width: u64, height: u64) -> Result<(u32, u32), String> {
    let side = 1..=u64::from(MAX_TEXTURE_SIDE);
    if side.contains(&width) && side.contains(&height) {
        Ok((width as u32, height as u32))
    } else {
        Err(format!(
            "its size is {width}×{height}, but a side may have 1 to {MAX_TEXTURE_SIDE} texels"
        ))
    }
}

/// Message for a size that the number of bytes cannot account for.
pub(super) fn too_short(width: u32, height: u32) -> String {
    format!("it is too short for its {width}×{height} texels")
}
