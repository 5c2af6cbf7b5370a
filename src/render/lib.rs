//! The rendering of a tile, stage by stage; tiles, workers, film, statistics.
//!
//! `wavefront` is the one place where the order of the stages can be read: rays are traced, hits
//! shaded, shadow rays traced, bounces queued (`secondary`). In `levels`, bounces become the next
//! wave, which is accumulated into the wave above when it is done.

mod adaptive_edges;
mod adaptive_noise;
mod ambient_occlusion;
mod aov_buffer;
pub mod frame;
mod heatmap;
#[doc(hidden)]
pub mod isolated;
pub mod jobs;
mod levels;
mod secondary;
pub mod shade;
mod shadow_cache;
mod stats;
mod tile_renderer;
mod wavefront;
mod workers;

pub use heatmap::{HeatmapRenderer, RayCost};
pub use levels::WaveSizes;
pub use phalanx_scene::RayCounts;
pub use phalanx_scene::film::{
    Aov, AovChannel, Aovs, Film, Hits, NO_HIT, NO_ID, RadianceAovs, SharedFilm, SurfaceAov, Tile,
    TileBuffer, TileSink, tiles,
};
pub use stats::RenderStats;
pub use tile_renderer::{WavefrontRenderer, push_camera_rays};
pub use workers::{
    Control, CoreAffinity, Cores, Interrupted, RenderedTiles, TileRenderer, render_on_workers,
};
