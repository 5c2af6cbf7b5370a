//! Arithmetic that both engines share by definition: samples, two polynomials, evaluated in one
//! order, and one table.
//!
//! | file | contents |
//! |---|---|
//! | `angles` | the angle of a vector |
//! | `sobol` | points of the unit square, by pixel or ray, and sample |
//! | `warps` | maps from the unit square to sampled shapes |
//! | `filter` | reconstruction filters of pixels |
//! | `pixel` | positions of a pixel's camera rays |
//! | `pixel_accumulator` | sum, mean and variance of a pixel's samples |
//! | `pixel_coverage` | surfaces visible to a pixel's samples |
//! | `adaptive` | adaptive sampling by whole pixels |
//! | `cells` | adaptive sampling by cell subdivision, with reuse of shadow rays |
//! | `pow` | x^s for highlights |
//! | `srgb` | the bytes of textures |

mod adaptive;
mod angles;
mod cells;
mod filter;
mod pixel;
mod pixel_accumulator;
mod pixel_coverage;
mod pow;
mod sobol;
mod srgb;
mod warps;

pub use adaptive::{Adaptive, BLOCK, FIRST_SAMPLES, PixelMask as BlockPixels};
pub use angles::turns;
pub use cells::{
    Cells, LightVisibility, MAX_HITS, MIN_AGREEING, PixelSum, SampleRequest, SampleResult, path_id,
};
pub use filter::Filter;
pub use pixel::{FilmSamples, MAX_SPP, Sampling};
pub use pixel_accumulator::PixelAccumulator;
pub use pixel_coverage::{PixelCoverage, RANKS, SurfaceShare};
pub use sobol::{BounceKind, Dimension, child_seed, points, points_of, seeds};
pub use srgb::{linear_of_srgb, share_of_byte, srgb_to_linear};
pub use warps::{concentric_disk, cosine_hemisphere, phong_lobe, to_frame, uniform_sphere};

pub use pow::{EXP2_COEFFICIENTS, LOG2_COEFFICIENTS, ROUND_MAGIC, SQRT_HALF_BITS, log2, pow};
