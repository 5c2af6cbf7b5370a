//! Decoders of PNG and JPEG that have read a header: textures and pictures to compare share them.

pub mod jpeg;
pub mod png;

use std::io;

/// The message for a file that ends before its last row.
pub const TOO_SHORT: &str = "it ends too early";

/// The message for a file that cannot be read, or read to its end.
pub fn io_reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => TOO_SHORT.into(),
        _ => error.to_string(),
    }
}

/// Checks a picture's width and height, before anything is allocated by size.
pub type CheckSides = fn(u64, u64) -> Result<(u32, u32), String>;
