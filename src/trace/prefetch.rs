//! Prefetching of memory.

pub(crate) const LINE: usize = 64;

/// Prefetches the lines of a row into the first-level cache. Has no effect on architectures other
/// than x86-64 and 64-bit ARM.
#[inline(always)]
pub(crate) fn prefetch<T>(rows: &[T], index: u32) {
    let row = rows.as_ptr().wrapping_add(index as usize).addr();
    for line in 0..size_of::<T>().div_ceil(LINE) {
        line_at(row.wrapping_add(LINE * line));
    }
}

/// Prefetches the line at an address, which may be any.
#[inline(always)]
pub(crate) fn line_at(address: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let line = std::ptr::without_provenance::<i8>(address);
        // SAFETY: every x86-64 has the instruction, and it has no effect but on caches, whatever
        // the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line) };
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: the instruction has no effect but on caches, whatever the address. It has no stable
    // name in the standard library.
    unsafe {
        std::arch::asm!(
            "prfm pldl1keep, [{}]",
            in(reg) address,
            options(nostack, preserves_flags, readonly)
        );
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = address;
}
