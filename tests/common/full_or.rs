//! Sizes of tests that take long.

/// The full size of a test if `PHALANX_FULL` is set, as `.ci/run` sets it; else a part of it.
pub fn full_or<T>(full: T, part: T) -> T {
    match std::env::var_os("PHALANX_FULL") {
        Some(_) => full,
        None => part,
    }
}
