//! Which kinds of file pictures are written as, by the ending of their name.

use std::ffi::OsStr;
use std::path::Path;

/// A kind of picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 or 16 bits a sample, without loss.
    Png,
    /// 8 bits a sample, with loss.
    Jpeg,
    /// OpenEXR: linear radiance as 32-bit floats, in tiles.
    Exr,
    /// Radiance RGBE: linear radiance, three mantissas of 8 bits with one exponent.
    Hdr,
    /// Portable float map: linear radiance as 32-bit floats, as they are.
    Pfm,
}

impl Format {
    /// All, by ending.
    pub const ENDINGS: [(&'static str, Format); 6] = [
        ("png", Format::Png),
        ("jpg", Format::Jpeg),
        ("jpeg", Format::Jpeg),
        ("exr", Format::Exr),
        ("hdr", Format::Hdr),
        ("pfm", Format::Pfm),
    ];

    /// What a file of that name is to be; none for a name with another ending, or with none.
    pub fn of(path: &Path) -> Option<Format> {
        let ending = path.extension().and_then(OsStr::to_str)?;
        let mut all = Format::ENDINGS.iter();
        let named = all.find(|(name, _)| ending.eq_ignore_ascii_case(name));
        named.map(|(_, format)| *format)
    }

    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Jpeg => "jpg",
            Format::Exr => "exr",
            Format::Hdr => "hdr",
            Format::Pfm => "pfm",
        }
    }

    /// Whether it holds linear radiance rather than samples for a screen.
    pub fn is_linear(self) -> bool {
        matches!(self, Format::Exr | Format::Hdr | Format::Pfm)
    }

    /// Tells whether its writer goes back in the file, so that into a pipe it is written when it is
    /// whole.
    pub fn seeks(self) -> bool {
        matches!(self, Format::Exr | Format::Pfm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_tells() {
        for (name, want) in [
            ("a/b.PNG", Some(Format::Png)),
            ("a.b.jpeg", Some(Format::Jpeg)),
            ("x.jpg", Some(Format::Jpeg)),
            ("x.Exr", Some(Format::Exr)),
            ("x.hdr", Some(Format::Hdr)),
            ("x.pfm", Some(Format::Pfm)),
            ("x.bmp", None),
            ("png", None),
            (".png", None),
            ("x.png.gz", None),
        ] {
            assert_eq!(Format::of(Path::new(name)), want, "{name}");
        }
    }
}
