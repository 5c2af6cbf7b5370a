//! The library of a level: what `build.rs` compiles, and `lib.rs` loads.

mod tree;

/// What the program looks for.
#[unsafe(no_mangle)]
pub static PHALANX_LEVEL: tree::Level = tree::Level::OWN;
