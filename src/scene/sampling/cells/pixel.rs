//! A pixel that is halved again and again: the assignment of its cells to its samples.

use super::super::adaptive::BLOCK;

/// Number of bits of a pixel's side, which is 2^24 because samples are known to 24 bits.
pub(super) const BITS: u32 = 24;
pub(super) const PIXEL_SIDE: u32 = 1 << BITS;

/// A sample, and so its cell: the cell of this level in which it lies.
#[derive(Clone, Copy)]
pub(super) struct CellSample {
    pub(super) position: [u32; 2],
    pub(super) radiance: [f32; 3],
    pub(super) weight: f32,
    pub(super) pixel: u8,
    pub(super) level: u8,
    /// True if the cell is not compared with its neighbours yet.
    pub(super) fresh: bool,
    /// True if the cell is to be halved.
    pub(super) active: bool,
}

impl CellSample {
    /// Side of the cell along an axis.
    #[inline]
    pub(super) fn side(&self, axis: usize) -> u32 {
        PIXEL_SIDE >> halvings(self.level, axis)
    }

    /// Beginning of the cell along an axis.
    #[inline]
    pub(super) fn from(&self, axis: usize) -> u32 {
        self.position[axis] & !(self.side(axis) - 1)
    }

    /// Index of the cell, row by row among the cells of its level.
    #[inline]
    pub(super) fn index(&self) -> usize {
        index(self.position, self.level)
    }

    /// Position in the block.
    #[inline]
    pub(super) fn across_block(&self, axis: usize) -> u32 {
        let (x, y) = column_and_row(self.pixel.into());
        [x, y][axis] * PIXEL_SIDE + self.position[axis]
    }
}

/// Number of times that a cell of this level has been halved along an axis: across first.
#[inline]
pub(super) fn halvings(level: u8, axis: usize) -> u32 {
    (u32::from(level) + 1 - axis as u32) / 2
}

/// Index, row by row, of the cell of this level in which a position of a pixel lies.
#[inline]
pub(super) fn index(position: [u32; 2], level: u8) -> usize {
    let [column, row] = [0, 1].map(|axis| position[axis] >> (BITS - halvings(level, axis)));
    (row << halvings(level, 0) | column) as usize
}

/// A pixel of a block.
#[derive(Default)]
pub(super) struct CellPixel {
    /// Level of the pixel's smallest cells. `samples` gives, for each cell of this level, the
    /// sample in whose cell it lies; it is empty outside the picture.
    pub(super) level: u8,
    pub(super) samples: Vec<u32>,
    /// Numbers of the samples that halve cells. The entries from 2^k on are those of the cells of
    /// level k, as far as they have been requested.
    pub(super) halving: Vec<u32>,
}

impl CellPixel {
    #[inline]
    pub(super) fn clear(&mut self) {
        self.level = 0;
        self.samples.clear();
        self.halving.clear();
    }

    #[inline]
    pub(super) fn sample_at(&self, position: [u32; 2]) -> u32 {
        self.samples[index(position, self.level)]
    }

    /// Doubles `samples`, so that each half of the smallest cells has an entry of its own.
    pub(super) fn refine(&mut self) {
        let columns = 1 << halvings(self.level, 0);
        let old = std::mem::take(&mut self.samples);
        self.samples.reserve(2 * old.len());
        for row in old.chunks(columns) {
            match self.level % 2 {
                0 => self
                    .samples
                    .extend(row.iter().flat_map(|&sample| [sample; 2])),
                _ => (0..2).for_each(|_| self.samples.extend(row)),
            }
        }
        self.level += 1;
    }

    /// Assigns a sample its cell.
    pub(super) fn fill(&mut self, sample: &CellSample, number: u32) {
        while self.level < sample.level {
            self.refine();
        }
        let cells = |axis: usize| {
            let shift = BITS - halvings(self.level, axis);
            let from = sample.from(axis);
            (from >> shift) as usize..((from + sample.side(axis)) >> shift) as usize
        };
        let (columns, rows) = (cells(0), cells(1));
        for row in rows {
            let row = row << halvings(self.level, 0);
            self.samples[row + columns.start..row + columns.end].fill(number);
        }
    }
}

#[inline]
pub(super) fn column_and_row(pixel: usize) -> (u32, u32) {
    (pixel as u32 % BLOCK, pixel as u32 / BLOCK)
}

/// The k-th pixel of a block in the order of packets of 4x2. The map is its own inverse, so it also
/// gives the index in packets of a pixel.
#[inline]
pub(super) fn in_packets(k: usize) -> usize {
    // A pixel has the bits yyyxxx, its index in packets yyxyxx. The bit of x that selects the half
    // and the lowest bit of y change places.
    let (half, row) = (k >> 2 & 1, k >> 3 & 1);
    k & !0b1100 | row << 2 | half << 3
}
