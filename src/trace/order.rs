//! Children of a wide node onto the stack of a ray on its own, without a branch.
//!
//! Children lie along an axis, see [`crate::bvh::WideNode::axis`], so that the way a ray goes along it tells which comes first. That
//! is not the order of their entry distances; but a network that sorts these takes twice as long as all else that
//! there is to do for a node, and saves few visits.

use crate::lanes::{F32x8, LANES, LaneMask, Mask8};

/// A child waiting to be visited: the bits of its entry distance above its code.
pub(super) type Entry = u64;

/// By set of lanes, as bits: the lanes in it, one a byte, first those of the lower bits; and those of the higher bits first.
pub(super) static LANES_OF: [[[u8; LANES]; 256]; 2] = {
    let mut tables = [[[0; LANES]; 256]; 2];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut at) = (0, 0);
        let last = (set as u32).count_ones() as usize;
        while lane < LANES {
            if set >> lane & 1 == 1 {
                tables[0][set][at] = lane as u8;
                tables[1][set][last - 1 - at] = lane as u8;
                at += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    tables
};

/// Writes the entries of the children that are met, in the order in which they lie or `reversed`, and others behind them; tells
/// how many are met.
#[inline(always)]
pub(super) fn write(
    met: Mask8,
    reversed: bool,
    enter: F32x8,
    codes: &[u32; LANES],
    to: &mut [Entry; LANES],
) -> usize {
    let met = met.bits();
    let lanes = &LANES_OF[usize::from(reversed)][met as usize % 256];
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    at_once(lanes, enter, codes, to);
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
    one_by_one(lanes, enter, codes, to);
    met.count_ones() as usize
}

#[cfg_attr(
    all(target_arch = "x86_64", target_feature = "avx2"),
    allow(dead_code, reason = "the other replaces it, and is tested against it")
)]
#[inline(always)]
fn one_by_one(lanes: &[u8; LANES], enter: F32x8, codes: &[u32; LANES], to: &mut [Entry; LANES]) {
    let distances = enter.to_bits().to_array();
    for (entry, &lane) in to.iter_mut().zip(lanes) {
        let lane = usize::from(lane) % LANES;
        *entry = u64::from(distances[lane]) << 32 | u64::from(codes[lane]);
    }
}

#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[inline(always)]
fn at_once(lanes: &[u8; LANES], enter: F32x8, codes: &[u32; LANES], to: &mut [Entry; LANES]) {
    use std::arch::x86_64::*;
    let distances = enter.to_bits().to_array();
    // SAFETY: the build has the instructions, see the attribute; and the arrays are eight long.
    unsafe {
        let load = |lanes: &[u32; LANES]| _mm256_loadu_si256(lanes.as_ptr().cast());
        let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(lanes.as_ptr().cast()));
        let distance = _mm256_permutevar8x32_epi32(load(&distances), order);
        let code = _mm256_permutevar8x32_epi32(load(codes), order);
        let even = _mm256_unpacklo_epi32(code, distance);
        let odd = _mm256_unpackhi_epi32(code, distance);
        let first = _mm256_permute2x128_si256::<0x20>(even, odd);
        let last = _mm256_permute2x128_si256::<0x31>(even, odd);
        _mm256_storeu_si256(to.as_mut_ptr().cast(), first);
        _mm256_storeu_si256(to.as_mut_ptr().add(4).cast(), last);
    }
}

/// Leaves those entries that begin at a distance of `limit` at most, and tells how many they are.
#[inline(always)]
pub(super) fn keep(entries: &mut [Entry], limit: f32) -> usize {
    // Distances are not negative, so their bits order as they do.
    let most = u64::from(limit.to_bits()) << 32 | u64::from(u32::MAX);
    let mut count = 0;
    for k in 0..entries.len() {
        let entry = entries[k];
        entries[count] = entry;
        count += usize::from(entry <= most);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(seed: u32) -> impl FnMut() -> u32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        }
    }

    fn packed(distance: f32, code: u32) -> Entry {
        u64::from(distance.to_bits()) << 32 | u64::from(code)
    }

    #[test]
    fn lanes_of_a_set_come_in_order() {
        for (set, lanes) in LANES_OF[0].iter().enumerate() {
            let mut want: Vec<u8> = (0..8).filter(|lane| set >> lane & 1 == 1).collect();
            assert_eq!(lanes[..want.len()], want);
            want.reverse();
            assert_eq!(LANES_OF[1][set][..want.len()], want);
        }
    }

    #[test]
    fn what_is_met_comes_first_and_as_it_lies() {
        let mut next = random(1);
        for round in 0..20_000 {
            let enter: [f32; LANES] = std::array::from_fn(|_| (next() % 1000) as f32 * 0.37);
            let codes: [u32; LANES] = std::array::from_fn(|_| next());
            let (met, reversed) = (next() & 0xff, round % 2 == 1);
            let mut want: Vec<Entry> = (0..LANES)
                .filter(|lane| met >> lane & 1 == 1)
                .map(|lane| packed(enter[lane], codes[lane]))
                .collect();
            if reversed {
                want.reverse();
            }
            let mut found = [u64::MAX; LANES];
            let enter = F32x8::new(enter);
            let count = write(Mask8::from_bits(met), reversed, enter, &codes, &mut found);
            assert_eq!(found[..count], want);
            let lanes = &LANES_OF[usize::from(reversed)][met as usize];
            one_by_one(lanes, enter, &codes, &mut found);
            assert_eq!(found[..count], want);
        }
    }

    #[test]
    fn what_begins_behind_the_limit_is_left_out() {
        let mut next = random(7);
        let distances = [0.0, 0.5, 1.0, 1.0 + f32::EPSILON, 3e30, f32::INFINITY];
        for _ in 0..5_000 {
            let mut pick = || distances[next() as usize % distances.len()];
            let limit = pick();
            let entries: Vec<(f32, u32)> = (0..20).map(|k| (pick(), !k)).collect();
            let mut kept: Vec<Entry> = entries.iter().map(|e| packed(e.0, e.1)).collect();
            let left = keep(&mut kept, limit);
            let want = entries.iter().filter(|entry| entry.0 <= limit);
            let want: Vec<Entry> = want.map(|e| packed(e.0, e.1)).collect();
            assert_eq!(kept[..left], want, "limit {limit}: {entries:?}");
        }
    }
}
