//! Pictures to sRGB bytes and alpha. The size is known before anything is decoded. The format is
//! identified by the first bytes, not by the file's name.

mod jpeg;
mod magic;
mod others;
mod pixels;
mod png;
#[cfg(test)]
pub(super) mod tests;

pub(super) use self::pixels::EncodedImage;

impl<'a> EncodedImage<'a> {
    /// Reads the header of a picture.
    pub(super) fn open(bytes: &'a [u8]) -> Result<EncodedImage<'a>, String> {
        match bytes {
            _ if bytes.starts_with(magic::PNG) => png::open(bytes),
            _ if bytes.starts_with(magic::JPEG) => jpeg::open(bytes),
            _ if bytes.starts_with(magic::BMP) => others::open_bmp(bytes),
            _ if magic::is_webp(bytes) => others::open_webp(bytes),
            // A TGA has no magic number, so that it comes last.
            _ if others::is_tga(bytes) => others::open_tga(bytes),
            _ => Err(magic::refusal(bytes)),
        }
    }
}
