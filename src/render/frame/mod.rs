//! One whole frame: an engine, its tree, tiles handed to workers, a film.

mod accel;
mod error;
mod oracle_renderer;
mod refined;
mod settings;

pub use crate::{Aov, Aovs, Control, CoreAffinity, Interrupted, RayCost, Tile};
pub use accel::{Accel, AccelRef, TreeStats};
pub use error::FrameError;
pub use phalanx_scene::camera::{Lens, LensError};
pub use phalanx_scene::sampling::{Adaptive, Filter, MAX_SPP, Sampling};
pub use phalanx_trace::Kernel;
pub use phalanx_trace::bvh::{BuildSettings, Quality};
pub use refined::RefinedFrame;
pub use settings::{DEFAULT_TILE, Engine, FULL_DEPTH, Integrator, MIN_WEIGHT, Settings};

use crate::coverage_layers::mattes_for;
use crate::tile_sums::TileSums;
use crate::{
    Film, HeatmapRenderer, RenderStats, RenderedTiles, SharedFilm, TileRenderer, TileSink,
    WavefrontRenderer, render_on_workers, tiles,
};
use accel::build_wide_bvh;
use oracle_renderer::OracleRenderer;
use phalanx_oracle::{Oracle, OracleSearch};
use phalanx_scene::Scene;
use phalanx_trace::bvh::Bvh;
use phalanx_trace::stopwatch::Stopwatch;
use std::time::Duration;

/// A finished render.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The picture.
    pub film: Film,
    /// Work counters.
    pub stats: RenderStats,
    /// Wall seconds from the first tile to the last.
    pub seconds: f64,
    /// Time that tracing rays took, without shading: the sum over all threads.
    pub tracing: Duration,
    /// Seconds that each tile took the thread that rendered it.
    pub tile_seconds: Vec<f64>,
    /// Threads that worked.
    pub threads: usize,
}

/// Renders one frame with the engine that `accel` was built for.
///
/// # Errors
/// [`FrameError::Interrupted`] if `control.stop` was set before the last tile was finished,
/// [`FrameError::View`] if the scene has no camera frame, which [`Scene::validate`] would have
/// reported, [`FrameError::Lens`] if the given lens is impossible, [`FrameError::NoPixels`] if the
/// width or the height is 0 or the region lies outside the picture, [`FrameError::MinWeight`] if
/// that weight is NaN.
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
    let start = Stopwatch::start();
    let rendered = render_tiles(scene, tree, settings, control, &tiles, &shared)?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(Frame {
        film,
        stats: rendered.stats,
        seconds,
        tracing: rendered.tracing,
        tile_seconds: rendered.tile_seconds,
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
    let bvh = match tree {
        AccelRef::Packets(bvh) => {
            return render_packets(scene, bvh, settings, control, tiles, sink, None);
        }
        AccelRef::Oracle(bvh) => bvh,
    };
    let camera = settings.camera(scene)?;
    let mattes = mattes_for(scene, settings.aovs);
    on_workers(settings, control, tiles, sink, || OracleRenderer {
        camera: &camera,
        scene,
        sampling: settings.sampling,
        oracle: Oracle::new(scene, OracleSearch::Tree(bvh))
            .with_settings(settings.integrator_settings(scene))
            .with_mattes(mattes.as_ref()),
    })
}

/// Renders tiles on the threads of the settings, each with its own renderer.
fn on_workers<P: TileRenderer>(
    settings: &Settings,
    control: &Control,
    tiles: &[Tile],
    sink: &dyn TileSink,
    renderer: impl Fn() -> P + Sync,
) -> Result<RenderedTiles, FrameError> {
    let (threads, pin) = (settings.threads.max(1), settings.pin);
    let rendered = render_on_workers(tiles, sink, threads, pin, control, renderer);
    Ok(rendered?)
}

/// Renders tiles with the packet engine. With sums, it goes on from the samples that the tiles have
/// there.
fn render_packets(
    scene: &Scene,
    bvh: &Bvh,
    settings: &Settings,
    control: &Control,
    tiles: &[Tile],
    sink: &dyn TileSink,
    sums: Option<&TileSums>,
) -> Result<RenderedTiles, FrameError> {
    let camera = settings.camera(scene)?;
    let mattes = mattes_for(scene, settings.aovs);
    let settings = &Settings {
        kernel: build_wide_bvh(bvh, settings),
        ..settings.clone()
    };
    on_workers(settings, control, tiles, sink, || {
        WavefrontRenderer::new(scene, bvh, &camera, settings)
            .with_mattes(mattes.as_ref())
            .with_sums(sums)
            .with_stop(&control.stop)
    })
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
    let kernel = build_wide_bvh(bvh, settings);
    on_workers(settings, control, &tiles, &shared, || {
        HeatmapRenderer::new(bvh, &camera, cost, kernel)
    })?;
    let [red, _, _] = film.planes;
    Ok(red)
}
