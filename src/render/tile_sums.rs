//! Sums of the samples of a picture's tiles, for pictures that get more samples later.

use super::traced_samples::PixelAccumulators;
use phalanx_scene::film::Tile;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The sums of all tiles of a picture.
pub(super) struct TileSums {
    /// Side of the tiles, and their number in a row.
    side: u32,
    columns: u32,
    tiles: Vec<Mutex<TileSum>>,
}

/// The samples that the pixels of a tile have, and their sums; those of a picture with one sample a
/// pixel are not summed.
#[derive(Default)]
pub(super) struct TileSum {
    pub(super) samples: u32,
    pub(super) pixels: PixelAccumulators,
}

impl TileSums {
    /// Empty sums for a picture of this size in pixels.
    pub(super) fn new((width, height): (u32, u32), side: u32) -> TileSums {
        let columns = width.div_ceil(side);
        let count = columns as usize * height.div_ceil(side) as usize;
        TileSums {
            side,
            columns,
            tiles: (0..count).map(|_| Mutex::default()).collect(),
        }
    }

    /// The sums of a tile.
    pub(super) fn of(&self, tile: Tile) -> MutexGuard<'_, TileSum> {
        let index = tile.y / self.side * self.columns + tile.x / self.side;
        let sum = self.tiles[index as usize].lock();
        sum.unwrap_or_else(PoisonError::into_inner)
    }
}
