//! Pairs of a cell and a triangle of a block, listed without a branch.

use super::cells::CELLS;
use crate::lanes::{LANES, NATIVE};
use crate::trace::order::LANES_OF;

/// All pairs there can be, and eight places more, because eight are written at once.
const ROOM: usize = CELLS * NATIVE + LANES;

/// Pairs that have to be tested.
pub(super) struct Pairs {
    cells: [u8; ROOM],
    lanes: [u8; ROOM],
    pub(super) count: usize,
}

impl Pairs {
    #[inline(always)]
    pub(super) fn none() -> Pairs {
        Pairs {
            cells: [0; ROOM],
            lanes: [0; ROOM],
            count: 0,
        }
    }

    /// Adds a cell with each of some lanes: eight are written at a time, and as many kept as there are.
    #[inline(always)]
    pub(super) fn add(&mut self, cell: usize, lanes: u32) {
        for first in (0..NATIVE).step_by(LANES) {
            let (at, lanes) = (self.count, (lanes >> first) as u8);
            // SAFETY: each cell is added once with `NATIVE` lanes at most, so there are eight places left.
            let (cells, places) = unsafe {
                (
                    self.cells.get_unchecked_mut(at..at + LANES),
                    self.lanes.get_unchecked_mut(at..at + LANES),
                )
            };
            cells.copy_from_slice(&[cell as u8; LANES]);
            places.copy_from_slice(&LANES_OF[0][lanes as usize].map(|lane| lane + first as u8));
            self.count += lanes.count_ones() as usize;
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, k: usize) -> (usize, usize) {
        // SAFETY: `k` is below `count`, which is within both.
        let (cell, lane) = unsafe { (*self.cells.get_unchecked(k), *self.lanes.get_unchecked(k)) };
        (cell as usize % CELLS, lane as usize % NATIVE)
    }
}
