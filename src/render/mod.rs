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
mod film;
mod kept;
mod layers;
mod levels;
mod occlusion;
mod packets;
mod sights;
mod stats;
mod tiles;
mod wave;
mod workers;

pub use cost::{Cost, CostPainter};
pub use film::{Film, Hits, NO_HIT, Pixels, SharedFilm, Sink};
pub use layers::{Aov, Aovs, Channel, Light, Look, NOTHING};
pub use levels::WaveSizes;
pub use packets::{PacketPainter, push_camera_rays};
pub use stats::{RayCounts, RenderStats};
pub use tiles::{Tile, tiles};
pub use workers::{Control, Cores, Interrupted, Painted, Painter, Pin, run};
