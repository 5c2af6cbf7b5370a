//! Blocks of 8×8 pixels: the units of a tile for adaptive sampling.

use phalanx_scene::film::Tile;
use phalanx_scene::sampling::BLOCK;

/// Upper left corners of a tile's blocks, relative to the tile.
pub(super) fn corners(tile: Tile) -> impl Iterator<Item = (u32, u32)> {
    let across = (0..tile.width).step_by(BLOCK as usize);
    let down = (0..tile.height).step_by(BLOCK as usize);
    down.flat_map(move |y| across.clone().map(move |x| (x, y)))
}

/// Columns and rows that the block with this corner has within a tile.
pub(super) fn size_of(tile: Tile, (x, y): (u32, u32)) -> (u32, u32) {
    (BLOCK.min(tile.width - x), BLOCK.min(tile.height - y))
}

/// Maps a position in `outer`, which surrounds the tile, to the position in the tile; `None`
/// outside the tile.
pub(super) fn within(outer: Tile, tile: Tile) -> impl Fn((u32, u32)) -> Option<(u32, u32)> {
    move |(x, y)| tile.position_of(outer.x + x, outer.y + y)
}
