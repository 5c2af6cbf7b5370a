//! Sizes and channels of picture files, and the rows that readers return.

use super::super::format::ImageFormat;
use phalanx_scene::MAX_SIDE;
use std::ops::Range;

/// Type of the numbers of a channel. In memory, each has 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleKind {
    /// Samples for a screen, of 16 bits: an 8-bit sample s is 257 s. Their value is in steps of an
    /// 8-bit sample, 0 to 255.
    Display,
    /// Floats of 32 bits; those of 16 bits are converted without loss.
    Float,
    /// Integers.
    Integer,
}

/// 16-bit steps in one 8-bit step.
const STEP: f64 = 257.0;

impl SampleKind {
    /// The number that the bits represent.
    pub fn value(self, bits: u32) -> f64 {
        match self {
            SampleKind::Display => f64::from(bits) / STEP,
            SampleKind::Float => f32::from_bits(bits).into(),
            SampleKind::Integer => bits.into(),
        }
    }
}

/// A channel of a picture file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureChannel {
    /// Its full name, such as `albedo.R`; red, green, blue and alpha are R, G, B and A.
    pub name: String,
    /// The numbers that it holds.
    pub kind: SampleKind,
}

/// Description of a picture file, by its header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureLayout {
    /// Kind of file, by its first bytes.
    pub format: ImageFormat,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Column and row of the upper left pixel, from the display window of OpenEXR files, otherwise
    /// 0.
    pub corner: (i32, i32),
    /// Channels in the order of the file. Pictures for a screen have R, G, B and A, regardless of
    /// the file: grey becomes equal components, and missing alpha is opaque.
    pub channels: Vec<PictureChannel>,
}

impl PictureLayout {
    /// A picture of red, green and blue, and of alpha if it is for a screen.
    pub(super) fn rgb(format: ImageFormat, (width, height): (u32, u32)) -> PictureLayout {
        let (kind, names) = if format.is_linear() {
            (SampleKind::Float, &["R", "G", "B"][..])
        } else {
            (SampleKind::Display, &["R", "G", "B", "A"][..])
        };
        let channel = |name: &&str| PictureChannel {
            name: (*name).to_owned(),
            kind,
        };
        PictureLayout {
            format,
            width,
            height,
            corner: (0, 0),
            channels: names.iter().map(channel).collect(),
        }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// Samples of some rows: for each channel its bits, row by row.
pub type SamplePlanes = Vec<Vec<u32>>;

/// A decoder that returns rows from the top, and earlier ones again on request.
pub(super) trait RowReader {
    /// Appends rows to the planes, which are empty, one for each channel.
    fn read(&mut self, rows: Range<u32>, planes: &mut SamplePlanes) -> Result<(), String>;
}

/// A picture file of which the header has been read, or the reason why it cannot be.
pub(super) type OpenedPicture = Result<(PictureLayout, Box<dyn RowReader>), String>;

/// Rejects sides that no picture of ours has, before anything is allocated by size.
pub(super) fn check_sides(width: u64, height: u64) -> Result<(u32, u32), String> {
    let sides = 1..=u64::from(MAX_SIDE);
    if sides.contains(&width) && sides.contains(&height) {
        Ok((width as u32, height as u32))
    } else {
        Err(format!(
            "its size of {width}x{height} is out of range: sides are 1 to {MAX_SIDE} pixels"
        ))
    }
}

/// Maximum number of pixels of a picture that is held in memory as a whole, because its format
/// cannot be decoded row by row.
pub(super) const MAX_WHOLE_PIXELS: u64 = 1 << 28;

/// Rejects a picture that cannot be decoded row by row and is too large to be held in memory.
pub(super) fn check_whole(width: u32, height: u32) -> Result<(), String> {
    if u64::from(width) * u64::from(height) > MAX_WHOLE_PIXELS {
        Err(format!(
            "{width}x{height} pixels are more than {MAX_WHOLE_PIXELS}, and it can only be decoded as \
             a whole"
        ))
    } else {
        Ok(())
    }
}

/// Appends rows of a picture of samples for a screen that is held as a whole, 1 to 4 per pixel.
pub(super) fn push_display(planes: &mut SamplePlanes, pixel: &[u16]) {
    let [r, g, b, a] = match *pixel {
        [grey] => [grey, grey, grey, u16::MAX],
        [grey, alpha] => [grey, grey, grey, alpha],
        [r, g, b] => [r, g, b, u16::MAX],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0; 4],
    };
    for (plane, sample) in planes.iter_mut().zip([r, g, b, a]) {
        plane.push(sample.into());
    }
}
