//! Shared parts of the integration tests: random numbers, random scenes, packets, and the
//! tolerances.
#![allow(dead_code, reason = "every test binary uses its own part")]

pub mod frames;
mod full_or;
pub mod rays;
pub mod rng;
pub mod scenes;
pub mod tolerances;

pub use full_or::full_or;
