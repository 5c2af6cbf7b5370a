//! Arithmetic that both engines share as a definition: samples, and two polynomials, evaluated in one order, and one table.
//!
//! | file | what |
//! |---|---|
//! | `points` | points of the unit square, by pixel or ray, and sample |
//! | `maps` | from the unit square to what is sampled |
//! | `filter` | what a pixel gathers |
//! | `pixel` | where a pixel's camera rays go through |
//! | `adaptive` | which pixels get more camera rays |
//! | `cells` | which parts of pixels do, and which shadow rays they save |
//! | `pow` | x^s for highlights |
//! | `srgb` | the bytes of textures |

mod adaptive;
mod cells;
mod filter;
mod maps;
mod pixel;
mod points;
mod pow;
mod srgb;

pub use adaptive::{Adaptive, BLOCK, FIRST, Pixels as BlockPixels};
pub use cells::{AGREE, Answer, Ask, Cells, SIGHTS, Sight, Sum, trail};
pub use filter::Filter;
pub use maps::{around, disc, hemisphere, lobe, sphere};
pub use pixel::{Gathered, MAX_SPP, Places, Sampling};
pub use points::{Purpose, Way, onward, points, points_of, seeds};
pub use srgb::linear_of_srgb;

pub use pow::{EXP2_COEFFICIENTS, LOG2_COEFFICIENTS, ROUND_MAGIC, SQRT_HALF_BITS, pow};
