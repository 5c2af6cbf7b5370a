//! Modes: what is rendered for each, and the colours of what is not radiance.

use super::protocol::{FrameInfo, ViewMode};
use super::viewed_scene::ViewedScene;
use phalanx::film::Film;
use phalanx::frame::{
    AccelRef, Aov, Aovs, Control, FrameError, Integrator, RayCost, Settings, render_heatmap,
    render_with,
};
use phalanx::image::{Picture, encode, false_colors, jpeg_bytes, layer_colors};
use phalanx::render::RayCounts;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Quality of frames as JPEG, out of 100.
const JPEG_QUALITY: u8 = 85;

/// A picture for a page, and what it says about itself.
#[derive(Debug)]
pub(super) struct ShownPicture {
    pub(super) picture: Picture,
    pub(super) info: FrameInfo,
}

impl ViewMode {
    /// The layer that a mode shows; none for radiance and costs.
    pub(super) fn layer(self) -> Option<Aov> {
        match self {
            ViewMode::Shaded | ViewMode::Ao | ViewMode::Cost => None,
            ViewMode::Normals => Some(Aov::Ns),
            ViewMode::Depth => Some(Aov::Depth),
            ViewMode::Albedo => Some(Aov::Albedo),
            ViewMode::PrimIds => Some(Aov::Primitive),
            ViewMode::MaterialIds => Some(Aov::Material),
        }
    }

    /// Returns true if more samples make the picture better.
    pub(super) fn is_refined(self) -> bool {
        matches!(self, ViewMode::Shaded | ViewMode::Ao)
    }
}

impl ViewedScene {
    /// Renders a picture of any mode with one sample a pixel.
    pub(super) fn paint(
        &self,
        mode: ViewMode,
        settings: &Settings,
        control: &Control,
    ) -> Result<ShownPicture, FrameError> {
        let start = Instant::now();
        let mut info = self.info(settings);
        let (rgb, scale) = match mode.layer() {
            None if mode == ViewMode::Cost => {
                let costs =
                    render_heatmap(&self.scene, &self.bvh, settings, RayCost::Nodes, control)?;
                let (rgb, scale) = false_colors(&costs);
                info.rays["primary"] = json!(settings.pixels());
                (rgb, Some(scale))
            }
            layer => {
                let settings = with_layer(settings, layer);
                let tree = AccelRef::Packets(&self.bvh);
                let frame = render_with(&self.scene, tree, &settings, control)?;
                info.rays = Value::from_iter(frame.stats.rays.by_kind());
                let times = (start.elapsed(), frame.tracing);
                info.set_times(times, settings.threads);
                match layer {
                    Some(aov) => self.colors(aov, &frame.film),
                    None => (self.radiance(&frame.film).rgb, None),
                }
            }
        };
        info.ms = start.elapsed().as_secs_f64() * 1e3;
        info.scale = scale;
        let picture = Picture {
            width: info.width,
            height: info.height,
            rgb,
        };
        Ok(ShownPicture { picture, info })
    }

    /// The account of a frame with these settings, before there is work.
    pub(super) fn info(&self, settings: &Settings) -> FrameInfo {
        let kernel = settings.kernel.for_frame(&self.bvh, settings.camera_rays());
        FrameInfo {
            width: settings.width,
            height: settings.height,
            samples: 1,
            max_depth: settings.max_depth,
            kernel: kernel.name(),
            rays: Value::from_iter(RayCounts::default().by_kind()),
            ..FrameInfo::default()
        }
    }

    /// Radiance as a picture file of the scene would show it.
    pub(super) fn radiance(&self, film: &Film) -> Picture {
        encode(film, self.spec.encoding.exposure(self.scene.encoding))
    }

    /// Colours of a layer, and the value of the lightest.
    fn colors(&self, aov: Aov, film: &Film) -> (Vec<u8>, Option<f32>) {
        if aov != Aov::Albedo {
            return layer_colors(film, aov);
        }
        let mut albedo = Film::new(film.width, film.height, false);
        albedo.planes = [0, 1, 2].map(|channel| film.layer(aov)[channel].clone());
        (self.radiance(&albedo).rgb, None)
    }
}

/// Settings for one layer: bounces and lights change no layer of surfaces.
fn with_layer(settings: &Settings, layer: Option<Aov>) -> Settings {
    let Some(aov) = layer else {
        return settings.clone();
    };
    let distance = f32::MIN_POSITIVE;
    Settings {
        aovs: Aovs::default().with(aov),
        max_depth: 0,
        integrator: Integrator::Occlusion { distance },
        ..settings.clone()
    }
}

impl FrameInfo {
    /// Sets the times of work that took `wall`, of which all threads together traced for `tracing`.
    pub(super) fn set_times(&mut self, (wall, tracing): (Duration, Duration), threads: usize) {
        self.ms = wall.as_secs_f64() * 1e3;
        self.trace_ms = tracing.as_secs_f64() * 1e3 / threads.max(1) as f64;
        self.shade_ms = (self.ms - self.trace_ms).max(0.0);
    }
}

impl ShownPicture {
    /// The picture as it travels, as a JPEG or as raw pixels, and what it says about itself.
    pub(super) fn encode(mut self, as_jpeg: bool) -> (FrameInfo, Vec<u8>) {
        let start = Instant::now();
        let bytes = if as_jpeg {
            jpeg_bytes(&self.picture, JPEG_QUALITY)
        } else {
            self.picture.rgba()
        };
        self.info.encode_ms = start.elapsed().as_secs_f64() * 1e3;
        (self.info, bytes)
    }
}
