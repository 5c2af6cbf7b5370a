//! The door to scenes: by the name of a file, a cache or a standard scene.

// The scene cache: a scene and its tree in a file, as they lie in memory.
pub mod cache;

// The front door: a scene from any source.
pub mod open;
