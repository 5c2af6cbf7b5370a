//! Which pixels of a window are finished, in blocks of 8x8: tiles are made of whole ones, whatever their size.

use crate::frame::Tile;

/// Side of a block. Every tile's sides are multiples of it, but where the window cuts them.
const BLOCK: u32 = 8;

/// A set of blocks of one grid over the whole picture; of a block that the window cuts, what lies in the window counts.
#[derive(Clone, Debug)]
pub(super) struct Coverage {
    window: Tile,
    /// Column and row of the first block.
    first: (u32, u32),
    across: u32,
    finished: Vec<bool>,
}

impl Coverage {
    /// Of a window, none of it finished.
    pub(super) fn new(window: Tile) -> Coverage {
        let first = (window.x / BLOCK, window.y / BLOCK);
        let across = (window.x + window.width).div_ceil(BLOCK) - first.0;
        let down = (window.y + window.height).div_ceil(BLOCK) - first.1;
        Coverage {
            window,
            first,
            across,
            finished: vec![false; across as usize * down as usize],
        }
    }

    /// Marks all blocks that lie in a tile as finished; the number of pixels that were not before.
    pub(super) fn add(&mut self, tile: Tile) -> u64 {
        let mut new = 0;
        for (at, block) in self.blocks(tile) {
            if block.within(tile) == block && !self.finished[at] {
                self.finished[at] = true;
                new += block.pixels();
            }
        }
        new
    }

    /// Whether every pixel of a tile is finished.
    pub(super) fn has(&self, tile: Tile) -> bool {
        self.blocks(tile).all(|(at, _)| self.finished[at])
    }

    /// The blocks that a tile touches, by place in the set.
    fn blocks(&self, tile: Tile) -> impl Iterator<Item = (usize, Tile)> + use<> {
        let (window, (left, top), across) = (self.window, self.first, self.across);
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
                let at = (row - top) as usize * across as usize + (column - left) as usize;
                (at, block.within(window))
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
        let mut coverage = Coverage::new(tile(13, 5, 40, 30));
        assert!(!coverage.has(tile(13, 5, 3, 3)));
        // Cut by the window to 3x3, then to 8x3 and 3x8.
        assert_eq!(coverage.add(tile(8, 0, 16, 16)), 9 + 24 + 24 + 64);
        assert_eq!(coverage.add(tile(13, 5, 11, 11)), 0);
        assert!(coverage.has(tile(13, 5, 11, 11)));
        assert!(!coverage.has(tile(13, 5, 12, 11)));
        assert!(!coverage.has(tile(13, 5, 11, 12)));
        // A part of a block finishes nothing.
        assert_eq!(coverage.add(tile(24, 8, 8, 7)), 0);
        assert!(!coverage.has(tile(24, 8, 8, 7)));
        assert_eq!(coverage.add(tile(24, 8, 8, 8)), 64);
        assert!(coverage.has(tile(24, 8, 8, 7)));
        // The lower right corner, which the window cuts.
        assert_eq!(coverage.add(tile(48, 32, 5, 3)), 15);
        assert!(coverage.has(tile(48, 32, 100, 100)));
        assert_eq!(coverage.add(tile(100, 100, 8, 8)), 0);
    }
}
