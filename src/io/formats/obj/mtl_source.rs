//! Material files that have been read, and their materials.

use super::mtl::MtlMaterial;
use crate::formats::diagnostics::{DiagnosticSink, Span, quoted_file};
use crate::formats::folder::Found;

/// A material file.
pub(super) struct MtlSource {
    pub(super) file: Found,
    /// Its name in the scene file.
    pub(super) name: String,
    pub(super) bytes: Vec<u8>,
    /// The `mtllib` that names it.
    pub(super) library: Span,
}

/// A material, and its file's number.
pub(super) struct KnownMaterial {
    pub(super) material: MtlMaterial,
    pub(super) source: usize,
}

/// Warns that a file was found under another name than the scene's.
pub(super) fn warn_renamed(name: &str, instead: &str, span: Span, report: &mut DiagnosticSink) {
    let (name, instead) = (quoted_file(name), quoted_file(instead));
    report.warning(
        span,
        format!("there is no file {name}: {instead} is read instead"),
    );
}
