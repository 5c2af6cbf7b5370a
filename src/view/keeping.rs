//! Commands that make what is seen, and the files that they write.

use super::protocol::{KeepRequest, ViewMode};
use super::queue::PageAnswer;
use super::viewed_scene::ViewedScene;
use phalanx::film::{Aovs, Film};
use phalanx::frame::{
    AccelRef, Control, FrameError, RayCost, Settings, render_heatmap, render_with,
};
use phalanx::image::{ImageFormat, false_color, png_bytes, write_bands};
use phalanx::jobs::spec::{AsText, set_header};
use phalanx::jobs::{EncodingSpec, PictureSpec, measure_exposure};
use serde_json::json;
use std::path::Path;

/// File of key frames, as the page saves it.
const KEYFRAMES: &str = "views.txt";

impl ViewedScene {
    /// The command that makes a picture. Refuses one that the command could not make.
    pub(super) fn command(&self, request: &KeepRequest) -> Result<PageAnswer, FrameError> {
        let (mut spec, format) = self.description(request);
        spec.pixels.settings(&self.scene).camera(&self.scene)?;
        if !spec.has_exact_name() {
            let reason = "the scene's name is not valid UTF-8: rename it to get a command";
            return Ok(PageAnswer::Refused(reason.to_owned()));
        }
        let costs = self.free_name("-nodes", ImageFormat::Png);
        let mut more = Vec::new();
        if request.keyframes {
            spec.overrides = self.spec.overrides.clone();
            more.extend(["--keyframes", KEYFRAMES]);
        } else if request.shot.mode == ViewMode::Cost {
            // Nodes are those of the tree.
            if let Some(quality) = self.facts.quality {
                more.extend(["--quality", quality.name()]);
            }
            more.extend(["--heat", "nodes", &costs]);
        }
        let command = spec.command(&self.scene, &self.free_name("", format), &more);
        Ok(PageAnswer::Json(json!({ "command": command })))
    }

    /// The exposure that suits a picture, in stops.
    pub(super) fn exposure(
        &self,
        request: &KeepRequest,
        control: &Control,
    ) -> Result<PageAnswer, FrameError> {
        let KeepRequest { shot, .. } = request;
        let settings = self.settings(shot.mode, shot.size);
        let tree = AccelRef::Packets(&self.bvh);
        let stops = measure_exposure(&self.scene, tree, &settings, control)?;
        Ok(PageAnswer::Json(json!({ "exposure": stops })))
    }

    /// The file that the command writes; the heat map, if that is what is seen. `film` is the
    /// picture, if it is there already.
    pub(super) fn file(
        &self,
        request: &KeepRequest,
        film: Option<&Film>,
        control: &Control,
    ) -> Result<PageAnswer, FrameError> {
        let (spec, format) = self.description(request);
        let settings = Settings {
            threads: self.settings(request.shot.mode, request.shot.size).threads,
            ..spec.pixels.settings(&self.scene)
        };
        let (scene, bvh) = (&self.scene, &self.bvh);
        if request.shot.mode == ViewMode::Cost {
            let cost = RayCost::Nodes;
            let costs = render_heatmap(scene, bvh, &settings, cost, control)?;
            let picture = false_color(&costs, settings.width, cost.title());
            let name = self.free_name("-nodes", ImageFormat::Png);
            return Ok(PageAnswer::File(name, png_bytes(&picture)));
        }
        let film = match film {
            Some(film) => film.clone(),
            None => render_with(scene, AccelRef::Packets(bvh), &settings, control)?.film,
        };
        let spec = spec.resolve(scene);
        let mut file = spec.file(format, scene.origin);
        set_header(&mut file, spec.header(scene, false));
        let mut bytes = Vec::new();
        // Writing to memory does not fail; if it did, there would be no picture.
        if write_bands(&mut bytes, &file, [Ok(film)]).is_err() {
            bytes.clear();
        }
        Ok(PageAnswer::File(self.free_name("", format), bytes))
    }

    /// The description of a picture to keep, and its format: what is seen as colours is kept as
    /// numbers.
    fn description(&self, request: &KeepRequest) -> (PictureSpec, ImageFormat) {
        let KeepRequest { shot, samples, .. } = request;
        let samples = if shot.mode.is_refined() { *samples } else { 1 };
        let mut spec = self.picture(shot, samples);
        let Some(layer) = shot.mode.layer() else {
            return (spec, ImageFormat::Png);
        };
        spec.pixels.aov = vec![AsText(Aovs::default().with(layer))];
        spec.encoding = EncodingSpec::default();
        (spec, ImageFormat::Exr)
    }

    /// The default name of a picture, with a suffix to its stem, in characters that no shell and no
    /// header minds.
    fn free_name(&self, suffix: &str, format: ImageFormat) -> String {
        let ending = format.ending();
        let free = (self.facts.free_name)(format!("{}.{ending}", self.stem()).as_ref());
        let stem = free.file_stem().unwrap_or_default();
        format!("{}{suffix}.{ending}", stem.display())
    }

    fn stem(&self) -> String {
        let stem = phalanx::open::stem(Path::new(&self.spec.scene)).unwrap_or_default();
        let stem = stem.to_string_lossy();
        let plain = |c: &char| c.is_ascii_alphanumeric() || "-_.".contains(*c);
        let stem: String = stem.chars().filter(plain).collect();
        match stem.trim_start_matches(['-', '.']) {
            "" => "view".to_owned(),
            stem => stem.to_owned(),
        }
    }
}
