//! Masks of eight lanes as bits, in AVX-512 builds.

use std::arch::x86_64::{__m256i, _mm256_test_epi32_mask};

/// The lanes that are not zero, as bits; not by `vmovmskps`, which knows half of the registers:
/// LLVM 22 uses it with the others, too, and so reads a wrong one
/// (<https://github.com/llvm/llvm-project/issues/191304>).
#[inline(always)]
pub(super) fn bits(lanes: __m256i) -> u32 {
    // SAFETY: the build has the instruction, see the attribute of this module.
    u32::from(unsafe { _mm256_test_epi32_mask(lanes, lanes) })
}
