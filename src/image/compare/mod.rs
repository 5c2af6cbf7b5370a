//! Comparison of two pictures: figures and difference pictures.

mod band_pairs;
mod comparison;
mod difference;
mod flip;
mod flip_filters;
mod layer_pairs;
mod on_screen;
mod pictures;
mod ssim;
#[cfg(test)]
mod tests;

pub use comparison::{LayerComparison, PictureComparison, compare_pictures};
pub use difference::{LargestDifference, NotFiniteCounts};
pub use pictures::{save_heat, save_side_by_side};
