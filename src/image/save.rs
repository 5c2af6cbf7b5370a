//! A film as a file of any format.

use super::file::replace_file;
use super::format::Format;
use super::jpeg::write_jpeg;
use super::linear::{write_exr, write_hdr, write_pfm};
use super::png::{PictureError, write_png, write_png_16};
use super::tone::{Grade, encode, encode_16};
use crate::render::Film;
use std::io::{self, Write};
use std::path::Path;

/// Bits of a PNG's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// 256 values.
    #[default]
    Eight,
    /// 65,536 values.
    Sixteen,
}

/// Saves a film: whole, or not at all (see [`replace_file`]). Linear formats have its radiance as it is; of the grade and the
/// depth, JPEG takes the first and PNG both. The bytes depend on film, format, grade and depth alone.
///
/// # Errors
/// [`PictureError::Write`].
pub fn save(
    path: &Path,
    film: &Film,
    format: Format,
    grade: Grade,
    depth: Depth,
) -> Result<(), PictureError> {
    let fill = |writer: &mut dyn Write| -> io::Result<()> {
        match (format, depth) {
            (Format::Png, Depth::Eight) => write_png(writer, &encode(film, grade)),
            (Format::Png, Depth::Sixteen) => write_png_16(writer, &encode_16(film, grade)),
            (Format::Jpeg, _) => write_jpeg(writer, &encode(film, grade)),
            (Format::Exr, _) => write_exr(writer, film),
            (Format::Hdr, _) => write_hdr(writer, film),
            (Format::Pfm, _) => write_pfm(writer, film),
        }
    };
    replace_file(path, fill).map_err(|source| PictureError::Write {
        path: path.to_path_buf(),
        source,
    })
}
