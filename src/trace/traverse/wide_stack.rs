//! Pushes the children of a wide node onto the stack of a single ray, without a branch.
//!
//! Children are stored in order along an axis, see [`crate::bvh::WideNode::axis`], so that the
//! ray's direction along it gives the nearest one. That is not the order of their entry distances.
//! But a network that sorts these is half of the instructions of a node, and saves no more than 4 %
//! of the nodes (`perf/notes/single-rays.md`).

#[cfg(all(
    target_arch = "x86_64",
    target_feature = "avx2",
    not(target_feature = "avx512f")
))]
use crate::simd::COMPACT_LUT;
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx512f")))]
use crate::simd::LaneMove;
use crate::simd::{NATIVE, Native};
use std::cell::Cell;
use std::mem::ManuallyDrop;
use std::ops::Range;

/// Children waiting to be visited, as columns: the distance at which each begins, and its code.
pub(super) struct WideStack {
    tnear: Vec<f32>,
    code: Vec<u32>,
}

thread_local! {
    static STACK: Cell<Option<Box<WideStack>>> = const { Cell::new(None) };
}

/// The stack of a thread, which keeps its memory from one query to the next. A query within another
/// has a stack of its own.
pub(super) struct ThreadStack(pub(super) ManuallyDrop<Box<WideStack>>);

impl ThreadStack {
    /// The stack, with room for at least `room` entries.
    #[inline(always)]
    pub(super) fn with_room(room: usize) -> ThreadStack {
        ThreadStack(ManuallyDrop::new(
            match STACK.try_with(Cell::take).ok().flatten() {
                Some(stack) if stack.code.len() >= room => stack,
                _ => Box::new(WideStack::with_capacity(room)),
            },
        ))
    }
}

impl Drop for ThreadStack {
    #[inline(always)]
    fn drop(&mut self) {
        // SAFETY: nothing uses the field after this.
        let stack = unsafe { ManuallyDrop::take(&mut self.0) };
        // The thread's place for it is gone while the thread ends.
        let _ = STACK.try_with(|place| place.set(Some(stack)));
    }
}

impl WideStack {
    /// A stack with room for `room` entries, which may be divided into several stacks.
    fn with_capacity(room: usize) -> WideStack {
        WideStack {
            tnear: vec![0.0; room],
            code: vec![0; room],
        }
    }

    /// Writes some children of a node, those `met` as bits, from `top` on, in their stored order or
    /// `reversed`, and arbitrary entries behind them. Returns their number.
    ///
    /// # Safety
    /// There must be room for [`NATIVE`] entries from `top` on.
    #[inline(always)]
    pub(super) unsafe fn push_hits(
        &mut self,
        top: usize,
        reversed: bool,
        met: u32,
        enter: Native,
        codes: &[u32; NATIVE],
    ) -> usize {
        debug_assert!(top + NATIVE <= self.code.len());
        // SAFETY: both columns have the same length, and room for as many entries from `top` on:
        // the caller's promise.
        let to = unsafe {
            (
                &mut *self.tnear.as_mut_ptr().add(top).cast::<[f32; NATIVE]>(),
                &mut *self.code.as_mut_ptr().add(top).cast::<[u32; NATIVE]>(),
            )
        };
        push_simd(reversed, met, enter, codes, to);
        met.count_ones() as usize
    }

    /// Writes some children as [`WideStack::push_hits`] does, but in their stored order and without
    /// their distances. Any hit needs no more: its limit does not change, and rays that hit nothing
    /// visit the same nodes in any order. The others visit 1 % fewer in the mean of seven scenes
    /// (`perf/notes/single-rays.md`).
    ///
    /// # Safety
    /// There must be room for [`NATIVE`] entries from `top` on.
    #[inline(always)]
    pub(super) unsafe fn push_any(&mut self, top: usize, met: u32, codes: &[u32; NATIVE]) -> usize {
        debug_assert!(top + NATIVE <= self.code.len());
        // SAFETY: there is room for as many entries from `top` on: the caller's promise.
        let to = unsafe { &mut *self.code.as_mut_ptr().add(top).cast::<[u32; NATIVE]>() };
        compact(met, codes, to);
        met.count_ones() as usize
    }

    /// The code of an entry.
    ///
    /// # Safety
    /// `index` must be below the stack's room.
    #[inline(always)]
    pub(super) unsafe fn code(&self, index: usize) -> u32 {
        // SAFETY: the caller's promise.
        unsafe { *self.code.get_unchecked(index) }
    }

    /// The distance at which an entry begins, if it was written by [`WideStack::push_hits`].
    ///
    /// # Safety
    /// `index` must be below the stack's room.
    #[inline(always)]
    pub(super) unsafe fn tnear(&self, index: usize) -> f32 {
        // SAFETY: the caller's promise.
        unsafe { *self.tnear.get_unchecked(index) }
    }

