//! Scenes and pictures as files.

// Bytes to a scene, or a scene without any.
pub mod formats;
pub mod standard;

// A scene and its tree in a file, as they lie in memory.
pub mod cache;

// Whatever it came from.
pub mod open;

// A film as a picture.
pub mod image;
