//! Decoders of PNG and JPEG that have read a header: textures and pictures to compare share them.

pub mod jpeg;
pub mod png;

/// The message for a file that ends before its last row.
pub const TOO_SHORT: &str = "it ends too early";

/// Checks a picture's width and height, before anything is allocated by size.
pub type CheckSides = fn(u64, u64) -> Result<(u32, u32), String>;
