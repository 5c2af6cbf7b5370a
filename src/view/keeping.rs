//! Commands that make what is seen, and the files that they write.

use super::protocol::{KeepRequest, ViewMode};
use super::viewed_scene::ViewedScene;
use phalanx::files::shown_text;
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

/// A picture to keep: its description, its file, and that of a heat map beside it.
struct SavedPicture {
    spec: PictureSpec,
    format: ImageFormat,
    name: String,
    heat: Option<String>,
}

impl ViewedScene {
    /// The command that makes a picture.
    pub(super) fn command(&self, request: &KeepRequest) -> String {
        let mut kept = self.kept(request);
        if request.keyframes {
            kept.spec.overrides = self.spec.overrides.clone();
            return format!("{} --keyframes {KEYFRAMES}", kept.spec.command(&kept.name));
        }
        let command = kept.spec.command(&kept.name);
        match kept.heat {
            Some(heat) => format!("{command} --heat nodes {heat}"),
            None => command,
        }
    }

    /// The name and the bytes of the file that the command writes; of the heat map, if that is what
    /// is seen. `film` is the picture, if it is there already.
    pub(super) fn file(
        &self,
        request: &KeepRequest,
        film: Option<&Film>,
        control: &Control,
    ) -> Result<(String, Vec<u8>), FrameError> {
        let SavedPicture {
            spec,
            format,
            name,
            heat,
        } = self.kept(request);
        let settings = Settings {
            threads: self.settings(request.shot.mode, request.shot.size).threads,
            ..spec.pixels.settings(&self.scene)
        };
        let (scene, bvh) = (&self.scene, &self.bvh);
        if let Some(heat) = heat {
            let cost = RayCost::Nodes;
            let costs = render_heatmap(scene, bvh, &settings, cost, control)?;
            let picture = false_color(&costs, settings.width, cost.title());
            return Ok((heat, png_bytes(&picture)));
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
        match write_bands(&mut bytes, &file, [Ok(film)]) {
            Ok(()) => Ok((name, bytes)),
            Err(_) => Ok((name, Vec::new())),
        }
    }

    fn kept(&self, request: &KeepRequest) -> SavedPicture {
        let KeepRequest { shot, samples, .. } = request;
        let mode = shot.mode;
        let samples = if mode.is_refined() { *samples } else { 1 };
        let mut spec = self.picture(shot, samples);
        let name = Path::new(&self.spec.scene);
        let stem = match phalanx::open::standard_name(name) {
            Some(name) => name.split(':').nth(1).unwrap_or_default().into(),
            None => name.file_stem().unwrap_or_default().to_string_lossy(),
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        let stem: String = shown_text(&stem)
            .chars()
            .map(|c| if plain(c) { c } else { '_' })
            .collect();
        let stem = stem.trim_start_matches(['-', '.']);
        let stem = if stem.is_empty() { "view" } else { stem };
        let mut format = ImageFormat::Png;
        if let Some((layer, _)) = mode.layer() {
            // What is seen as colours is kept as numbers.
            format = ImageFormat::Exr;
            spec.pixels.aov = vec![layer.to_owned()];
            spec.encoding = EncodingSpec::default();
        }
        SavedPicture {
            spec,
            name: format!("{stem}.{}", format.ending()),
            format,
            heat: (mode == ViewMode::Cost).then(|| format!("{stem}-nodes.png")),
        }
    }
}
