//! The library of a level: what `build.rs` compiles, and `lib.rs` loads.

mod tree;

/// Exports of this library.
#[unsafe(no_mangle)]
pub static PHALANX_LEVEL: tree::LevelExports = tree::LevelExports::OWN;
