//! Arithmetic that both engines share as a definition: one polynomial, evaluated in one order, and one table.

mod pow;
mod srgb;

pub use srgb::linear_of_srgb;

pub use pow::{EXP2_COEFFICIENTS, LOG2_COEFFICIENTS, ROUND_MAGIC, SQRT_HALF_BITS, pow};
