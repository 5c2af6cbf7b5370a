//! Opens scenes by the name of a file, a cache or a standard scene.

// The scene cache: a scene and its tree in a file, in their memory layout.
pub mod cache;

// Environments by name.
mod environment;

// Opens a scene from any source.
pub mod open;

pub use environment::EnvironmentSource;
