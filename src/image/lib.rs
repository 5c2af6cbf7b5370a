//! Pictures: tone, files, comparison. Only this crate writes with the crates `image`, `png` and
//! `exr`.
//!
//! A [`Film`](phalanx_scene::film::Film) of linear radiance becomes a [`Picture`] of 8-bit samples
//! ([`encode`]), and a picture becomes a file ([`save_png`]). Films that lie one below the other
//! become a file of any [`ImageFormat`] ([`save_bands`]). Files are read by rows
//! ([`PictureReader`]) or as a whole ([`load`]), and two of them can be compared
//! ([`compare_pictures`]). Every step gives the same bytes on every machine and in every build,
//! however the film was cut.

mod bands;
mod compare;
#[doc(hidden)]
pub mod decoders;
mod description;
mod encoder;
mod error;
mod exr;
mod exr_header;
mod false_color;
mod film_bits;
mod format;
mod hdr_pfm;
mod header;
mod jpeg;
mod layer_colors;
mod neutral;
mod png;
mod read;
mod straight_alpha;
#[cfg(test)]
mod test_film;
mod thumbnail;
mod zlib_strips;

pub use bands::{save_bands, write_bands};
pub use compare::{
    LargestDifference, LayerComparison, NotFiniteCounts, PictureComparison, compare_pictures,
    save_heat, save_side_by_side,
};
pub use description::{BAND_ROWS, Crop, Depth, PictureFile};
pub use encoder::{Exposure, MAX_EXPOSURE, Picture, ToneCurve, encode};
pub use error::{CompareError, DifferentSizes, PictureError};
pub use false_color::{false_color, false_colors};
pub use film_bits::{
    HitBits, PixelBits, differing_pixels, extend_with_plane, pixel_hashes, put_tile_bytes,
};
pub use format::ImageFormat;
pub use header::PictureHeader;
pub use jpeg::jpeg_bytes;
pub use layer_colors::layer_colors;
pub use png::{png_bytes, save_png};
pub use read::{
    PictureChannel, PictureLayout, PictureReader, Raster, SampleKind, SamplePlanes, load,
};
pub use thumbnail::Thumbnail;
