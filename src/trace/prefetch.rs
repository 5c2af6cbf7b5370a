//! Rows of memory asked for before they are needed.

use crate::bvh::{Target, Wide};

/// Asks for what a child of a wide node leads to.
#[inline(always)]
pub(super) fn prefetch_target(wide: &Wide, code: u32) {
    match Target::of_code(code) {
        Target::Node(index) => prefetch(wide.nodes(), index),
        Target::Triangles(index) => prefetch(wide.triangles(), index),
        Target::Spheres(index) => prefetch(wide.spheres(), index),
        Target::Other(_) => {}
    }
}

/// Has the lines of a row brought to the first cache. Does nothing where the architecture is not x86-64.
#[inline(always)]
pub(super) fn prefetch<T>(rows: &[T], index: u32) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..size_of::<T>().div_ceil(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let row = rows.as_ptr().wrapping_add(index as usize).cast::<i8>();
        // SAFETY: every x86-64 has the instruction, and it has no effect but on caches, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(row.wrapping_add(64 * line)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (rows, index);
}
