//! The scene that is viewed, its tree, and the options of its pictures.

use super::protocol::{Shot, ViewMode};
use glam::DVec3;
use phalanx::Bvh;
use phalanx::formats::DefaultLights;
use phalanx::frame::{Integrator, Quality, Settings};
use phalanx::image::ToneCurve;
use phalanx::isa;
use phalanx::jobs::spec::IntegratorName;
use phalanx::jobs::{EncodingSpec, ExposureSpec, PictureSpec, PixelSpec};
use phalanx::scene::{FileView, Scene};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Samples at which a picture at rest is good enough, where no option says otherwise.
const SAMPLES: u32 = 64;

/// Bytes of a pixel of a picture at rest: sums of its samples, two films, two pictures.
const STILL_BYTES: u64 = 110;

/// Bytes of a pixel of a frame that waits to be read, and of a file that is being made.
pub(super) const FRAME_BYTES: u64 = 10;
pub(super) const FILE_BYTES: u64 = 70;

/// Bytes of a pixel of all pictures of a page at least.
pub const PIXEL_BYTES: u64 = STILL_BYTES + FILE_BYTES;

/// Cosine of the angle between the up vector of a camera and the up axis beyond which it lies on
/// its side.
const LYING: f64 = 0.3;

/// Facts that only the program knows.
pub struct ViewedFacts {
    /// Bytes that pictures and answers may take.
    pub memory: u64,
    /// Quality of the tree, if it is not the usual one.
    pub quality: Option<Quality>,
    /// The name of a file like this one that replaces no other.
    pub free_name: fn(&Path) -> PathBuf,
}

/// The scene, seen by whichever page has its turn.
pub struct ViewedScene {
    pub(super) scene: Scene,
    pub(super) bvh: Bvh,
    /// The picture, with the exposure and the tone curve of the page that has its turn.
    pub(super) spec: PictureSpec,
    /// The encoding that the options give.
    encoding: EncodingSpec,
    settings: Settings,
    /// Most pixels of pictures at rest, all pages together.
    pub(super) most_pixels: u64,
    pub(super) facts: ViewedFacts,
    lights: DefaultLights,
    occlusion: Integrator,
    /// The scene's own view, and its number among the cameras of the file.
    view: FileView,
    camera: Option<usize>,
}

impl ViewedScene {
    /// A scene with its tree, and the options of its pictures.
    pub fn new(
        scene: Scene,
        bvh: Bvh,
        spec: PictureSpec,
        settings: Settings,
        facts: ViewedFacts,
    ) -> ViewedScene {
        let lights = DefaultLights::of(&scene, settings.threads);
        let occluded = PixelSpec {
            integrator: Some(IntegratorName::Ao),
            ..spec.pixels.clone()
        };
        ViewedScene {
            view: scene.shortest_view(&scene.view),
            occlusion: occluded.settings(&scene).integrator,
            camera: scene.used_camera(),
            scene,
            bvh,
            encoding: spec.encoding.clone(),
            spec,
            settings,
            most_pixels: facts.memory / PIXEL_BYTES,
            facts,
            lights,
        }
    }

    /// Takes a shot's exposure and tone curve, moves the camera, and the lights that follow it.
    pub(super) fn look(&mut self, shot: &Shot) -> Result<(), String> {
        let stops = shot.exposure.map(ExposureSpec::Stops);
        let (stops, curve) = (
            stops.or(self.encoding.exposure),
            shot.tone.or(self.encoding.curve),
        );
        let encoding = &mut self.spec.encoding;
        encoding.exposure = stops.filter(|given| given.stops() != 0.0);
        encoding.curve = curve.filter(|curve| curve.0 != ToneCurve::Linear);
        let scene = &mut self.scene;
        self.lights.move_camera(scene, scene.view_of(&shot.view));
        scene.defaulted.view = false;
        scene.view.basis().map_err(|error| error.to_string())?;
        if scene.is_in_safe_range() {
            Ok(())
        } else {
            Err("the camera is too far away".to_owned())
        }
    }

    /// The settings of a mode's picture of this size, with one sample a pixel.
    pub(super) fn settings(&self, mode: ViewMode, size: (u32, u32)) -> Settings {
        let mut settings = self.settings.clone();
        (settings.width, settings.height) = size;
        settings.sampling.spp = 1;
        if mode == ViewMode::Ao {
            settings.integrator = self.occlusion;
        }
        settings
    }

    /// The description of a picture with this many samples.
    pub(super) fn picture(&self, shot: &Shot, samples: u32) -> PictureSpec {
        let mut spec = self.spec.clone();
        spec.overrides = spec.overrides.with_view(&self.scene, &shot.view);
        (spec.pixels.size, spec.pixels.spp) = (Some(shot.size), Some(samples));
        if shot.mode == ViewMode::Ao {
            spec.pixels.integrator = Some(IntegratorName::Ao);
        }
        spec
    }

    /// The axis that points up: that of the file's format, unless the scene's camera lies on its
    /// side there.
    fn up(&self) -> DVec3 {
        let axis = self.scene.defaulted.up.frame()[1];
        let own = self.view.up.as_dvec3().normalize_or(axis);
        if own.dot(axis) > LYING {
            axis
        } else {
            let axis = own.abs().max_position();
            DVec3::AXES[axis] * own[axis].signum()
        }
    }

    /// The reason why nothing can be seen, if the scene is a point.
    pub fn warning(&self) -> Option<String> {
        let wrong = self.view.check().err();
        wrong.map(|wrong| format!("nothing can be seen: {wrong} (see --camera)"))
    }

    /// Facts that a page has to know before it asks for frames.
    pub(super) fn describe(&self) -> Value {
        let scene = &self.scene;
        let bounds = scene.bounds();
        let corner = |point| scene.file_position(point).to_array();
        let cameras = scene.cameras.iter().map(|camera| {
            let view = scene.shortest_view(&camera.view);
            json!({ "name": scene.names.get(camera.name), "view": view })
        });
        let name = Path::new(&self.spec.scene);
        let name = name.file_name().unwrap_or(name.as_os_str());
        json!({
            "name": name.to_string_lossy(),
            "primitives": scene.id_count(),
            "engine": "simd",
            "threads": self.settings.threads,
            "isa": isa::compiled_level().to_string(),
            "version": env!("CARGO_PKG_VERSION"),
            "up": self.up().to_array(),
            "bounds": [corner(bounds.lo), corner(bounds.hi)],
            "view": self.view,
            "camera": self.camera,
            "cameras": cameras.collect::<Vec<_>>(),
            "size": self.spec.pixels.size,
            "most_pixels": self.most_pixels,
            "warning": self.warning(),
            "samples": self.spec.pixels.spp.unwrap_or(SAMPLES),
            "exposure": self.encoding.exposure.map_or(0.0, ExposureSpec::stops),
            "tone": self.encoding.curve.unwrap_or_default(),
        })
    }
}
