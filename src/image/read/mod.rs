//! Picture files, read by rows.

mod bytes;
mod exr;
mod hdr;
mod jpeg;
mod layout;
mod pfm;
mod png;
mod raster;
mod reader;
#[cfg(test)]
mod tests;

pub use layout::{PictureChannel, PictureLayout, SampleKind, SamplePlanes};
pub use raster::{Raster, load};
pub use reader::PictureReader;
