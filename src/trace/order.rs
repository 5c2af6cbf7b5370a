//! Eight children in the order of their entry distances, farthest first, without a branch.

use crate::lanes::{F32x8, LANES, LaneMask, Lanes, Mask8, U32x8};

/// A child waiting to be visited: the bits of its entry distance above its code.
pub(super) type Entry = u64;

/// Writes the entries of the children that are met, the farthest first, and others behind them.
///
/// Distances are rounded down to 21 bits, and never up: which child comes first among nearly equal ones matters to no answer.
#[inline(always)]
pub(super) fn write(met: Mask8, enter: F32x8, codes: &[u32; LANES], to: &mut [Entry; LANES]) {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    network(met, enter, codes, to);
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
    count(met, enter, codes, to);
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

/// Each at a place found by counting which are farther.
#[cfg_attr(
    target_feature = "avx2",
    allow(
        dead_code,
        reason = "the network replaces it, and is tested against it"
    )
)]
#[inline(always)]
fn count(met: Mask8, enter: F32x8, codes: &[u32; LANES], to: &mut [Entry; LANES]) {
    let lane = U32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
    let bits = enter.to_bits().shift_right(3).shift_left(3).or(lane);
    // Below zero, and all different: what is not met comes last.
    let missed = F32x8::new([-1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0, -8.0]);
    let keys = met.select(F32x8::from_bits(bits), missed);
    let key_bits = keys.to_bits().to_array();
    for child in 0..LANES {
        let farther = keys.gt(F32x8::splat(f32::from_bits(key_bits[child])));
        let place = farther.bits().count_ones() as usize;
        // Without the lane: a distance that is too large would keep a child from being visited.
        to[place % LANES] = u64::from(key_bits[child] & !7) << 32 | u64::from(codes[child]);
    }
}

/// A bitonic network over eight distances in one register (Batcher, "Sorting Networks and Their Applications", 1968): they are
/// not negative, so their bits order as they do. A lane's number stands below its distance, as in [`count`], so that both
/// order alike, and tells in the end which code goes with it.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[inline(always)]
fn network(met: Mask8, enter: F32x8, codes: &[u32; LANES], to: &mut [Entry; LANES]) {
    use std::arch::x86_64::*;
    let enter = enter.to_bits().to_array();
    let met = met.select(F32x8::from_bits(U32x8::new([u32::MAX; LANES])), F32x8::ZERO);
    let met = met.to_bits().to_array();
    // SAFETY: the build has the instructions, see the attribute; and the arrays are eight long.
    unsafe {
        let load = |lanes: &[u32; LANES]| _mm256_loadu_si256(lanes.as_ptr().cast());
        let (low, lanes) = (
            _mm256_set1_epi32(7),
            _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
        );
        // What is not met is like lane 0 at distance 0. That does no harm: if this one is met, it is the last of those that are,
        // and if not, none like it is.
        let kept = _mm256_andnot_si256(low, load(&enter));
        let v = _mm256_and_si256(_mm256_or_si256(kept, lanes), load(&met));
        // Each step: every entry against its partner; the mask tells which keep the larger.
        let v = step::<0b1001_1001>(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v));
        let v = step::<0b1100_0011>(v, _mm256_shuffle_epi32::<0b01_00_11_10>(v));
        let v = step::<0b1010_0101>(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v));
        let v = step::<0b0000_1111>(v, _mm256_permute2x128_si256::<1>(v, v));
        let v = step::<0b0011_0011>(v, _mm256_shuffle_epi32::<0b01_00_11_10>(v));
        let v = step::<0b0101_0101>(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v));
        let distance = _mm256_andnot_si256(low, v);
        let code = _mm256_permutevar8x32_epi32(load(codes), v);
        let even = _mm256_unpacklo_epi32(code, distance);
        let odd = _mm256_unpackhi_epi32(code, distance);
        let near = _mm256_permute2x128_si256::<0x20>(even, odd);
        let far = _mm256_permute2x128_si256::<0x31>(even, odd);
        _mm256_storeu_si256(to.as_mut_ptr().cast(), near);
        _mm256_storeu_si256(to.as_mut_ptr().add(4).cast(), far);
    }
}

/// The larger of each two where `LARGER` has a bit, else the smaller.
///
/// # Safety
/// The build has AVX2.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[inline(always)]
unsafe fn step<const LARGER: i32>(
    v: std::arch::x86_64::__m256i,
    partner: std::arch::x86_64::__m256i,
) -> std::arch::x86_64::__m256i {
    use std::arch::x86_64::*;
    // SAFETY: as the caller says.
    unsafe {
        let (least, most) = (_mm256_min_epu32(v, partner), _mm256_max_epu32(v, partner));
        _mm256_blend_epi32::<LARGER>(least, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_begins_behind_the_limit_is_left_out() {
        let mut state = 7u32;
        for _ in 0..5_000 {
            let mut next = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                state >> 16
            };
            let distances = [0.0, 0.5, 1.0, 1.0 + f32::EPSILON, 3e30, f32::INFINITY];
            let mut pick = || distances[next() as usize % distances.len()];
            let limit = pick();
            let count = 1 + pick().to_bits() as usize % 19;
            let entries: Vec<(f32, u32)> = (0..count).map(|k| (pick(), !(k as u32))).collect();
            let packed = |&(distance, code): &(f32, u32)| {
                u64::from(distance.to_bits()) << 32 | u64::from(code)
            };
            let mut kept: Vec<Entry> = entries.iter().map(packed).collect();
            let left = keep(&mut kept, limit);
            let want = entries.iter().filter(|entry| entry.0 <= limit);
            let want: Vec<Entry> = want.map(packed).collect();
            assert_eq!(kept[..left], want, "limit {limit}: {entries:?}");
        }
    }

    #[test]
    fn the_farthest_comes_first_and_what_is_not_met_last() {
        let mut state = 1u32;
        for _ in 0..20_000 {
            let mut next = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                state >> 8
            };
            let enter: [f32; LANES] = std::array::from_fn(|_| (next() % 7) as f32 * 0.5);
            let codes: [u32; LANES] = std::array::from_fn(|k| k as u32 * 1000 + 5);
            let met = next() & 0xff;
            let count = met.count_ones() as usize;
            let mut both = [[u64::MAX; LANES]; 2];
            for (which, to) in [write, super::count].into_iter().zip(&mut both) {
                which(Mask8::from_bits(met), F32x8::new(enter), &codes, to);
                let found = to[..count].iter();
                let mut found: Vec<(f32, u32)> = found
                    .map(|e| (f32::from_bits((e >> 32) as u32), *e as u32))
                    .collect();
                assert!(found.is_sorted_by(|a, b| a.0 >= b.0), "{found:?}");
                for (distance, code) in &mut found {
                    let lane = (*code as usize - 5) / 1000;
                    assert!(met >> lane & 1 == 1, "{lane} is not met: {met:08b}");
                    assert!(*distance <= enter[lane] && *distance >= enter[lane] * 0.999_999);
                }
                let mut lanes: Vec<u32> = found.iter().map(|f| f.1).collect();
                lanes.sort_unstable();
                lanes.dedup();
                assert_eq!(lanes.len(), count, "each once");
            }
            assert_eq!(both[0][..count], both[1][..count], "both alike");
        }
    }
}
