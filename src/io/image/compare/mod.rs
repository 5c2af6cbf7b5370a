//! Comparison of two pictures: figures, and pictures of the differences.

mod band_pairs;
mod comparison;
mod difference;
mod flip;
mod flip_filters;
mod layers;
mod pictures;
mod ssim;
#[cfg(test)]
mod tests;
mod tone;

pub use comparison::{LayerComparison, PictureComparison, compare_pictures};
pub use difference::{LargestDifference, NotFinite};
pub use pictures::{save_heat, save_side_by_side};
