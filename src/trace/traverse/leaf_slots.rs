//! The primitives of a leaf.

use std::ops::Range;

/// The primitives of a leaf.
#[inline(always)]
pub(super) fn slots_of<T>(all: &[T], slots: Range<usize>) -> &[T] {
    debug_assert!(slots.start <= slots.end && slots.end <= all.len());
    // SAFETY: the range comes from a leaf of a `Bvh`, whose builder pushed exactly these primitives
    // before it wrote the leaf, or which was proven to have them (`bvh::UnverifiedBvh`); an empty
    // leaf is 0..0.
    unsafe { all.get_unchecked(slots) }
}
