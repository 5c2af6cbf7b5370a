//! Standard scenes to files, streamed: no more than one shape of a scene is in memory.

mod latched;
mod nff;
mod ply;
mod test_file;

pub use nff::NffWriter;
pub use ply::PlyWriter;
pub use test_file::TestWriter;

use super::builder::SceneBuilder;
use super::tessellate::Tessellate;
use super::{Spec, generate};
use std::io::{self, Write};
use std::path::Path;

/// A format that standard scenes can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// Eric Haines' neutral file format, text.
    Nff,
    /// Polygons only, binary little-endian.
    Ply,
    /// The course's format, text: spheres and triangles.
    Test,
}

impl FileFormat {
    /// The format of a file's ending.
    pub fn of(path: &Path) -> Option<FileFormat> {
        let ending = path.extension()?;
        let named = |name: &str| ending.eq_ignore_ascii_case(name);
        if named("nff") {
            Some(FileFormat::Nff)
        } else if named("ply") {
            Some(FileFormat::Ply)
        } else if named("test") {
            Some(FileFormat::Test)
        } else {
            None
        }
    }
}

/// The reason why a scene could not be written.
#[derive(Debug, thiserror::Error)]
pub enum SceneWriteError {
    /// The file could not be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The format has no such shapes.
    #[error("{format} holds no {shape}; they can be tessellated into triangles")]
    CannotHold {
        /// The format's name.
        format: &'static str,
        /// The shapes it cannot hold, in the plural.
        shape: &'static str,
    },
    /// There are more vertices than the format's indices can count.
    #[error("{0} vertices are more than the format can index")]
    TooMany(u64),
}

/// Features that a written file lacks or simplifies, as text for people. The shapes themselves are
/// complete.
pub type DroppedFeatures = Vec<&'static str>;

/// Writes a standard scene, streaming; returns the features, beside the shapes, that the format
/// could not hold.
///
/// With `tessellate`, spheres and cones become polygons first, by [`Tessellate`].
///
/// # Errors
/// [`SceneWriteError`]; the part that has been written by then is of no use.
pub fn write(
    spec: Spec,
    format: FileFormat,
    tessellate: Option<u32>,
    out: &mut dyn Write,
) -> Result<DroppedFeatures, SceneWriteError> {
    let build = |builder: &mut dyn SceneBuilder| match tessellate {
        Some(fineness) => generate(spec, &mut Tessellate::new(fineness, builder)),
        None => generate(spec, builder),
    };
    match format {
        FileFormat::Nff => {
            let mut builder = NffWriter::new(out);
            build(&mut builder);
            builder.finish()
        }
        FileFormat::Ply => ply::write(out, build),
        FileFormat::Test => {
            let mut builder = TestWriter::new(out, spec.scene.max_depth);
            build(&mut builder);
            builder.finish()
        }
    }
}