    /// Keeps the entries of a stack that begin at a distance of at most `limit`, and returns its
    /// new end.
    #[inline(always)]
    pub(super) fn prune(&mut self, stack: Range<usize>, limit: f32) -> usize {
        let start = stack.start;
        let (enter, code) = (&mut self.tnear[stack.clone()], &mut self.code[stack]);
        let mut count = 0;
        for k in 0..enter.len().min(code.len()) {
            let one = (enter[k], code[k]);
            (enter[count], code[count]) = one;
            count += usize::from(one.0 <= limit);
        }
        start + count
    }
}

/// Writes the numbers of the selected lanes, in order, and arbitrary values behind them.
#[cfg(all(target_arch = "x86_64", target_feature = "avx512f"))]
#[inline(always)]
fn compact(lanes: u32, from: &[u32; NATIVE], to: &mut [u32; NATIVE]) {
    use std::arch::x86_64::*;
    // SAFETY: the build has the instructions, see the attribute; and the arrays are sixteen long.
    unsafe {
        let from = _mm512_loadu_si512(from.as_ptr().cast());
        let compact = _mm512_maskz_compress_epi32(lanes as u16, from);
        _mm512_storeu_si512(to.as_mut_ptr().cast(), compact);
    }
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx512f")))]
#[inline(always)]
fn compact(lanes: u32, from: &[u32; NATIVE], to: &mut [u32; NATIVE]) {
    *to = LaneMove::new(lanes, 0).numbers(from);
}

#[cfg_attr(
    any(
        all(target_arch = "x86_64", target_feature = "avx2"),
        target_arch = "aarch64"
    ),
    allow(dead_code, reason = "another replaces it, and is tested against it")
)]
#[inline(always)]
fn push_scalar(
    reversed: bool,
    met: u32,
    enter: Native,
    codes: &[u32; NATIVE],
    (to_enter, to_code): (&mut [f32; NATIVE], &mut [u32; NATIVE]),
) {
    let enter = enter.to_array();
    let mut count = 0;
    for k in 0..NATIVE {
        let lane = if reversed { NATIVE - 1 - k } else { k };
        // Always written, but kept only if it is hit: no branch. At most k entries were written
        // before.
        (to_enter[count % NATIVE], to_code[count % NATIVE]) = (enter[lane], codes[lane]);
        count += (met >> lane & 1) as usize;
    }
}

#[cfg(not(any(
    all(target_arch = "x86_64", target_feature = "avx2"),
    target_arch = "aarch64"
)))]
use push_scalar as push_simd;

#[cfg(target_arch = "aarch64")]
#[inline(always)]
fn push_simd(
    reversed: bool,
    met: u32,
    enter: Native,
    codes: &[u32; NATIVE],
    (to_enter, to_code): (&mut [f32; NATIVE], &mut [u32; NATIVE]),
) {
    let to_front = LaneMove::to_front(met, reversed);
    *to_enter = to_front.floats(enter).to_array();
    *to_code = to_front.numbers(codes);
}

#[cfg(all(
    target_arch = "x86_64",
    target_feature = "avx2",
    not(target_feature = "avx512f")
))]
#[inline(always)]
fn push_simd(
    reversed: bool,
    met: u32,
    enter: Native,
    codes: &[u32; NATIVE],
    (to_enter, to_code): (&mut [f32; NATIVE], &mut [u32; NATIVE]),
) {
    use std::arch::x86_64::*;
    let lanes = &COMPACT_LUT[usize::from(reversed)][met as usize % 256];
    let enter = enter.to_array();
    // SAFETY: the build has the instructions, see the attribute; and the arrays are eight long.
    unsafe {
        let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(lanes.as_ptr().cast()));
        let enter = _mm256_loadu_ps(enter.as_ptr());
        let codes = _mm256_loadu_si256(codes.as_ptr().cast());
        let (enter, codes) = (
            _mm256_permutevar8x32_ps(enter, order),
            _mm256_permutevar8x32_epi32(codes, order),
        );
        _mm256_storeu_ps(to_enter.as_mut_ptr(), enter);
        _mm256_storeu_si256(to_code.as_mut_ptr().cast(), codes);
    }
}

