//! Tiles of the picture, in Morton order, so that successive workers touch the same part of the
//! tree.

/// A rectangle of pixels of the whole picture. At borders it may be smaller than the tile side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Leftmost column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl Tile {
    /// The tile that covers a whole picture.
    #[inline]
    pub fn whole(width: u32, height: u32) -> Tile {
        Tile {
            x: 0,
            y: 0,
            width,
            height,
        }
    }

    /// Number of pixels.
    #[inline]
    pub fn pixels(&self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// The tile grown outward to the cells of a grid of this side that it touches, and clipped to a
    /// picture of this size.
    pub fn outward(&self, side: u32, (width, height): (u32, u32)) -> Tile {
        let (x, y) = (self.x - self.x % side, self.y - self.y % side);
        let right = (self.x + self.width).next_multiple_of(side);
        let bottom = (self.y + self.height).next_multiple_of(side);
        Tile {
            x,
            y,
            width: right.min(width) - x,
            height: bottom.min(height) - y,
        }
    }

    /// Position in the tile of a pixel of the picture; `None` outside the tile.
    pub fn position_of(&self, x: u32, y: u32) -> Option<(u32, u32)> {
        let (x, y) = (x.checked_sub(self.x)?, y.checked_sub(self.y)?);
        (x < self.width && y < self.height).then_some((x, y))
    }

    /// The intersection with another tile; a tile without pixels if they do not overlap.
    pub fn within(&self, other: Tile) -> Tile {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let end = |from: u32, size: u32| from.saturating_add(size);
        let right = end(self.x, self.width).min(end(other.x, other.width));
        let bottom = end(self.y, self.height).min(end(other.y, other.height));
        Tile {
            x,
            y,
            width: right.saturating_sub(x),
            height: bottom.saturating_sub(y),
        }
    }
}

/// All tiles of side `side` of a window of the picture, in Morton order. Every pixel is in exactly
/// one tile. Tiles are cells of one grid over the whole picture, regardless of the window, and are
/// cut by the window's borders.
pub fn tiles(window: Tile, side: u32) -> Vec<Tile> {
    let mut all: Vec<(u64, Tile)> = Vec::new();
    let cells = |from: u32, size: u32| from / side..(from + size).div_ceil(side);
    for row in cells(window.y, window.height) {
        for column in cells(window.x, window.width) {
            let cell = Tile {
                x: column * side,
                y: row * side,
                width: side,
                height: side,
            };
            all.push((
                spread_bits(column) | spread_bits(row) << 1,
                cell.within(window),
            ));
        }
    }
    all.sort_by_key(|&(code, _)| code);
    all.into_iter().map(|(_, tile)| tile).collect()
}

/// Puts a zero bit before every bit of `v` (the Morton code's half).
fn spread_bits(v: u32) -> u64 {
    let mut v = v as u64;
    for (shift, mask) in [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ] {
        v = (v | v << shift) & mask;
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_exactly_one_tile() {
        for (w, h, side) in [(1, 1, 8), (640, 480, 32), (33, 17, 16), (7, 100, 64)] {
            for (x, y) in [(0, 0), (8, 16), (13, 5)] {
                let window = Tile {
                    x,
                    y,
                    width: w,
                    height: h,
                };
                let mut seen = vec![0u8; (w * h) as usize];
                for t in tiles(window, side) {
                    assert!(t.pixels() > 0 && (t.x % side == 0 || t.x == x), "{t:?}");
                    for row in t.y..t.y + t.height {
                        for column in t.x..t.x + t.width {
                            seen[((row - y) * w + column - x) as usize] += 1;
                        }
                    }
                }
                assert!(
                    seen.iter().all(|&n| n == 1),
                    "{window:?} in tiles of {side}"
                );
            }
        }
    }
}
