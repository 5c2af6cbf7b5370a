//! Scenes and pictures as files.

// Polygons of files, cut into triangles.
mod large_polygon;
mod polygon;

// Decoders of PNG and JPEG, for textures and for pictures.
mod decoders;

// Scene readers: bytes to a scene, or a scene without any.
pub mod formats;
pub mod standard;

// The scene cache: a scene and its tree in a file, as they lie in memory.
pub mod cache;

// The front door: a scene from any source.
pub mod open;

// Picture files: a film as a picture.
pub mod image;
