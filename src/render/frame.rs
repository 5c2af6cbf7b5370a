//! One whole frame: an engine, its tree, tiles handed to workers, a film.

pub use crate::{Aov, Aovs, Control, CoreAffinity, Interrupted, RayCost, Tile};
use crate::{
    Film, HeatmapRenderer, RadianceAovs, RenderStats, RenderedTiles, SharedFilm, SurfaceAov,
    TileBuffer, TileRenderer, TileSink, WaveSizes, WavefrontRenderer, render_on_workers, tiles,
};
use glam::Vec3;
use phalanx_oracle::{self, Oracle, OracleSearch, TwoLevelBvh, camera_ray};
use phalanx_scene::camera::Camera;
pub use phalanx_scene::camera::{Lens, LensError};
use phalanx_scene::sampling::BLOCK;
pub use phalanx_scene::sampling::{Adaptive, Filter, MAX_SPP, Sampling};
use phalanx_scene::{Scene, ViewError};
pub use phalanx_trace::Kernel;
use phalanx_trace::bvh::Bvh;
pub use phalanx_trace::bvh::{BuildSettings, Quality};
use std::time::Instant;

/// Selects the tracer that makes the picture. Both give the same bits.
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
    /// One ray is sent per camera ray, so that only the mean over many lies between black and
    /// white. Colours, lights and bounces are left out; rays that hit nothing have the background.
    Occlusion {
        /// Distance beyond which a hit stops no ray, in units of the scene's file; it may be
        /// infinite.
        distance: f32,
    },
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
    /// Least weight of a bounce that is traced. The weight is the product of the weights along its
    /// path (Ks of mirror rays, Kt of refracted ones, Ks + Kt where reflection is total). A bounce
    /// is traced only where this product is at least `min_weight` in some component.
    ///
    /// For this product, not for the light, weights are divided by |Ks| + |Kt| where that is more
    /// than 1. So the rays of one depth weigh no more than their camera ray, and no more than
    /// 3/`min_weight` of them are traced whatever the materials. 0 has all traced. `None` means
    /// [`Settings::min_path_weight`].
    pub min_weight: Option<f32>,
    /// Camera rays of a pixel.
    pub sampling: Sampling,
    /// Lens that camera rays come through, in units of the scene's file; `None` is a pinhole. The
    /// point where a ray goes through the lens is random even with one ray a pixel.
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

/// Default least weight of a bounce, where a ray may take more than [`FULL_DEPTH`] bounces.
///
/// Chosen so that the usual pictures stay as they are, and deep ones end. Weights of 2⁻¹² and less
/// still change some samples of 8 bits: where a sum lies at the edge of two values, one unit in the
/// last place decides. The weight has to be as low as 2⁻²⁴ for no picture of the project to change.
/// At that weight a closed room of Ks = Kt = 0.5 takes 2²⁵ rays a camera ray. At 2⁻¹² it takes 2¹³
/// at most, and so do rooms of greater Ks and Kt. So rays that depth alone bounds are all traced,
/// and the rays of deeper pictures are traced down to this weight.
pub const MIN_WEIGHT: f32 = 1.0 / 4096.0;

/// Bounces up to which all are traced if no least weight is given: no more than 2¹¹ rays a camera
/// ray.
pub const FULL_DEPTH: u32 = 10;

