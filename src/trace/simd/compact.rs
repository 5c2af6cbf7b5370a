//! Compaction of selected lanes.

use super::{F32x8, LANES, U32x8};

/// Compaction table: `[0][mask]` lists the set lanes of `mask`, one per byte, in ascending order,
/// and `[1][mask]` in descending order.
pub(crate) static COMPACT_LUT: [[[u8; LANES]; 256]; 2] = {
    let mut tables = [[[0; LANES]; 256]; 2];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut place) = (0, 0);
        let last = (set as u32).count_ones() as usize;
        while lane < LANES {
            if set >> lane & 1 == 1 {
                tables[0][set][place] = lane as u8;
                tables[1][set][last - 1 - place] = lane as u8;
                place += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    tables
};

/// A move of selected lanes, in their order, to consecutive lanes from a given one. Lanes that do
/// not fit wrap around to lane 0, for the following octet.
#[derive(Clone, Copy)]
pub(crate) struct LaneMove {
    /// Source lane of each lane, one per byte.
    order: [u8; LANES],
}

impl LaneMove {
    /// The move of the lanes set in `lanes` to lane `lane` and after it.
    #[inline(always)]
    pub(crate) fn new(lanes: u32, lane: usize) -> LaneMove {
        let order = u64::from_le_bytes(COMPACT_LUT[0][lanes as usize % 256]);
        LaneMove {
            order: order.rotate_left(u8::BITS * lane as u32).to_le_bytes(),
        }
    }

    /// The move of the lanes set in `lanes` to the first lanes, in descending order if `reversed`.
    #[cfg(target_arch = "aarch64")]
    #[inline(always)]
    pub(crate) fn to_front(lanes: u32, reversed: bool) -> LaneMove {
        LaneMove {
            order: COMPACT_LUT[usize::from(reversed)][lanes as usize % 256],
        }
    }

    /// The lanes after the move. Lanes without a source hold copies of others.
    #[inline(always)]
    pub(crate) fn floats(self, from: F32x8) -> F32x8 {
        F32x8::from_bits(U32x8::new(permute(from.to_bits().to_array(), self.order)))
    }

    /// The lanes after the move. Lanes without a source hold copies of others.
    #[inline(always)]
    pub(crate) fn numbers(self, from: &[u32; LANES]) -> [u32; LANES] {
        permute(*from, self.order)
    }
}

#[cfg_attr(
    any(
        all(target_arch = "x86_64", target_feature = "avx2"),
        all(target_arch = "aarch64", target_endian = "little")
    ),
    allow(dead_code, reason = "another replaces it, and is tested against it")
)]
#[inline(always)]
fn permute_scalar(from: [u32; LANES], order: [u8; LANES]) -> [u32; LANES] {
    order.map(|lane| from[lane as usize % LANES])
}

#[cfg(not(any(
    all(target_arch = "x86_64", target_feature = "avx2"),
    all(target_arch = "aarch64", target_endian = "little")
)))]
use permute_scalar as permute;

#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[inline(always)]
fn permute(from: [u32; LANES], order: [u8; LANES]) -> [u32; LANES] {
    use std::arch::x86_64::*;
    let mut to = [0; LANES];
    // SAFETY: the build has the instructions, see the attribute; and the arrays are eight long.
    unsafe {
        let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(order.as_ptr().cast()));
        let from = _mm256_loadu_si256(from.as_ptr().cast());
        let moved = _mm256_permutevar8x32_epi32(from, order);
        _mm256_storeu_si256(to.as_mut_ptr().cast(), moved);
    }
    to
}

/// A look-up of bytes in two registers: four bytes of a lane have the indices from four times its
/// number on.
#[cfg(all(target_arch = "aarch64", target_endian = "little"))]
#[inline(always)]
fn permute(from: [u32; LANES], order: [u8; LANES]) -> [u32; LANES] {
    use std::arch::aarch64::*;
    let mut to = [0; LANES];
    // SAFETY: every 64-bit ARM has the instructions; the arrays are eight long.
    unsafe {
        let from = vld1q_u8_x2(from.as_ptr().cast());
        let order = vmovl_u8(vld1_u8(order.as_ptr()));
        let halves = [vget_low_u16(order), vget_high_u16(order)];
        for (k, half) in halves.into_iter().enumerate() {
            let first = vdupq_n_u32(0x0302_0100);
            let bytes = vmlaq_n_u32(first, vmovl_u16(half), 0x0404_0404);
            let moved = vqtbl2q_u8(from, vreinterpretq_u8_u32(bytes));
            vst1q_u32(to.as_mut_ptr().add(4 * k), vreinterpretq_u32_u8(moved));
        }
    }
    to
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_of_a_set_come_in_order() {
        for (set, lanes) in COMPACT_LUT[0].iter().enumerate() {
            let mut want: Vec<u8> = (0..8).filter(|lane| set >> lane & 1 == 1).collect();
            assert_eq!(lanes[..want.len()], want);
            want.reverse();
            assert_eq!(COMPACT_LUT[1][set][..want.len()], want);
        }
    }

    #[test]
    fn lanes_are_moved_in_their_order() {
        let from: [u32; LANES] = std::array::from_fn(|k| 100 + k as u32);
        for lanes in 0..256_u32 {
            let set: Vec<u32> = (0..8)
                .filter(|k| lanes >> k & 1 == 1)
                .map(|k| from[k])
                .collect();
            for lane in 0..LANES {
                let to = LaneMove::new(lanes, lane);
                let numbers = to.numbers(&from);
                for (k, &want) in set.iter().enumerate() {
                    assert_eq!(numbers[(lane + k) % LANES], want, "{lanes:b} at {lane}");
                }
                let floats = to.floats(F32x8::from_bits(U32x8::new(from)));
                assert_eq!(floats.to_bits().to_array(), numbers);
                assert_eq!(permute_scalar(from, to.order), numbers);
            }
        }
    }
}
