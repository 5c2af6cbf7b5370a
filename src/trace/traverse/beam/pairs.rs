//! Pairs of a sub-beam and a triangle of a block, listed without a branch.

use super::sub_beams::MAX_SUB_BEAMS;
use crate::simd::{COMPACT_LUT, LANES, NATIVE};

/// Maximum number of blocks whose pairs are listed together.
pub(super) const BLOCKS: usize = 8;

/// Maximum number of pairs, plus eight, because eight are written at once.
const ROOM: usize = BLOCKS * MAX_SUB_BEAMS * NATIVE + LANES;

/// Factor that copies a byte to each of eight bytes.
const EACH: u64 = 0x0101_0101_0101_0101;

/// Pairs to be tested.
pub(super) struct Pairs {
    sub_beams: [u8; ROOM],
    /// Triangle of each pair: its lane, plus `NATIVE` for each block before its own.
    triangles: [u8; ROOM],
    pub(super) count: usize,
}

impl Pairs {
    #[inline(always)]
    pub(super) fn none() -> Pairs {
        Pairs {
            sub_beams: [0; ROOM],
            triangles: [0; ROOM],
            count: 0,
        }
    }

    /// Adds pairs of a sub-beam with the given lanes of the `block`-th block. Eight pairs are
    /// written at a time, and one per lane is kept.
    #[inline(always)]
    pub(super) fn add(&mut self, sub_beam: usize, block: usize, lanes: u32) {
        for first in (0..NATIVE).step_by(LANES) {
            let (first_free, lanes) = (self.count, (lanes >> first) as u8);
            // SAFETY: each sub-beam is added once with `NATIVE` lanes of `BLOCKS` at most, so there
            // is room for eight more.
            let (sub_beams, triangles) = unsafe {
                (
                    self.sub_beams
                        .get_unchecked_mut(first_free..first_free + LANES),
                    self.triangles
                        .get_unchecked_mut(first_free..first_free + LANES),
                )
            };
            // Added as eight-byte numbers: arrays would be assembled byte by byte.
            let base = (block % BLOCKS * NATIVE + first) as u64 * EACH;
            let of_lanes = u64::from_le_bytes(COMPACT_LUT[0][lanes as usize]);
            sub_beams.copy_from_slice(&(sub_beam as u64 * EACH).to_le_bytes());
            triangles.copy_from_slice(&(of_lanes + base).to_le_bytes());
            self.count += lanes.count_ones() as usize;
        }
    }

    /// Keeps the pairs for which `keep` returns true, without a branch.
    #[inline(always)]
    pub(super) fn retain(&mut self, keep: impl Fn(usize, usize) -> bool) {
        let mut count = 0;
        for k in 0..self.count {
            let (sub_beam, triangle) = self.get(k);
            // SAFETY: `count` is not above `k`, which is within both.
            unsafe {
                *self.sub_beams.get_unchecked_mut(count) = sub_beam as u8;
                *self.triangles.get_unchecked_mut(count) = triangle as u8;
            }
            count += usize::from(keep(sub_beam, triangle));
        }
        self.count = count;
    }

    #[inline(always)]
    pub(super) fn get(&self, k: usize) -> (usize, usize) {
        // SAFETY: `k` is below `count`, which is within both.
        let (sub_beam, triangle) = unsafe {
            (
                *self.sub_beams.get_unchecked(k),
                *self.triangles.get_unchecked(k),
            )
        };
        (sub_beam as usize % MAX_SUB_BEAMS, triangle as usize)
    }
}
