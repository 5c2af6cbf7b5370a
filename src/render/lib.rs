//! A tile's life in order; tiles, workers, film, statistics.
//!
//! `wave` is the one place where the order of the stages can be read: rays are traced, hits shaded,
//! shadow rays answered, bounces queued (`bounce`). In `levels`, what bounces becomes the next
//! wave, folded back when it is done.

mod adaptive;
pub mod alone;
mod bounce;
mod cells;
mod cost;
pub mod frame;
pub mod jobs;
mod kept;
mod levels;
mod occlusion;
mod packets;
pub mod shade;
mod sights;
mod stats;
mod wave;
mod workers;

pub use cost::{Cost, CostPainter};
pub use levels::WaveSizes;
pub use packets::{PacketPainter, push_camera_rays};
pub use phalanx_scene::film::{
    Aov, Aovs, Channel, Film, Hits, Light, Look, NO_HIT, NOTHING, Pixels, SharedFilm, Sink, Tile,
    tiles,
};
pub use stats::{RayCounts, RenderStats};
pub use workers::{Control, Cores, Interrupted, Painted, Painter, Pin, run};
