//! Kinds of picture files, by the ending of their name.

use phalanx_scene::film::Aov;
use std::ffi::OsStr;
use std::path::Path;

/// A kind of picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// 8 or 16 bits per sample, lossless.
    Png,
    /// 8 bits per sample, lossy.
    Jpeg,
    /// OpenEXR: linear radiance as floats of 32 or 16 bits, in tiles.
    Exr,
    /// Radiance RGBE: linear radiance, three mantissas of 8 bits with one exponent.
    Hdr,
    /// Portable float map: linear radiance as unchanged 32-bit floats.
    Pfm,
}

impl ImageFormat {
    /// All formats, by ending; the usual ending of a format comes first.
    pub const ENDINGS: [(&'static str, ImageFormat); 6] = [
        ("png", ImageFormat::Png),
        ("jpg", ImageFormat::Jpeg),
        ("jpeg", ImageFormat::Jpeg),
        ("exr", ImageFormat::Exr),
        ("hdr", ImageFormat::Hdr),
        ("pfm", ImageFormat::Pfm),
    ];

    /// The format of a file of that name; `None` for a name with another ending, or with none.
    pub fn of(path: &Path) -> Option<ImageFormat> {
        let ending = path.extension().and_then(OsStr::to_str)?;
        let mut all = ImageFormat::ENDINGS.iter();
        let named = all.find(|(name, _)| ending.eq_ignore_ascii_case(name));
        named.map(|(_, format)| *format)
    }

    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        let mut all = ImageFormat::ENDINGS.iter();
        let usual = all.find(|(_, format)| *format == self);
        usual.map_or("", |(ending, _)| ending)
    }

    /// Returns true if it holds linear radiance rather than samples for a screen.
    pub fn is_linear(self) -> bool {
        matches!(self, ImageFormat::Exr | ImageFormat::Hdr | ImageFormat::Pfm)
    }

    /// Bits per sample that its files may have, the default first; empty if there is no choice.
    pub fn bits(self) -> &'static [u8] {
        match self {
            ImageFormat::Png => &[8, 16],
            ImageFormat::Exr => &[32, 16],
            ImageFormat::Jpeg | ImageFormat::Hdr | ImageFormat::Pfm => &[],
        }
    }

    /// Returns true if its files can hold this layer in addition to radiance.
    pub fn holds(self, aov: Aov) -> bool {
        match self {
            ImageFormat::Exr => true,
            ImageFormat::Png => aov == Aov::Alpha,
            ImageFormat::Jpeg | ImageFormat::Hdr | ImageFormat::Pfm => false,
        }
    }

    /// Returns true if its writer seeks back in the file. To a pipe, such a file is written once it
    /// is complete.
    pub fn seeks(self) -> bool {
        matches!(self, ImageFormat::Exr | ImageFormat::Pfm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_tells() {
        for (name, want) in [
            ("a/b.PNG", Some(ImageFormat::Png)),
            ("a.b.jpeg", Some(ImageFormat::Jpeg)),
            ("x.jpg", Some(ImageFormat::Jpeg)),
            ("x.Exr", Some(ImageFormat::Exr)),
            ("x.hdr", Some(ImageFormat::Hdr)),
            ("x.pfm", Some(ImageFormat::Pfm)),
            ("x.bmp", None),
            ("png", None),
            (".png", None),
            ("x.png.gz", None),
        ] {
            assert_eq!(ImageFormat::of(Path::new(name)), want, "{name}");
        }
    }
}
