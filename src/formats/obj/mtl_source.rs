//! Material files that have been read, and their materials.

use super::mtl::MtlMaterial;
use crate::diagnostics::{DiagnosticSink, Span, quoted_file};
use crate::folder::{Found, NamedFile};

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

/// The file that was found for a name, with a warning if it was found by another one.
pub(super) fn accepted(
    found: NamedFile,
    name: &str,
    span: Span,
    report: &mut DiagnosticSink,
) -> Found {
    if let Some(instead) = found.instead {
        let (name, instead) = (quoted_file(name), quoted_file(&instead));
        report.warning(
            span,
            format!("there is no file {name}: {instead} is read instead"),
        );
    }
    found.file
}
