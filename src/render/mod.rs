//! A tile's life in order; tiles, workers, film, statistics.

mod film;
mod stats;

pub use film::{Film, Hits, NO_HIT};
pub use stats::{RayCounts, RenderStats};
