//! The reader: its state, and its steps at the end of the file.

use super::lexer::NffTokens;
use super::materials::NffMaterials;
use crate::diagnostics::{DiagnosticSink, Span};
use crate::folder::Folder;
use crate::options::ReadOptions;
use crate::origin::ReadStop;
use crate::read_scene::{self, ReadScene};
use crate::text;
use glam::{DVec3, Vec3};
use phalanx_scene::Scene;

/// Bounces after the eye ray: the databases' depth of 5 counts that ray.
const MAX_DEPTH: u32 = 4;

/// The result of the records so far.
pub(super) struct NffReader<'a> {
    pub(super) tokens: NffTokens<'a>,
    pub(super) report: DiagnosticSink<'a>,
    pub(super) scene: Scene,
    /// The origin, subtracted from positions before they are rounded.
    pub(super) origin: DVec3,
    pub(super) lights: Vec<NffLight>,
    pub(super) materials: NffMaterials,
    pub(super) seen: SeenRecords,
}

/// A point light; without a colour it gets its intensity at the end.
pub(super) struct NffLight {
    pub(super) position: Vec3,
    pub(super) color: Option<Vec3>,
}

/// Records that have occurred, faulty or not.
#[derive(Default)]
pub(super) struct SeenRecords {
    pub(super) view: bool,
    pub(super) background: bool,
    pub(super) shape: bool,
}

/// Reads a scene from an NFF file.
///
/// # Errors
/// Faults of the text, in file order.
pub(crate) fn read(bytes: &[u8], _: &Folder, options: &ReadOptions) -> Result<ReadScene, ReadStop> {
    let text = text::utf8(bytes)?;
    let mut reader = NffReader {
        tokens: NffTokens::new(text),
        report: DiagnosticSink::new(text.as_bytes()),
        scene: Scene {
            max_depth: MAX_DEPTH,
            ..Scene::default()
        },
        origin: options.origin.position(),
        lights: Vec::new(),
        materials: NffMaterials::new(options.material),
        seen: SeenRecords::default(),
    };
    if text.trim_start_matches('\u{feff}').trim().is_empty() {
        reader.report.error(Span::START, "the file is empty");
    } else if !reader.refuse_sense8() {
        while reader.record() && !reader.report.is_full() {}
    }
    reader.finish(options)
}

impl NffReader<'_> {
    /// Refuses Sense8's format of the same name and ending, which begins with its name.
    fn refuse_sense8(&mut self) -> bool {
        let first = self.tokens.peek();
        let sense8 = first.filter(|token| token.text.eq_ignore_ascii_case("nff"));
        if let Some(token) = sense8 {
            self.report.error_with_help(
                token.span(),
                "this is Sense8's NFF, which has nothing but the name in common with the NFF that is read here",
                "convert it to OBJ or glTF",
            );
        }
        sense8.is_some()
    }

    fn finish(mut self, options: &ReadOptions) -> Result<ReadScene, ReadStop> {
        if !self.seen.shape && self.report.is_clean() {
            let end = self.report.end_of_content();
            self.report
                .warning(end, "the file has no primitives: the picture will be empty");
        }
        let level = level(self.lights.len());
        for light in &self.lights {
            let color = light.color.unwrap_or(Vec3::splat(level as f32));
            self.scene.lights.add_point(light.position, color, Vec3::X);
        }
        self.materials.settle(level, &mut self.scene);
        self.scene.defaulted.view = !self.seen.view;
        self.scene.defaulted.light = self.lights.is_empty();
        read_scene::finish(self.scene, options, self.report)
    }
}

/// NFF's level of light and of ambient light for `lights` lights: √n/(2n). Without any light it is
/// that of the one light that is added then.
pub fn level(lights: usize) -> f64 {
    let n = lights.max(1) as f64;
    n.sqrt() / (2.0 * n)
}
