//! Shared parts of the integration tests: random numbers, random scenes, packets, and the
//! tolerances.
#![allow(dead_code, reason = "every test binary uses its own part")]

pub mod frames;
pub mod rays;
pub mod rng;
pub mod scenes;
pub mod tolerances;

/// The full size of a test if `PHALANX_FULL` is set, as `.ci/run` sets it; else a part of it.
pub fn full_or<T>(full: T, part: T) -> T {
    match std::env::var_os("PHALANX_FULL") {
        Some(_) => full,
        None => part,
    }
}
