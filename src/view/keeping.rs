//! Commands that make what is seen, and the files that they write.

use super::protocol::{KeepRequest, ViewMode};
use super::queue::PageAnswer;
use super::viewed_scene::ViewedScene;
use phalanx::film::Film;
use phalanx::frame::{
    AccelRef, Control, FrameError, RayCost, Settings, render_heatmap, render_with,
};
use phalanx::image::{ImageFormat, false_color, png_bytes, write_bands};
use phalanx::jobs::spec::set_header;
use phalanx::jobs::{EncodingSpec, PictureSpec};
use std::path::Path;

/// File of key frames, as the page saves it.
const KEYFRAMES: &str = "views.txt";

impl ViewedScene {
    /// The command that makes a picture.
    pub(super) fn command(&self, request: &KeepRequest) -> String {
        let (mut spec, format) = self.kept(request);
        let stem = self.stem();
        let output = format!("{stem}.{}", format.ending());
        if request.keyframes {
            spec.overrides = self.spec.overrides.clone();
            return format!(
                "{} --keyframes {KEYFRAMES}",
                spec.command(&self.scene, &output)
            );
        }
        match request.shot.mode {
            ViewMode::Cost => format!(
                "{} --heat nodes {stem}-nodes.png",
                spec.command(&self.scene, &output)
            ),
            _ => spec.command(&self.scene, &output),
        }
    }

    /// The file that the command writes; the heat map, if that is what is seen. `film` is the
    /// picture, if it is there already.
    pub(super) fn file(
        &self,
        request: &KeepRequest,
        film: Option<&Film>,
        control: &Control,
    ) -> Result<PageAnswer, FrameError> {
        let ((spec, format), stem) = (self.kept(request), self.stem());
        let settings = Settings {
            threads: self.settings(request.shot.mode, request.shot.size).threads,
            ..spec.pixels.settings(&self.scene)
        };
        let (scene, bvh) = (&self.scene, &self.bvh);
        if request.shot.mode == ViewMode::Cost {
            let cost = RayCost::Nodes;
            let costs = render_heatmap(scene, bvh, &settings, cost, control)?;
            let picture = false_color(&costs, settings.width, cost.title());
            let contents = Box::new(move || png_bytes(&picture));
            return Ok(PageAnswer::File(format!("{stem}-nodes.png"), contents));
        }
        let film = match film {
            Some(film) => film.clone(),
            None => render_with(scene, AccelRef::Packets(bvh), &settings, control)?.film,
        };
        let spec = spec.resolve(scene);
        let mut file = spec.file(format, scene.origin);
        set_header(&mut file, spec.header(scene, false));
        let contents = move || {
            let mut bytes = Vec::new();
            // Writing to memory does not fail; if it did, there would be no picture.
            match write_bands(&mut bytes, &file, [Ok(film)]) {
                Ok(()) => bytes,
                Err(_) => Vec::new(),
            }
        };
        let name = format!("{stem}.{}", format.ending());
        Ok(PageAnswer::File(name, Box::new(contents)))
    }

    /// The description of a picture to keep, and its format: what is seen as colours is kept as
    /// numbers.
    fn kept(&self, request: &KeepRequest) -> (PictureSpec, ImageFormat) {
        let KeepRequest { shot, samples, .. } = request;
        let samples = if shot.mode.is_refined() { *samples } else { 1 };
        let mut spec = self.picture(shot, samples);
        let Some((layer, _)) = shot.mode.layer() else {
            return (spec, ImageFormat::Png);
        };
        spec.pixels.aov = vec![layer.to_owned()];
        spec.encoding = EncodingSpec::default();
        (spec, ImageFormat::Exr)
    }

    /// The scene's name for files, in characters that no shell and no header minds.
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
