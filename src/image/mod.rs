//! Pictures: tone, PNG files, comparison. The only place that names the crate `image`.
//!
//! A [`Film`](crate::render::Film) of linear radiance becomes a [`Picture`] of 8-bit samples ([`encode`]), a picture
//! becomes a file ([`save_png`]), files become [`Raster`]s ([`load`]) and two of them are held against each other
//! ([`compare()`], [`heat`]). Every step gives the same bytes on every machine and in every build.

mod compare;
mod false_color;
mod file;
mod png;
mod tone;

pub use compare::{Comparison, DifferentSizes, compare, heat};
pub use false_color::false_color;
pub use file::{check_writable, replace_file};
pub use png::{PictureError, Raster, load, png_bytes, save_png};
pub use tone::{Picture, encode};
