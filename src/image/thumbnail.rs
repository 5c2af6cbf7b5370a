//! A small picture of the tiles finished so far, for observers.

use phalanx_scene::film::{Film, Tile, TileBuffer};
use std::sync::{Mutex, PoisonError};

/// A window of the picture on a film of few pixels. Each pixel is the mean of the finished pixels
/// in a square of the window.
#[derive(Debug)]
pub struct Thumbnail {
    window: Tile,
    /// Side of the squares.
    scale: u32,
    width: u32,
    height: u32,
    /// Sums of red, green and blue, and the number of pixels in them.
    sums: Mutex<Vec<[f32; 4]>>,
}

impl Thumbnail {
    /// A thumbnail of a window, neither side longer than `side` pixels.
    pub fn new(window: Tile, side: u32) -> Thumbnail {
        let scale = window.width.max(window.height).div_ceil(side.max(1)).max(1);
        let (width, height) = (window.width.div_ceil(scale), window.height.div_ceil(scale));
        Thumbnail {
            window,
            scale,
            width,
            height,
            sums: Mutex::new(vec![[0.0; 4]; width as usize * height as usize]),
        }
    }

    /// Adds a finished tile.
    pub fn add(&self, tile: Tile, pixels: &TileBuffer) {
        let [red, green, blue] = pixels.radiance();
        self.add_rows(tile, |x, y| {
            let index = (y * tile.width + x) as usize;
            [red[index], green[index], blue[index]]
        });
    }

    /// Adds a tile that was finished before, from a film of some rows of the window.
    pub fn add_from(&self, film: &Film, band: Tile, tile: Tile) {
        self.add_rows(tile, |x, y| {
            film.pixel(tile.x - band.x + x, tile.y - band.y + y)
        });
    }

    fn add_rows(&self, tile: Tile, pixel: impl Fn(u32, u32) -> [f32; 3]) {
        let mut sums = self.sums.lock().unwrap_or_else(PoisonError::into_inner);
        for y in 0..tile.height {
            let row = (tile.y - self.window.y + y) / self.scale * self.width;
            for x in 0..tile.width {
                let index = row + (tile.x - self.window.x + x) / self.scale;
                let [r, g, b] = pixel(x, y);
                let sum = &mut sums[index as usize];
                *sum = [sum[0] + r, sum[1] + g, sum[2] + b, sum[3] + 1.0];
            }
        }
    }

    /// The picture so far; unfinished pixels are black.
    pub fn film(&self) -> Film {
        let mut film = Film::new(self.width, self.height, false);
        let sums = self.sums.lock().unwrap_or_else(PoisonError::into_inner);
        for (index, [r, g, b, count]) in sums.iter().enumerate() {
            if *count > 0.0 {
                for (plane, sum) in film.planes.iter_mut().zip([r, g, b]) {
                    plane[index] = sum / count;
                }
            }
        }
        film
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_are_means_of_what_is_finished() {
        let window = Tile {
            x: 10,
            y: 20,
            width: 9,
            height: 4,
        };
        // Squares of 2x2; those of the last column are half as wide.
        let thumbnail = Thumbnail::new(window, 5);
        let tile = Tile {
            width: 3,
            height: 2,
            ..window
        };
        let mut pixels = TileBuffer::new(false);
        pixels.fit(tile);
        for x in 0..3 {
            for y in 0..2 {
                pixels.set(x, y, [x as f32, y as f32, 1.0]);
            }
        }
        thumbnail.add(tile, &pixels);
        let film = thumbnail.film();
        assert_eq!((film.width, film.height), (5, 2));
        assert_eq!(film.pixel(0, 0), [0.5, 0.5, 1.0]);
        // Half of it is finished.
        assert_eq!(film.pixel(1, 0), [2.0, 0.5, 1.0]);
        assert_eq!(film.pixel(2, 0), [0.0; 3]);
        assert_eq!(film.pixel(0, 1), [0.0; 3]);
        // Small windows are shown as they are.
        assert_eq!(Thumbnail::new(window, 9).film().width, 9);
    }
}
