//! Finished pixels of a window, in blocks of 8x8. Tiles consist of whole blocks, regardless of
//! their size.

use phalanx_render::frame::Tile;
use std::collections::HashMap;

/// Side of a block. Every tile's sides are multiples of it, except where the window cuts them.
const BLOCK: u32 = 8;

/// Side of a square of blocks: a square has as many blocks as a word has bits.
const SQUARE: u32 = 8 * BLOCK;

/// A set of blocks of one grid over the whole picture. If the window cuts a block, only the part
/// within the window counts.
///
/// Only squares with finished blocks take memory, so a file of few tiles takes little, however
/// large its claimed picture is.
#[derive(Clone, Debug)]
pub(super) struct FinishedPixels {
    window: Tile,
    /// Finished blocks of a square, by its left column and its top row.
    finished: HashMap<(u32, u32), u64>,
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
        let inside = tile.within(self.window);
        for square in cells(inside, SQUARE) {
            let finished = self.finished.entry((square.x, square.y)).or_default();
            for block in cells(inside.within(square), BLOCK) {
                let pixels = block.within(self.window);
                if pixels.within(tile) == pixels && *finished & bit(block) == 0 {
                    *finished |= bit(block);
                    new += pixels.pixels();
                }
            }
        }
        new
    }

    /// Returns true if every pixel of a tile is finished.
    pub(super) fn has(&self, tile: Tile) -> bool {
        let inside = tile.within(self.window);
        cells(inside, SQUARE).all(|square| {
            let finished = self.finished.get(&(square.x, square.y)).unwrap_or(&0);
            let mut blocks = cells(inside.within(square), BLOCK);
            blocks.all(|block| finished & bit(block) != 0)
        })
    }
}

/// The bit of a block in its square.
fn bit(block: Tile) -> u64 {
    let (column, row) = (block.x % SQUARE / BLOCK, block.y % SQUARE / BLOCK);
    1 << (row * (SQUARE / BLOCK) + column)
}

/// The cells of a grid over the whole picture that a tile touches.
fn cells(tile: Tile, side: u32) -> impl Iterator<Item = Tile> {
    let columns = tile.x / side..(tile.x + tile.width).div_ceil(side);
    let rows = tile.y / side..(tile.y + tile.height).div_ceil(side);
    let rows = if tile.pixels() == 0 { 0..0 } else { rows };
    rows.flat_map(move |row| {
        columns.clone().map(move |column| Tile {
            x: column * side,
            y: row * side,
            width: side,
            height: side,
        })
    })
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
