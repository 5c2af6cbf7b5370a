//! NFF, Eric Haines' neutral file format: tokens, of which a record takes as many as it needs.
//!
//! [`read`] walks the records, each of which runs its row of `records::RECORDS` on a [`NffReader`].
//! A faulty record leaves a diagnostic, and reading continues where the next record begins. Ambient
//! light and the intensity of lights depend on the number of lights, so both are computed at the
//! end of the file.

mod lexer;
mod materials;
mod records;
mod shapes;
mod view;

use super::defaults::{MissingParts, finish_scene};
use super::diagnostics::{DiagnosticSink, Span};
use super::origin::ReadStop;
use super::{Loaded, Options};
use glam::{DVec3, Vec3};
use lexer::NffTokens;
use materials::NffMaterials;
use phalanx_scene::Scene;

/// Bounces after the eye ray: the databases' depth of 5 counts that ray.
const MAX_DEPTH: u32 = 4;

/// The result of the records so far.
struct NffReader<'a> {
    tokens: NffTokens<'a>,
    report: DiagnosticSink<'a>,
    scene: Scene,
    /// The origin, subtracted from positions before they are rounded.
    origin: DVec3,
    lights: Vec<NffLight>,
    materials: NffMaterials,
    seen: SeenRecords,
}

/// A point light; without a colour it gets its intensity at the end.
struct NffLight {
    position: Vec3,
    color: Option<Vec3>,
}

/// Records that have occurred, faulty or not.
#[derive(Default)]
struct SeenRecords {
    view: bool,
    background: bool,
    shape: bool,
}

/// Reads a scene from the text of an NFF file.
///
/// # Errors
/// Faults of the text, in file order: at least one and at most [`super::MAX_DIAGNOSTICS`]
/// diagnostics.
pub(super) fn read(text: &str, options: &Options) -> Result<Loaded, ReadStop> {
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
                token.place(),
                "this is Sense8's NFF, which has nothing but the name in common with the NFF that is read here",
                "convert it to OBJ or glTF",
            );
        }
        sense8.is_some()
    }

    fn finish(mut self, options: &Options) -> Result<Loaded, ReadStop> {
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
        let missing = MissingParts {
            view: !self.seen.view,
            lights: self.lights.is_empty(),
            background: false,
        };
        finish_scene(self.scene, &missing, options, self.report)
    }
}

/// The databases' intensity of a light and of ambient light where there are `lights` lights:
/// √n/(2n). Without any light it is that of the one light that is added then.
fn level(lights: usize) -> f64 {
    let n = lights.max(1) as f64;
    n.sqrt() / (2.0 * n)
}
