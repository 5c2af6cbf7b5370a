//! Modes: what is rendered for each, and the colours of what is not radiance.

use super::protocol::{FrameEncoding, FrameInfo, ViewMode};
use super::viewed_scene::ViewedScene;
use phalanx::film::Film;
use phalanx::frame::{
    AccelRef, Aov, Aovs, Control, FrameError, Integrator, RayCost, Settings, render_heatmap,
    render_with,
};
use phalanx::image::{Picture, encode, false_colors, jpeg_bytes};
use phalanx::render::RayCounts;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Quality of frames as JPEG, out of 100.
const JPEG_QUALITY: u8 = 85;

/// Colour of the background where it has no value.
const NOTHING: [u8; 3] = [24, 26, 30];

/// A picture for a page, and what it says about itself.
#[derive(Debug)]
pub(super) struct ShownPicture {
    pub(super) picture: Picture,
    pub(super) info: FrameInfo,
}

impl ViewMode {
    /// The layer that a mode shows, with its name; none for radiance and costs.
    pub(super) fn layer(self) -> Option<(&'static str, Aov)> {
        let aov = match self {
            ViewMode::Shaded | ViewMode::Ao | ViewMode::Cost => return None,
            ViewMode::Normals => Aov::Ns,
            ViewMode::Depth => Aov::Depth,
            ViewMode::Albedo => Aov::Albedo,
            ViewMode::PrimIds => Aov::Primitive,
            ViewMode::MaterialIds => Aov::Material,
        };
        Aov::ALL.into_iter().find(|(_, known)| *known == aov)
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
                (rgb, Some(scale))
            }
            layer => {
                let settings = with_layer(settings, layer.map(|(_, aov)| aov));
                let tree = AccelRef::Packets(&self.bvh);
                let frame = render_with(&self.scene, tree, &settings, control)?;
                info.rays = rays_by_kind(&frame.stats.rays);
                let times = (start.elapsed(), frame.tracing);
                info.set_times(times, settings.threads);
                match layer {
                    Some((_, aov)) => self.colors(aov, &frame.film),
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
            ..FrameInfo::default()
        }
    }

    /// Radiance as a picture file of the scene would show it.
    pub(super) fn radiance(&self, film: &Film) -> Picture {
        encode(film, self.spec.encoding.exposure(self.scene.encoding))
    }

    /// Colours of a layer, and the value of the lightest.
    fn colors(&self, aov: Aov, film: &Film) -> (Vec<u8>, Option<f32>) {
        let planes = film.layer(aov);
        match aov {
            Aov::Depth => {
                let (mut rgb, scale) = false_colors(&planes[0]);
                for (pixel, depth) in rgb.as_chunks_mut().0.iter_mut().zip(&planes[0]) {
                    if depth.is_infinite() {
                        *pixel = NOTHING;
                    }
                }
                (rgb, Some(scale))
            }
            Aov::Ns => {
                let byte = |c: f32| ((0.5 * c + 0.5) * 255.0).round() as u8;
                let pixels = (0..planes[0].len()).flat_map(|k| {
                    let normal = [0, 1, 2].map(|axis| planes[axis][k]);
                    match normal == [0.0; 3] {
                        true => NOTHING,
                        false => normal.map(byte),
                    }
                });
                (pixels.collect(), None)
            }
            Aov::Albedo => {
                let mut albedo = Film::new(film.width, film.height, false);
                albedo.planes = [0, 1, 2].map(|channel| planes[channel].clone());
                (self.radiance(&albedo).rgb, None)
            }
            _ => {
                let ids = planes[0].iter().map(|id| id.to_bits());
                (ids.flat_map(color_of_id).collect(), None)
            }
        }
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

/// A colour for a number; neighbours differ. The constants are those of MurmurHash3's last step.
fn color_of_id(id: u32) -> [u8; 3] {
    if id == phalanx::film::NO_ID {
        return NOTHING;
    }
    let mixed = (id ^ id >> 16).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ mixed >> 13).wrapping_mul(0xc2b2_ae35);
    let [r, g, b, _] = (mixed ^ mixed >> 16).to_le_bytes();
    [r, g, b].map(|c| 64 + c / 4 * 3)
}

/// Numbers of rays for the page.
pub(super) fn rays_by_kind(rays: &RayCounts) -> Value {
    json!({
        "primary": rays.primary,
        "shadow": rays.shadow,
        "reflection": rays.reflection,
        "refraction": rays.refraction,
    })
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
    /// The picture as it travels, and what it says about itself.
    pub(super) fn encode(self, encoding: FrameEncoding) -> (FrameInfo, Vec<u8>) {
        let start = Instant::now();
        let ShownPicture { picture, mut info } = self;
        let bytes = match encoding {
            FrameEncoding::Jpeg => jpeg_bytes(&picture, JPEG_QUALITY),
            FrameEncoding::Raw => picture.rgba(),
        };
        info.encode_ms = start.elapsed().as_secs_f64() * 1e3;
        (info, bytes)
    }
}