impl Settings {
    /// The scene's own size and depth, one ray through the centre of each pixel, one thread, the
    /// packet engine.
    pub fn of(scene: &Scene) -> Settings {
        Settings {
            width: scene.width,
            height: scene.height,
            region: None,
            max_depth: scene.max_depth,
            min_weight: None,
            sampling: Sampling::CENTER,
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
        let whole = Tile::whole(self.width, self.height);
        self.region.map_or(whole, |region| region.within(whole))
    }

    /// Side of the tiles: from 8 to 1024, a multiple of 8.
    pub fn tile_side(&self) -> u32 {
        self.tile.clamp(8, 1024).next_multiple_of(8)
    }

    /// The camera that takes the picture.
    ///
    /// # Errors
    /// [`FrameError`], but for interruption.
    pub fn camera(&self, scene: &Scene) -> Result<Camera, FrameError> {
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

    /// Distance to the sky in units of the scene, if the integrator is ambient occlusion.
    fn ao_distance(&self, scene: &Scene) -> Option<f32> {
        match self.integrator {
            Integrator::Whitted => None,
            Integrator::Occlusion { distance } => Some(distance * scene.scale),
        }
    }

    /// Least weight of bounces: the given one, else 0 for a maximum depth of up to [`FULL_DEPTH`]
    /// and [`MIN_WEIGHT`] beyond.
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

/// A finished render.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The picture.
    pub film: Film,
    /// Work counters.
    pub stats: RenderStats,
    /// Wall seconds from the first tile to the last.
    pub seconds: f64,
    /// Seconds that each tile took the thread that rendered it.
    pub tile_seconds: Vec<f64>,
    /// Threads that worked.
    pub threads: usize,
}

/// The reason why there is no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// Stopped through [`Control`].
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// The scene was not validated.
    #[error(transparent)]
    View(#[from] ViewError),
    /// The settings describe an impossible lens.
    #[error(transparent)]
    Lens(#[from] LensError),
}

/// The acceleration structure of an engine, which it needs beside the scene.
pub struct Accel(AccelKind);

enum AccelKind {
    Packets(Bvh),
    Oracle(TwoLevelBvh),
}

/// An engine with its tree, which must be the scene's.
#[derive(Clone, Copy)]
pub enum AccelRef<'a> {
    /// The packet engine with its tree.
    Packets(&'a Bvh),
    /// The oracle with its tree.
    Oracle(&'a TwoLevelBvh),
}

/// Figures of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeStats {
    /// Nodes. The packet engine's hold two boxes each and leaves are no nodes; the oracle's leaves
    /// are.
    pub nodes: usize,
    /// Longest path from the root, the root counting 1.
    pub depth: usize,
    /// Surface area heuristic cost: expected node visits plus primitive tests of a random ray
    /// through the root box.
    pub sah: f64,
    /// Bytes held by the nodes.
    pub node_bytes: usize,
    /// Bytes held by the primitives in leaf order.
    pub prim_bytes: usize,
    /// Bytes of the same tree with more children a node; 0 where it has not been made.
    pub wide_bytes: usize,
}

impl TreeStats {
    /// Figures of the packet engine's tree.
    pub fn of(bvh: &Bvh) -> TreeStats {
        TreeStats {
            nodes: bvh.nodes().len(),
            depth: bvh.depth(),
            sah: bvh.sah(),
            node_bytes: bvh.node_bytes(),
            prim_bytes: bvh.prim_bytes(),
            wide_bytes: bvh.wide_bytes(),
        }
    }
}

impl Accel {
    /// Builds the tree of an engine with the default settings. The scene must have passed
    /// [`Scene::validate`].
    pub fn build(scene: &Scene, engine: Engine) -> Accel {
        Accel::build_with(scene, engine, &BuildSettings::default())
    }

    /// Builds the tree of an engine. The settings are the packet engine's: the oracle has one way
    /// to build, on one thread.
    pub fn build_with(scene: &Scene, engine: Engine, settings: &BuildSettings) -> Accel {
        Accel(match engine {
            Engine::Simd => AccelKind::Packets(Bvh::build_with(scene, settings)),
            Engine::Scalar => AccelKind::Oracle(TwoLevelBvh::build(scene)),
        })
    }

    /// The packet engine with a tree made elsewhere, which must be the scene's.
    pub fn with_tree(bvh: Bvh) -> Accel {
        Accel(AccelKind::Packets(bvh))
    }

    /// The engine and its tree.
    pub fn accel(&self) -> AccelRef<'_> {
        match &self.0 {
            AccelKind::Packets(bvh) => AccelRef::Packets(bvh),
            AccelKind::Oracle(forest) => AccelRef::Oracle(forest),
        }
    }

    /// Returns true if [`Accel::build_wide_bvh`] has nothing left to make for a frame.
    pub fn is_ready(&self, settings: &Settings) -> bool {
        match &self.0 {
            AccelKind::Packets(bvh) => {
                let kernel = settings.kernel.for_frame(bvh, settings.camera_rays());
                bvh.has_wide() || !kernel.is_wide()
            }
            AccelKind::Oracle(_) => true,
        }
    }

    /// Makes the structures that the kernel of a frame needs beside the binary tree. [`render`]
    /// does so itself where it has not been done; the time then counts in the frame's seconds.
    pub fn build_wide_bvh(&self, settings: &Settings) {
        if let AccelKind::Packets(bvh) = &self.0 {
            build_wide_bvh(bvh, settings);
        }
    }

    /// Figures of the tree.
    pub fn tree_stats(&self) -> TreeStats {
        match &self.0 {
            AccelKind::Packets(bvh) => TreeStats::of(bvh),
            AccelKind::Oracle(forest) => TreeStats {
                nodes: forest.world().node_count(),
                depth: forest.world().depth(),
                sah: forest.world().sah(),
                node_bytes: forest.memory_bytes(),
                prim_bytes: 0,
                wide_bytes: 0,
            },
        }
    }
}

/// Chooses the kernel for a frame, and makes the structures that it needs.
fn build_wide_bvh(bvh: &Bvh, settings: &Settings) -> Kernel {
    let kernel = settings.kernel.for_frame(bvh, settings.camera_rays());
    if kernel.is_wide() {
        bvh.build_wide(settings.threads.max(1));
    }
    kernel
}

/// Renders one frame with the engine that `accel` was built for.
///
/// # Errors
/// [`FrameError::Interrupted`] if `control.stop` was set before the last tile was taken,
/// [`FrameError::View`] if the scene has no camera frame, which [`Scene::validate`] would have
/// reported, [`FrameError::Lens`] if the given lens is impossible.
pub fn render(
    scene: &Scene,
    accel: &Accel,
    settings: &Settings,
    control: &Control,
) -> Result<Frame, FrameError> {
    render_with(scene, accel.accel(), settings, control)
}

/// Renders one frame like [`render`], with a tree that the caller owns.
///
/// # Errors
/// Those of [`render`].
pub fn render_with(
    scene: &Scene,
    tree: AccelRef,
    settings: &Settings,
    control: &Control,
) -> Result<Frame, FrameError> {
    let (window, side) = (settings.window(), settings.tile_side());
    let film = Film::new(window.width, window.height, settings.record_hits);
    let mut film = film.with_aovs(settings.aovs);
    let shared = SharedFilm::of(&mut film, window, side);
    let tiles = tiles(window, side);
    let start = Instant::now();
    let painted = render_tiles(scene, tree, settings, control, &tiles, &shared)?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(Frame {
        film,
        stats: painted.stats,
        seconds,
        tile_seconds: painted.tile_seconds,
        threads: settings.threads.max(1),
    })
}

/// Renders these tiles of the picture, and puts them into the sink. The region of the settings is
/// ignored.
///
/// # Errors
/// Those of [`render`].
pub fn render_tiles(
    scene: &Scene,
    tree: AccelRef,
    settings: &Settings,
    control: &Control,
    tiles: &[Tile],
    sink: &dyn TileSink,
) -> Result<RenderedTiles, FrameError> {
    let camera = settings.camera(scene)?;
    let (threads, pin) = (settings.threads.max(1), settings.pin);
    let sky = settings.ao_distance(scene);
    Ok(match tree {
        AccelRef::Packets(bvh) => {
            let kernel = build_wide_bvh(bvh, settings);
            render_on_workers(tiles, sink, threads, pin, control, || {
                let renderer =
                    WavefrontRenderer::new(scene, bvh, &camera, settings.max_depth, kernel)
                        .with_min_weight(settings.min_path_weight())
                        .with_sampling(settings.sampling)
                        .with_aovs(settings.aovs);
                match sky {
                    Some(reach) => renderer.with_ambient_occlusion(reach),
                    None => renderer,
                }
            })
        }
        AccelRef::Oracle(forest) => render_on_workers(tiles, sink, threads, pin, control, || {
            let oracle = Oracle::new(scene, OracleSearch::Tree(forest), settings.max_depth)
                .with_min_weight(settings.min_path_weight());
            OracleRenderer {
                camera: &camera,
                scene,
                sampling: settings.sampling,
                oracle: match sky {
                    Some(reach) => oracle.with_ambient_occlusion(reach),
                    None => oracle,
                },
            }
        }),
    }?)
}

/// Cost for the packet engine of the camera ray of each pixel of the window, row by row from the
/// top left.
///
/// # Errors
/// Those of [`render`].
pub fn render_heatmap(
    scene: &Scene,
    bvh: &Bvh,
    settings: &Settings,
    cost: RayCost,
    control: &Control,
) -> Result<Vec<f32>, FrameError> {
    let camera = settings.camera(scene)?;
    let (window, side) = (settings.window(), settings.tile_side());
    let mut film = Film::new(window.width, window.height, false);
    let shared = SharedFilm::of(&mut film, window, side);
    let tiles = tiles(window, side);
    let (threads, pin) = (settings.threads.max(1), settings.pin);
    let kernel = build_wide_bvh(bvh, settings);
    render_on_workers(&tiles, &shared, threads, pin, control, || {
        HeatmapRenderer::new(bvh, &camera, cost, kernel)
    })?;
    let [red, _, _] = film.planes;
    Ok(red)
}

/// Renders tiles with the oracle, pixel by pixel.
struct OracleRenderer<'a> {
    camera: &'a Camera,
    scene: &'a Scene,
    sampling: Sampling,
    oracle: Oracle<'a>,
}

impl OracleRenderer<'_> {
    /// Sets a pixel of a tile with all its outputs.
    fn set(
        &self,
        pixels: &mut TileBuffer,
        (x, y): (u32, u32),
        pixel: &phalanx_oracle::OraclePixel,
    ) {
        pixels.set(x, y, pixel.radiance.to_array());
        let first = pixel.first.and_then(|(ray, hit)| Some((ray, hit?)));
        if let Some((_, hit)) = first {
            pixels.set_hit(x, y, [hit.t, hit.u, hit.v], hit.prim_id);
        }
        let aovs = pixels.aovs();
        if aovs.is_empty() {
            return;
        }
        let look = first.map_or(SurfaceAov::NONE, |(ray, hit)| self.surface_aov(&ray, &hit));
        pixels.set_surface(x, y, &look);
        pixels.set_light(x, y, &RadianceAovs(pixel.light.map(Vec3::into)));
        if aovs.has(Aov::Samples) {
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(pixel.samples)]);
        }
    }

    fn surface_aov(
        &self,
        ray: &phalanx_oracle::OracleRay,
        hit: &phalanx_oracle::OracleHit,
    ) -> SurfaceAov {
        let (surface, kd, material) = self.oracle.surface_at(ray, hit);
        SurfaceAov {
            depth: hit.t / self.scene.scale,
            position: self.scene.file_position(surface.point).as_vec3().to_array(),
            ng: surface.ng.to_array(),
            ns: surface.ns.to_array(),
            albedo: kd.to_array(),
            material,
            primitive: hit.prim_id,
        }
    }

    /// Renders the blocks that a tile touches, and keeps the part that lies in the tile.
    fn render_adaptively(&mut self, adaptive: Adaptive, tile: Tile, pixels: &mut TileBuffer) {
        let whole = tile.outward(BLOCK, self.camera.size());
        for cell in tiles(whole, BLOCK) {
            let size = (cell.width, cell.height);
            let corner = (cell.x, cell.y);
            let (camera, sampling) = (self.camera, &self.sampling);
            let block = self.oracle.block(camera, sampling, &adaptive, corner, size);
            for (at, pixel) in (0..).zip(block) {
                let (x, y) = (cell.x + at % size.0, cell.y + at / size.0);
                let inside = x >= tile.x && y >= tile.y;
                if inside && x - tile.x < tile.width && y - tile.y < tile.height {
                    self.set(pixels, (x - tile.x, y - tile.y), &pixel);
                }
            }
        }
    }
}

impl TileRenderer for OracleRenderer<'_> {
    fn render_tile(&mut self, tile: Tile, pixels: &mut TileBuffer) {
        if let Some(adaptive) = self.sampling.adaptively() {
            return self.render_adaptively(adaptive, tile, pixels);
        }
        for y in 0..tile.height {
            for x in 0..tile.width {
                let (column, row) = (tile.x + x, tile.y + y);
                let pixel = self.oracle.pixel(self.camera, &self.sampling, column, row);
                self.set(pixels, (x, y), &pixel);
            }
        }
    }

    fn stats(&self) -> RenderStats {
        RenderStats {
            rays: self.oracle.ray_counts(),
            packets: 0,
        }
    }
}
