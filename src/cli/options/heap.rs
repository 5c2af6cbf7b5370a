//! Returns freed memory to the system, so that peaks are low and `--max-memory` holds.
//!
//! glibc maps large blocks individually and unmaps them when they are freed. Its threshold adapts:
//! 128 KiB at first, and up to 32 MiB once a block of that size has been freed. From then on a
//! reader's columns come from per-thread heaps, which keep freed memory, and the peak may be twice
//! the memory in use. So the threshold is fixed before a scene is opened. That costs no time that
//! can be measured (`perf/notes/memory.md`).

#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub use glibc::give_back;

/// Does nothing: other allocators have no such setting.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn give_back() {}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod glibc {
    use std::ffi::c_int;

    /// Minimum size in bytes of an individually mapped block: glibc's initial threshold.
    const LARGE: c_int = 128 << 10;

    /// Fixes the threshold from now on.
    pub fn give_back() {
        // SAFETY: the call takes two numbers and no pointers, locks what it changes, and leaves
        // existing blocks alone: each block knows whether it was mapped. If it is refused,
        // everything stays as it was.
        unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE) };
    }
}
