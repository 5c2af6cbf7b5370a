//! Settings of a render: everything that a picture depends on, except for the scene.

use super::error::FrameError;
use crate::{Aov, Aovs, CoreAffinity, Tile, WaveSizes};
use phalanx_oracle::camera_ray;
use phalanx_scene::camera::{Camera, Lens};
use phalanx_scene::sampling::Sampling;
use phalanx_scene::{IntegratorSettings, Scene};
use phalanx_trace::Kernel;

/// Selects the tracer. Both give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Eight-wide packets.
    Simd,
    /// The scalar oracle.
    Scalar,
}

/// The quantity that is computed at a hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Integrator {
    /// Light that falls on it from lights, and by mirror and refracted rays.
    #[default]
    Whitted,
    /// Ambient occlusion: the share of the sky that is open above a hit, weighted by the cosine.
    /// One ray is sent per camera ray, so that only the mean over many is between black and white.
    /// A partly transparent surface counts as opaque. Colours, lights and bounces are omitted; rays
    /// that hit nothing have the background.
    Occlusion {
        /// Distance beyond which hits are ignored, in units of the scene's file; it may be
        /// infinite.
        distance: f32,
    },
}

impl Integrator {
    /// Ambient occlusion within a tenth of the diagonal of the scene's bounds, to two digits: far
    /// enough for the folds of an object, and near enough for a closed room not to be black.
    /// Unlimited for a scene without extent.
    pub fn occlusion(scene: &Scene) -> Integrator {
        let bounds = scene.bounds();
        let diagonal = bounds.hi.as_dvec3().distance(bounds.lo.as_dvec3());
        let share = diagonal / 10.0 / f64::from(scene.scale);
        let distance = format!("{share:.1e}").parse().unwrap_or(f32::INFINITY);
        let distance = if distance > 0.0 { distance } else { f32::INFINITY };
        Integrator::Occlusion { distance }
    }
}

/// Settings of a render; the [`Scene`] holds what is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// The part of the picture that is rendered; `None` is all of it.
    pub region: Option<Tile>,
    /// Bounces after the primary ray.
    pub max_depth: u32,
    /// Minimum weight for a bounce to be traced. The weight is the product of the weights along its
    /// path (Ks of mirror rays, Kt of refracted ones, Ks + Kt at total reflection). A bounce is
    /// traced only if this product is at least `min_weight` in some component.
    ///
    /// For this product, not for the light, weights are divided by |Ks| + |Kt| where that is more
    /// than 1. So the rays of one depth have no more weight than their camera ray, and no more than
    /// 3/`min_weight` of them are traced, regardless of the materials. With 0, all are traced.
    /// `None` means [`Settings::min_path_weight`], NaN is an error.
    pub min_weight: Option<f32>,
    /// Camera rays per pixel.
    pub sampling: Sampling,
    /// Lens that camera rays come through, in units of the scene's file; `None` is a pinhole. The
    /// point where a ray passes through the lens is random even with one ray per pixel.
    pub lens: Option<Lens>,
    /// The quantity that is computed where camera rays hit.
    pub integrator: Integrator,
    /// Worker threads, at least 1.
    pub threads: usize,
    /// Binding of workers to cores.
    pub pin: CoreAffinity,
    /// Tile side in pixels, 8 to 1024.
    pub tile: u32,
    /// Tracer.
    pub engine: Engine,
    /// Kernel of the packet engine.
    pub kernel: Kernel,
    /// Further outputs that the film holds for each pixel.
    pub aovs: Aovs,
    /// True if the film keeps primary hits, those of each pixel's first camera ray.
    pub record_hits: bool,
}

/// Tile side of [`Settings::of`]: 1024 rays fill the packets of their bounces and stay within the
/// level 2 cache.
pub const DEFAULT_TILE: u32 = 32;

/// Default minimum weight of a bounce, if a ray may take more than [`FULL_DEPTH`] bounces.
///
/// Chosen so that ordinary pictures do not change, and deep ones finish. Weights of 2⁻¹² and less
/// still change some samples of 8 bits: if a sum is at the boundary of two values, one unit in the
/// last place decides. Only at 2⁻²⁴ does no picture of the project change, but then a closed room
/// of Ks = Kt = 0.5 takes 2²⁵ rays per camera ray. At 2⁻¹² it takes 2¹³ at most, and so do rooms of
/// greater Ks and Kt. Therefore rays that are limited by depth alone are all traced, and the rays
/// of deeper pictures are traced down to this weight.
pub const MIN_WEIGHT: f32 = 1.0 / 4096.0;