#[cfg(all(target_arch = "x86_64", target_feature = "avx512f"))]
#[inline(always)]
fn push_simd(
    reversed: bool,
    met: u32,
    enter: Native,
    codes: &[u32; NATIVE],
    (to_enter, to_code): (&mut [f32; NATIVE], &mut [u32; NATIVE]),
) {
    use std::arch::x86_64::*;
    let enter = enter.to_array();
    // Lane k takes lane k, or the last met one less k: both as (k ^ flip) + first.
    let (flip, first) = if reversed { (-1, met.count_ones() as i32) } else { (0, 0) };
    // SAFETY: the build has the instructions, see the attribute; and the arrays are sixteen long.
    unsafe {
        let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
        let flipped = _mm512_xor_si512(lanes, _mm512_set1_epi32(flip));
        let order = _mm512_add_epi32(flipped, _mm512_set1_epi32(first));
        let enter = _mm512_loadu_ps(enter.as_ptr());
        let codes = _mm512_loadu_si512(codes.as_ptr().cast());
        // Compressed in a register and stored whole: compression to memory takes a hundred cycles
        // on some processors.
        let enter = _mm512_maskz_compress_ps(met as u16, enter);
        let codes = _mm512_maskz_compress_epi32(met as u16, codes);
        _mm512_storeu_ps(to_enter.as_mut_ptr(), _mm512_permutexvar_ps(order, enter));
        let codes = _mm512_permutexvar_epi32(order, codes);
        _mm512_storeu_si512(to_code.as_mut_ptr().cast(), codes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{LaneMask, Lanes};

    fn random(seed: u32) -> impl FnMut() -> u32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        }
    }

    #[test]
    fn what_is_met_comes_first_and_as_it_lies() {
        let mut next = random(1);
        let mut waiting = WideStack::with_capacity(24 + NATIVE);
        for round in 0..20_000 {
            let best = (next() % 1000) as f32 * 0.37;
            let enter: [f32; NATIVE] =
                std::array::from_fn(|_| (next() % 1200) as f32 * 0.37 - 60.0);
            // Some exits equal the entry, one is at the best, some lie behind the ray, and one is
            // NaN.
            let leave = |enter: &f32| {
                [*enter, enter - 0.1, enter + 90.0, best, f32::NAN][next() as usize % 5]
            };
            let leave = enter.each_ref().map(leave);
            let codes: [u32; NATIVE] = std::array::from_fn(|_| next());
            let (reversed, top) = (round % 2 == 1, round % 22);
            let begin = |lane: usize| enter[lane].max(0.0);
            // An exit that is NaN counts as the best.
            let of_met = (0..NATIVE).filter(|&lane| begin(lane) <= leave[lane].min(best));
            let mut want: Vec<(f32, u32)> = of_met.map(|lane| (begin(lane), codes[lane])).collect();
            if reversed {
                want.reverse();
            }
            let enter = Native::new(enter).max(Native::ZERO);
            let met = enter.le(Native::new(leave).min(Native::splat(best))).bits();
            // SAFETY: there is room for as many entries from 22 on.
            let count = unsafe { waiting.push_hits(top, reversed, met, enter, &codes) };
            let places = top..top + count;
            let pushed = places.map(|k| (waiting.tnear[k], waiting.code[k]));
            assert_eq!(pushed.collect::<Vec<_>>(), want);
            // SAFETY: as above.
            let any = unsafe { waiting.push_any(top, met, &codes) };
            let codes_of = |all: &[(f32, u32)]| all.iter().map(|one| one.1).collect::<Vec<_>>();
            let mut stored = codes_of(&want);
            if reversed {
                stored.reverse();
            }
            assert_eq!(waiting.code[top..top + any], stored);
            let (mut enters, mut pushed) = ([0.0; NATIVE], [0; NATIVE]);
            let to = (&mut enters, &mut pushed);
            push_scalar(reversed, met, enter, &codes, to);
            let pushed = enters.into_iter().zip(pushed).take(count);
            assert_eq!(pushed.collect::<Vec<_>>(), want);
        }
    }

    #[test]
    fn what_begins_behind_the_limit_is_left_out() {
        let mut next = random(7);
        let distances = [0.0, 0.5, 1.0, 1.0 + f32::EPSILON, 3e30, f32::INFINITY];
        for _ in 0..5_000 {
            let mut pick = || distances[next() as usize % distances.len()];
            let limit = pick();
            let mut waiting = WideStack {
                tnear: (0..20).map(|_| pick()).collect(),
                code: (0..20).collect(),
            };
            let all: Vec<(f32, u32)> = waiting.tnear.iter().copied().zip(0..).collect();
            let end = waiting.prune(3..17, limit);
            let want = all[3..17].iter().filter(|one| one.0 <= limit).copied();
            let sorted = (3..end).map(|k| (waiting.tnear[k], waiting.code[k]));
            assert_eq!(
                sorted.collect::<Vec<_>>(),
                want.collect::<Vec<_>>(),
                "{all:?}"
            );
            let is_equal = |k: &usize| (waiting.tnear[*k], waiting.code[*k]) == all[*k];
            assert!(
                (0..3).chain(17..20).all(|k| is_equal(&k)),
                "others are left alone"
            );
        }
    }
}
