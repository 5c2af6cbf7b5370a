//! Finished pixels of a window, in blocks of 8x8. Tiles consist of whole blocks, regardless of
//! their size.

use phalanx_render::frame::Tile;
use std::collections::HashMap;

/// Side of a block. Every tile's sides are multiples of it, except where the window cuts them.
const BLOCK: u32 = 8;

/// Side of a square of blocks, in blocks: a square has as many blocks as a word has bits.
const SQUARE: u32 = 8;

/// A set of blocks of one grid over the whole picture. If the window cuts a block, only the part
/// within the window counts.
///
/// Only squares with finished blocks take memory, so a file of few tiles takes little, however
/// large its claimed picture is.
#[derive(Clone, Debug)]
pub(super) struct FinishedPixels {
    window: Tile,
    /// Finished blocks of a square, by its column and row.
    finished: HashMap<(u32, u32), u64>,
}

/// A block, as the square that it lies in and its bit there.
struct PixelBlock {
    square: (u32, u32),
    bit: u64,
    pixels: Tile,
}

impl FinishedPixels {
    /// An empty set for a window: none of it is finished.
    pub(super) fn new(window: Tile) -> FinishedPixels {
        FinishedPixels {
            window,
            finished: HashMap::new(),
        }
    }

    /// Marks all blocks that lie in a tile as finished. Returns the number of pixels that were not
    /// finished before.
    pub(super) fn add(&mut self, tile: Tile) -> u64 {
        let mut new = 0;
        for block in self.blocks(tile) {
            if block.pixels.within(tile) != block.pixels {
                continue;
            }
            let square = self.finished.entry(block.square).or_default();
            if *square & block.bit == 0 {
                *square |= block.bit;
                new += block.pixels.pixels();
            }
        }
        new
    }

    /// Returns true if every pixel of a tile is finished.
    pub(super) fn has(&self, tile: Tile) -> bool {
        self.blocks(tile).all(|block| {
            let square = self.finished.get(&block.square);
            square.is_some_and(|square| square & block.bit != 0)
        })
    }

    /// The blocks that a tile touches.
    fn blocks(&self, tile: Tile) -> impl Iterator<Item = PixelBlock> + use<> {
        let window = self.window;
        let tile = tile.within(window);
        let columns = tile.x / BLOCK..(tile.x + tile.width).div_ceil(BLOCK);
        let rows = tile.y / BLOCK..(tile.y + tile.height).div_ceil(BLOCK);
        let none = tile.pixels() == 0;
        let rows = if none { 0..0 } else { rows };
        rows.flat_map(move |row| {
            columns.clone().map(move |column| {
                let block = Tile {
                    x: column * BLOCK,
                    y: row * BLOCK,
                    width: BLOCK,
                    height: BLOCK,
                };
                PixelBlock {
                    square: (column / SQUARE, row / SQUARE),
                    bit: 1 << (row % SQUARE * SQUARE + column % SQUARE),
                    pixels: block.within(window),
                }
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(x: u32, y: u32, width: u32, height: u32) -> Tile {
        Tile {
            x,
            y,
            width,
            height,
        }
    }

    #[test]
    fn a_tile_is_finished_when_all_its_blocks_are() {
        let mut finished = FinishedPixels::new(tile(13, 5, 40, 30));
        assert!(!finished.has(tile(13, 5, 3, 3)));
        // Cut by the window to 3x3, then to 8x3 and 3x8.
        assert_eq!(finished.add(tile(8, 0, 16, 16)), 9 + 24 + 24 + 64);
        assert_eq!(finished.add(tile(13, 5, 11, 11)), 0);
        assert!(finished.has(tile(13, 5, 11, 11)));
        assert!(!finished.has(tile(13, 5, 12, 11)));
        assert!(!finished.has(tile(13, 5, 11, 12)));
        // A part of a block finishes nothing.
        assert_eq!(finished.add(tile(24, 8, 8, 7)), 0);
        assert!(!finished.has(tile(24, 8, 8, 7)));
        assert_eq!(finished.add(tile(24, 8, 8, 8)), 64);
        assert!(finished.has(tile(24, 8, 8, 7)));
        // The lower right corner, which the window cuts.
        assert_eq!(finished.add(tile(48, 32, 5, 3)), 15);
        assert!(finished.has(tile(48, 32, 100, 100)));
        assert_eq!(finished.add(tile(100, 100, 8, 8)), 0);
    }

    #[test]
    fn a_large_window_takes_memory_for_what_is_finished_alone() {
        let end = u32::MAX - 100;
        let mut finished = FinishedPixels::new(tile(0, 0, u32::MAX, u32::MAX));
        assert_eq!(finished.add(tile(end - end % 8, 64, 80, 16)), 80 * 16);
        assert!(finished.has(tile(end - end % 8 + 8, 64, 72, 8)));
        assert!(finished.finished.len() <= 3);
        // The window may be anywhere, and as large as it claims.
        let mut far = FinishedPixels::new(tile(u32::MAX - 5, u32::MAX - 5, 400, 300));
        assert_eq!(far.add(tile(u32::MAX - 7, u32::MAX - 7, 1024, 1024)), 25);
        assert_eq!(far.add(tile(0, 0, 1024, 1024)), 0);
    }
}
