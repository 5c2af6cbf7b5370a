//! Arithmetic that both engines share as a definition: one polynomial, evaluated in one order.

mod pow;

pub use pow::{EXP2_COEFFICIENTS, LOG2_COEFFICIENTS, ROUND_MAGIC, SQRT_HALF_BITS, pow};