/// Number of bounces up to which all are traced if no minimum weight is given: no more than 2¹¹
/// rays per camera ray.
pub const FULL_DEPTH: u32 = 10;

impl Settings {
    /// The scene's own size and depth, one ray through the centre of each pixel (four rays if the
    /// scene's [format](phalanx_scene::DefaultedParts::samples) prescribes no number), one thread,
    /// the packet engine. If rays may pass partly transparent surfaces, the minimum weight of
    /// bounces is 2⁻¹² at any depth.
    pub fn of(scene: &Scene) -> Settings {
        Settings {
            width: scene.width,
            height: scene.height,
            region: None,
            max_depth: scene.max_depth,
            // Rays that pass surfaces are not limited by the depth.
            min_weight: scene.has_coverage().then_some(MIN_WEIGHT),
            sampling: if scene.defaulted.samples { Sampling::SMOOTH } else { Sampling::CENTER },
            lens: None,
            integrator: Integrator::default(),
            threads: 1,
            pin: CoreAffinity::None,
            tile: DEFAULT_TILE,
            engine: Engine::Simd,
            kernel: Kernel::Auto,
            aovs: Aovs::default(),
            record_hits: false,
        }
    }

    /// The window that is rendered: the region, as far as it lies in the picture, or all of the
    /// picture.
    pub fn window(&self) -> Tile {
        let picture = Tile::whole(self.width, self.height);
        self.region.map_or(picture, |region| region.within(picture))
    }

    /// Side of the tiles: from 8 to 1024, a multiple of 8.
    pub fn tile_side(&self) -> u32 {
        self.tile.clamp(8, 1024).next_multiple_of(8)
    }

    /// The camera that takes the picture, if these settings describe one.
    ///
    /// # Errors
    /// [`FrameError`], except for interruption.
    pub fn camera(&self, scene: &Scene) -> Result<Camera, FrameError> {
        if self.window().pixels() == 0 {
            return Err(FrameError::NoPixels);
        }
        if self.min_path_weight().is_nan() {
            return Err(FrameError::MinWeight);
        }
        let camera = Camera::new(&scene.view, self.width, self.height)?;
        Ok(match self.lens {
            Some(Lens { aperture, focus }) => camera.with_lens(Lens {
                aperture: aperture * scene.scale,
                focus: focus * scene.scale,
            })?,
            None => camera,
        })
    }

    /// Origin and direction of a pixel's first camera ray, in units of the scene.
    ///
    /// # Errors
    /// Those of [`Settings::camera`].
    pub fn first_ray(&self, scene: &Scene, x: u32, y: u32) -> Result<[[f32; 3]; 2], FrameError> {
        let (ray, _) = camera_ray(&self.camera(scene)?, &self.sampling, x, y, 0);
        Ok([ray.org, ray.dir].map(|v| v.to_array()))
    }

    /// The settings that both engines take, in units of the scene.
    pub fn integrator_settings(&self, scene: &Scene) -> IntegratorSettings {
        IntegratorSettings {
            max_depth: self.max_depth,
            min_weight: self.min_path_weight(),
            ao_distance: match self.integrator {
                Integrator::Whitted => None,
                Integrator::Occlusion { distance } => Some(distance * scene.scale),
            },
            hides_background: self.aovs.has(Aov::Alpha),
        }
    }

    /// Minimum weight of bounces: the given one, or else 0 for a maximum depth of up to
    /// [`FULL_DEPTH`] and [`MIN_WEIGHT`] beyond.
    pub fn min_path_weight(&self) -> f32 {
        let by_depth = match self.max_depth {
            0..=FULL_DEPTH => 0.0,
            _ => MIN_WEIGHT,
        };
        self.min_weight.unwrap_or(by_depth)
    }

    /// Numbers of rays that the packet engine traces together.
    pub fn wave_sizes(&self, scene: &Scene) -> WaveSizes {
        let max_depth = match self.integrator {
            Integrator::Whitted => self.max_depth,
            Integrator::Occlusion { .. } => 0,
        };
        WaveSizes::of(scene, max_depth, self.min_path_weight())
    }

    /// Number of pixels that are rendered.
    pub fn pixels(&self) -> u64 {
        self.window().pixels()
    }

    /// Number of camera rays for all rendered pixels, at `spp` each.
    pub fn camera_rays(&self) -> u64 {
        self.pixels() * u64::from(self.sampling.spp)
    }
}
