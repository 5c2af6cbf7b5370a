//! The rendering of a tile, stage by stage; tiles, workers, film, statistics.
//!
//! `frame` hands tiles to `workers`. A worker's `tile_renderer` decides which camera rays are
//! traced (`adaptive_edges`, `adaptive_noise`), and `sample_tracer` traces them. `wavefront` is the
//! one place that shows the order of the stages: rays are traced, hits shaded, shadow rays traced,
//! bounces queued, and accumulated when they are done.

mod adaptive_edges;
mod adaptive_noise;
mod blocks;
mod coverage_layers;
pub mod frame;
mod heatmap;
#[doc(hidden)]
pub mod microbench;
mod ray_cost;
mod sample_tracer;
pub mod shade;
mod stats;
mod tile_renderer;
mod tile_sums;
mod traced_samples;
mod wavefront;
mod workers;

pub use heatmap::HeatmapRenderer;
pub use phalanx_scene::RayCounts;
pub use phalanx_scene::film::{
    Aov, AovChannel, Aovs, Film, Hits, NO_HIT, NO_ID, RadianceAovs, SharedFilm, SurfaceAov, Tile,
    TileBuffer, TileSink, tiles,
};
pub use ray_cost::RayCost;
pub use stats::RenderStats;
pub use tile_renderer::WavefrontRenderer;
pub use wavefront::{WaveSizes, push_camera_rays};
pub use workers::{
    Control, CoreAffinity, Cores, Interrupted, RenderedTiles, TileRenderer, render_on_workers,
};
