//! Tiles of the image, in Morton order, so that workers that follow each other touch the same part of the tree.

/// A rectangle of pixels; at the right and lower border it may be smaller than the tile side.
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
    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        self.width as u64 * self.height as u64
    }
}

/// All tiles of side `side` of an image, in Morton order. Every pixel is in exactly one.
pub fn tiles(width: u32, height: u32, side: u32) -> Vec<Tile> {
    let mut all: Vec<(u64, Tile)> = Vec::new();
    for (row, y) in (0..height).step_by(side as usize).enumerate() {
        for (column, x) in (0..width).step_by(side as usize).enumerate() {
            let tile = Tile {
                x,
                y,
                width: side.min(width - x),
                height: side.min(height - y),
            };
            all.push((spread(column as u32) | spread(row as u32) << 1, tile));
        }
    }
    all.sort_by_key(|&(code, _)| code);
    all.into_iter().map(|(_, tile)| tile).collect()
}

/// Puts a zero bit before every bit of `v` (the Morton code's half).
fn spread(v: u32) -> u64 {
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
    use super::tiles;

    #[test]
    fn every_pixel_is_in_exactly_one_tile() {
        for (w, h, side) in [(1, 1, 8), (640, 480, 32), (33, 17, 16), (7, 100, 64)] {
            let mut seen = vec![0u8; (w * h) as usize];
            for t in tiles(w, h, side) {
                for y in t.y..t.y + t.height {
                    for x in t.x..t.x + t.width {
                        seen[(y * w + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{w}x{h} in tiles of {side}");
        }
    }
}
