//! Returns freed memory to the system, so that `--max-memory` can be kept.
//!
//! glibc maps large blocks and unmaps them when they are freed. Its threshold for large adapts to
//! the program: 128 KiB at first, and up to 32 MiB as soon as a block of that size has been freed.
//! A reader's columns then come out of a heap for each thread, which keeps what was freed, and a
//! peak may be twice the memory that is held. The threshold is therefore fixed once. That costs up
//! to a sixth of the time of loading, so it is done only under a limit.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub use glibc::give_back;

/// Does nothing, as other allocators have no such setting.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn give_back() {}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod glibc {
    use std::ffi::c_int;

    /// Size in bytes from which on a block is mapped on its own: glibc's first threshold.
    const LARGE: c_int = 128 << 10;

    /// Fixes the threshold from now on.
    pub fn give_back() {
        // SAFETY: the call takes two numbers and no pointers, locks what it changes, and leaves
        // existing blocks alone: each block knows whether it was mapped. If it is refused,
        // everything stays as it was.
        unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE) };
    }
}
