//! The formats in which standard scenes can be written.

use super::nff::NffWriter;
use super::outcome::{DroppedFeatures, SceneWriteError};
use super::ply::PlyWriter;
use super::test_file::TestWriter;
use crate::builder::SceneBuilder;
use crate::spec::{Spec, generate};
use crate::tessellate::Tessellate;
use std::io::Write;
use std::path::Path;

/// A format in which standard scenes can be written.
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
    /// The format for a file's ending.
    pub fn of(path: &Path) -> Option<FileFormat> {
        let ending = path.extension()?.to_ascii_lowercase();
        match ending.to_str()? {
            "nff" => Some(FileFormat::Nff),
            "ply" => Some(FileFormat::Ply),
            "test" => Some(FileFormat::Test),
            _ => None,
        }
    }
}

/// Writes a standard scene, streaming; returns the features, other than shapes, that the format
/// could not hold.
///
/// With `tessellate`, spheres and cones become polygons first, by [`Tessellate`]. Scenes of
/// triangles are drawn and encoded on `threads` threads, 0 for one per CPU; the file does not
/// depend on their number.
///
/// # Errors
/// [`SceneWriteError`]; the part written by then is useless.
pub fn write(
    spec: Spec,
    format: FileFormat,
    tessellate: Option<u32>,
    threads: usize,
    out: &mut dyn Write,
) -> Result<DroppedFeatures, SceneWriteError> {
    let build = |builder: &mut dyn SceneBuilder| match tessellate {
        Some(fineness) => generate(spec, &mut Tessellate::new(fineness, builder)),
        None => generate(spec, builder),
    };
    match format {
        FileFormat::Nff => {
            let mut builder = NffWriter::new(out);
            builder.threads = threads;
            build(&mut builder);
            builder.finish()
        }
        FileFormat::Ply => {
            let mut builder = PlyWriter::new(out);
            builder.threads = threads;
            loop {
                build(&mut builder);
                if !builder.end_pass() {
                    return builder.finish();
                }
            }
        }
        FileFormat::Test => {
            let mut builder = TestWriter::new(out, spec.scene.max_depth);
            builder.threads = threads;
            build(&mut builder);
            builder.finish()
        }
    }
}
