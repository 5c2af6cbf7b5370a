//! Cells that touch, and the comparison of their samples.

use super::super::adaptive::BLOCK;
use super::Cells;
use super::pixel::{BITS, CellSample, PIXEL_SIDE, column_and_row, halvings};

impl Cells {
    /// Compares fresh cells with their neighbours, and returns the samples of the cells that are to
    /// be halved.
    pub(super) fn compare(&mut self) -> Vec<u32> {
        let (mut open, mut neighbours) = (Vec::new(), Vec::new());
        let mut fresh = std::mem::take(&mut self.fresh);
        for &here in &fresh {
            self.samples[here as usize].fresh = false;
            for (axis, upper) in [(0, false), (0, true), (1, false), (1, true)] {
                neighbours.clear();
                self.side_neighbours(here, axis, upper, &mut neighbours);
                for &neighbour in &neighbours {
                    // A pair of fresh cells is compared when the second one is visited.
                    if self.samples[neighbour as usize].fresh {
                        continue;
                    }
                    let both = if upper { [here, neighbour] } else { [neighbour, here] };
                    let too_different = self.too_different(both, axis);
                    for (sample, too_different) in both.into_iter().zip(too_different) {
                        let is_open = &mut self.samples[sample as usize].active;
                        if too_different && !std::mem::replace(is_open, true) {
                            open.push(sample);
                        }
                    }
                }
            }
        }
        fresh.clear();
        self.fresh = fresh;
        open
    }

    /// Appends the samples whose cells touch a side of a sample's cell.
    #[inline]
    fn side_neighbours(&self, sample: u32, axis: usize, upper: bool, neighbours: &mut Vec<u32>) {
        let sample = &self.samples[sample as usize];
        let (from, side) = (sample.from(axis), sample.side(axis));
        let pixel = usize::from(sample.pixel);
        let place = column_and_row(pixel);
        let place = [place.0, place.1][axis];
        let step = [1, BLOCK as usize][axis];
        let (pixel, along) = if upper && from + side < PIXEL_SIDE {
            (pixel, from + side)
        } else if upper && place + 1 < BLOCK {
            (pixel + step, 0)
        } else if !upper && from > 0 {
            (pixel, from - 1)
        } else if !upper && place > 0 {
            (pixel - step, PIXEL_SIDE - 1)
        } else {
            return;
        };
        let pixel = &self.pixels[pixel];
        if pixel.samples.is_empty() {
            return;
        }
        let across = 1 - axis;
        let shift = [0, 1].map(|axis| BITS - halvings(pixel.level, axis));
        let (first, last) = (
            sample.from(across),
            sample.from(across) + (sample.side(across) - 1),
        );
        let columns = halvings(pixel.level, 0);
        let mut before = u32::MAX;
        for across in first >> shift[across]..=last >> shift[across] {
            let along = along >> shift[axis];
            let cell =
                if axis == 0 { across << columns | along } else { along << columns | across };
            let neighbour = pixel.samples[cell as usize];
            if neighbour != before {
                neighbours.push(neighbour);
                before = neighbour;
            }
        }
    }

    /// Tests which of two cells are to be halved; the second begins where the first ends.
    #[inline]
    fn too_different(&self, samples: [u32; 2], axis: usize) -> [bool; 2] {
        let [low, high] = samples.map(|sample| &self.samples[sample as usize]);
        let [ours, theirs] = [low, high].map(|s| s.radiance.map(f64::from));
        let [r, g, b] = [0, 1, 2].map(|c| ours[c] - theirs[c]);
        let squared = (r * r + g * g) + b * b;
        // Most pairs return here: not even the larger cell would be halved if all of the way lay in
        // it.
        if squared <= self.thresholds[usize::from(low.level.min(high.level))] {
            return [false; 2];
        }
        let [from, to] = [low, high].map(|s| f64::from(s.across_block(axis)));
        let border = f64::from(high.across_block(axis) & !(high.side(axis) - 1));
        // Both sides are multiplied by the way, which saves a division.
        let (way, parts) = (to - from, [border - from, to - border]);
        [(low, parts[0]), (high, parts[1])].map(|(sample, part)| {
            let most = self.thresholds[usize::from(sample.level)];
            sample.level < self.limit && squared * part > most * way
        })
    }

    /// Appends a sample and those whose cells touch its cell, corners included.
    pub(super) fn neighbourhood(&self, sample: u32, neighbours: &mut Vec<u32>) {
        let from = neighbours.len();
        neighbours.push(sample);
        for (axis, upper) in [(0, false), (0, true), (1, false), (1, true)] {
            self.side_neighbours(sample, axis, upper, neighbours);
        }
        let CellSample { pixel, .. } = self.samples[sample as usize];
        let place = column_and_row(pixel.into());
        let sample = &self.samples[sample as usize];
        // One unit beyond the corner of the cell.
        let beyond = |axis: usize, upper: bool| {
            let place = [place.0, place.1][axis] * PIXEL_SIDE + sample.from(axis);
            if upper {
                Some(place + sample.side(axis)).filter(|&c| c < BLOCK * PIXEL_SIDE)
            } else {
                place.checked_sub(1)
            }
        };
        for (right, below) in [(false, false), (true, false), (false, true), (true, true)] {
            let (Some(x), Some(y)) = (beyond(0, right), beyond(1, below)) else {
                continue;
            };
            let pixel = &self.pixels[(y / PIXEL_SIDE * BLOCK + x / PIXEL_SIDE) as usize];
            if pixel.samples.is_empty() {
                continue;
            }
            let corner = pixel.sample_at([x % PIXEL_SIDE, y % PIXEL_SIDE]);
            if !neighbours[from..].contains(&corner) {
                neighbours.push(corner);
            }
        }
    }
}
