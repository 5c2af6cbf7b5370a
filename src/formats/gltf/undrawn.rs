//! Primitives that no picture shows: one warning for all of a kind.

use super::source::GltfSource;
use crate::diagnostics::DiagnosticSink;
use std::collections::BTreeSet;

/// Primitives by mesh and index in it, each once, however often a mesh is shown.
#[derive(Default)]
pub(super) struct UndrawnPrimitives {
    /// Primitives of points or lines.
    pub(super) lines: BTreeSet<(usize, usize)>,
    pub(super) without_positions: BTreeSet<(usize, usize)>,
}

impl UndrawnPrimitives {
    /// Warns of them, at the first mesh that has one.
    pub(super) fn warn(&self, source: &GltfSource, report: &mut DiagnosticSink) {
        for (primitives, kind) in [
            (&self.lines, "of points or lines"),
            (&self.without_positions, "without positions"),
        ] {
            let message = match primitives.len() {
                0 => continue,
                1 => format!("one primitive {kind} is left out"),
                count => format!("{count} primitives {kind} are left out"),
            };
            let first = primitives.first().map_or(0, |&(mesh, _)| mesh);
            report.warning(source.span_of("meshes", first), message);
        }
    }
}
