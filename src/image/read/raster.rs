//! Pictures for a screen, held as a whole.

use super::super::description::BAND_ROWS;
use super::super::error::PictureError;
use super::layout::MAX_WHOLE_PIXELS;
use super::reader::PictureReader;
use std::path::Path;

/// A picture for a screen: RGBA, 16 bits per sample. An 8-bit sample s becomes 257 s, and missing
/// alpha is opaque.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Pixels, row by row from the top left.
    pub pixels: Vec<[u16; 4]>,
}

/// Reads a PNG (8 or 16 bits per sample, grey, colour or palette, with or without alpha) or a JPEG.
///
/// # Errors
/// [`PictureError::Read`] and [`PictureError::Decode`].
pub fn load(path: &Path) -> Result<Raster, PictureError> {
    let mut reader = PictureReader::open(path)?;
    let layout = reader.layout().clone();
    let (width, height) = (layout.width, layout.height);
    if layout.format.is_linear() {
        return Err(reader.error("it holds linear radiance, not samples for a screen".into()));
    }
    // Checked before anything is allocated by that size.
    if layout.pixels() > MAX_WHOLE_PIXELS {
        let reason = format!("{width}x{height} pixels are more than {MAX_WHOLE_PIXELS}");
        return Err(reader.error(reason));
    }
    let mut pixels = Vec::with_capacity(layout.pixels() as usize);
    for top in (0..height).step_by(BAND_ROWS as usize) {
        let planes = reader.read(top..height.min(top + BAND_ROWS))?;
        let [red, green, blue, alpha] = [0, 1, 2, 3].map(|c| planes[c].iter().map(|s| *s as u16));
        let band = red.zip(green).zip(blue).zip(alpha);
        pixels.extend(band.map(|(((r, g), b), a)| [r, g, b, a]));
    }
    Ok(Raster {
        width,
        height,
        pixels,
    })
}
