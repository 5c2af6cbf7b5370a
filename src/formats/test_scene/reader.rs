//! The reader: its state, and its checks at the end of the file.

use super::lexer;
use super::transform::Transforms;
use crate::diagnostics::{DiagnosticSink, Span};
use crate::folder::Folder;
use crate::options::ReadOptions;
use crate::origin::ReadStop;
use crate::read_scene::{self, ReadScene};
use crate::text;
use glam::{DVec3, Vec3};
use phalanx_scene::{Material, MaterialTable, Scene};

/// The result of the statements so far.
pub(super) struct TestReader<'a> {
    pub(super) report: DiagnosticSink<'a>,
    pub(super) scene: Scene,
    pub(super) seen: SeenCommands,
    /// The origin, subtracted from transformed positions before they are rounded.
    pub(super) origin: DVec3,
    pub(super) vertices: VertexPool<DVec3>,
    pub(super) normal_vertices: VertexPool<NormalVertex>,
    pub(super) transforms: Transforms,
    pub(super) surface: Material,
    pub(super) table: MaterialTable,
    /// Constant, linear and quadratic attenuation of the point lights that follow.
    pub(super) attenuation: Vec3,
}

/// Flags of the commands that may occur once: true if they have occurred, faulty or not.
#[derive(Default)]
pub(super) struct SeenCommands {
    pub(super) any: bool,
    pub(super) size: bool,
    pub(super) camera: bool,
}

/// Vertices to be indexed, and the number of them that the file announced. The pool grows with the
/// vertices that are read: the announced number alone never allocates.
pub(super) struct VertexPool<T> {
    pub(super) items: Vec<T>,
    pub(super) promised: Option<u64>,
}

impl<T> VertexPool<T> {
    const EMPTY: VertexPool<T> = VertexPool {
        items: Vec::new(),
        promised: None,
    };

    /// Adds a vertex. Returns the announced number at the first vertex beyond it, and only there,
    /// as one error is enough.
    pub(super) fn push(&mut self, item: T) -> Option<u64> {
        self.items.push(item);
        let count = self.items.len() as u64;
        self.promised.take_if(|promised| count > *promised)
    }
}

#[derive(Clone, Copy)]
pub(super) struct NormalVertex {
    pub(super) position: DVec3,
    pub(super) normal: Vec3,
}

impl NormalVertex {
    /// Stands in for a faulty vertex, so that triangles that use it are not reported.
    pub(super) const STAND_IN: NormalVertex = NormalVertex {
        position: DVec3::ZERO,
        normal: Vec3::Z,
    };
}

/// Reads a scene from a `.test` file.
///
/// # Errors
/// Faults of the text, in file order.
pub(crate) fn read(bytes: &[u8], _: &Folder, options: &ReadOptions) -> Result<ReadScene, ReadStop> {
    let text = text::utf8(bytes)?;
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
    read_scene::finish(reader.scene, options, reader.report)
}

impl<'a> TestReader<'a> {
    pub(super) fn new(text: &'a str, origin: DVec3) -> Self {
        TestReader {
            report: DiagnosticSink::new(text.as_bytes()),
            scene: Scene::default(),
            seen: SeenCommands::default(),
            origin,
            vertices: VertexPool::EMPTY,
            normal_vertices: VertexPool::EMPTY,
            transforms: Transforms::new(),
            surface: Material::default(),
            table: MaterialTable::default(),
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
}
