//! The `.test` format: one command per line, a matrix stack as in OpenGL, and state that each
//! primitive and light captures as it is declared.
//!
//! [`read`] walks the statements of `lexer`, each of which runs its row of `commands::COMMANDS` on
//! a [`TestReader`]. A faulty statement leaves a diagnostic. It keeps enough of its effect that
//! later statements are not reported because of it.

mod commands;
mod geometry;
mod lexer;
mod lights;
mod settings;
mod state;
mod transform;

use super::defaults::{MissingParts, finish_scene};
use super::diagnostics::{DiagnosticSink, Span};
use super::origin::ReadStop;
use super::{Loaded, Options};
use glam::{DVec3, Vec3};
use phalanx_scene::{Material, MaterialTable, Scene};
use transform::Transforms;

/// The result of the statements so far.
struct TestReader<'a> {
    report: DiagnosticSink<'a>,
    scene: Scene,
    seen: SeenCommands,
    /// The origin, subtracted from transformed positions before they are rounded.
    origin: DVec3,
    vertices: VertexPool<DVec3>,
    normal_vertices: VertexPool<NormalVertex>,
    transforms: Transforms,
    surface: Material,
    palette: MaterialTable,
    /// Constant, linear and quadratic attenuation of the point lights that follow.
    attenuation: Vec3,
}

/// Flags of the commands that may occur once: true if they have occurred, faulty or not.
#[derive(Default)]
struct SeenCommands {
    any: bool,
    size: bool,
    camera: bool,
}

/// Vertices to be indexed, and the number of them that the file announced. The pool grows with the
/// vertices that are read: the announced number alone never allocates.
struct VertexPool<T> {
    items: Vec<T>,
    promised: Option<u64>,
}

impl<T> VertexPool<T> {
    const EMPTY: VertexPool<T> = VertexPool {
        items: Vec::new(),
        promised: None,
    };
}

#[derive(Clone, Copy)]
struct NormalVertex {
    position: DVec3,
    normal: Vec3,
}

impl NormalVertex {
    /// Stands in for a faulty vertex, so that triangles that use it are not reported.
    const STAND_IN: NormalVertex = NormalVertex {
        position: DVec3::ZERO,
        normal: Vec3::Z,
    };
}

/// Reads a scene from the text of a `.test` file.
///
/// # Errors
/// Faults of the text, in file order: at least one and at most [`super::MAX_DIAGNOSTICS`]
/// diagnostics.
pub(super) fn read(text: &str, options: &Options) -> Result<Loaded, ReadStop> {
    let mut reader = TestReader::new(text, options.origin.position());
    if text.trim_start_matches('\u{feff}').trim().is_empty() {
        reader.report.error(Span::START, "the file is empty");
    } else {
        for (name, operands) in lexer::statements(text) {
            reader.run(name, operands);
            if reader.report.is_full() {
                break;
            }
        }
        reader.check_complete();
    }
    reader.finish(options)
}

impl<'a> TestReader<'a> {
    fn new(text: &'a str, origin: DVec3) -> Self {
        TestReader {
            report: DiagnosticSink::new(text.as_bytes()),
            scene: Scene::default(),
            seen: SeenCommands::default(),
            origin,
            vertices: VertexPool::EMPTY,
            normal_vertices: VertexPool::EMPTY,
            transforms: Transforms::new(),
            surface: Material::default(),
            palette: MaterialTable::default(),
            attenuation: Vec3::X,
        }
    }

    /// Adds the errors that only show at the end of the file.
    fn check_complete(&mut self) {
        let end = self.report.end_of_content();
        if !self.seen.size {
            self.report.error_with_help(
                end,
                "the file has no `size`",
                "start it with the image's width and height: `size 640 480`",
            );
        }
        if !self.seen.camera {
            self.report.error_with_help(
                end,
                "the file has no `camera`",
                "add `camera`, then where it stands, what it looks at, which way is up, and its vertical field of view",
            );
        }
        if let Some((outermost, count)) = self.transforms.unclosed() {
            let message = match count {
                1 => String::from("this `pushTransform` is never popped"),
                _ => format!("{count} of these are never popped, this `pushTransform` first"),
            };
            self.report.warning(outermost, message);
        }
        if self.scene.prims.is_empty() {
            self.report
                .warning(end, "the file has no primitives: the picture will be empty");
        }
    }

    fn finish(self, options: &Options) -> Result<Loaded, ReadStop> {
        finish_scene(self.scene, &MissingParts::NOTHING, options, self.report)
    }
}
