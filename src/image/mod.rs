//! Pictures: tone, files, comparison. The only place that names the crates `image` and `exr`.
//!
//! A [`Film`](crate::render::Film) of linear radiance becomes a [`Picture`] of 8-bit samples ([`encode`]), a picture
//! becomes a file ([`save_png`]), and a film one of any [`Format`] ([`save()`]); files become [`Raster`]s ([`load`]) and two of them are held against each other
//! ([`compare()`], [`heat`]). Every step gives the same bytes on every machine and in every build.

mod compare;
mod false_color;
mod file;
mod format;
mod jpeg;
mod linear;
mod png;
mod save;
mod tone;

pub use compare::{Comparison, DifferentSizes, compare, heat};
pub use false_color::false_color;
pub use file::{check_writable, replace_file};
pub use format::Format;
pub use png::{PictureError, Raster, load, png_bytes, save_png};
pub use save::{Depth, save};
pub use tone::{Grade, Picture, encode, encode_16};
