//! Memory that has been freed goes back to the system, where `--max-memory` is to be kept to.
//!
//! glibc maps what is large and unmaps it when it is freed, but what counts as large it learns from
//! the program: 128 KiB at first, and up to 32 MiB as soon as something of that size has been
//! freed. A reader's columns then come out of a heap for each thread, which keeps what was freed,
//! and a peak may be twice what is held. What is large is therefore said once. That costs up to a
//! sixth of the time of loading, so only where memory counts.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub use glibc::give_back;

/// Nothing is done: other allocators do as they do.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn give_back() {}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod glibc {
    use std::ffi::c_int;

    /// Bytes from which on memory is mapped on its own: glibc's first guess.
    const LARGE: c_int = 128 << 10;

    /// Asks for it, from now on.
    pub fn give_back() {
        // SAFETY: the call takes two numbers and no pointers, locks what it changes, and leaves
        // alone what has been allocated: each block knows whether it was mapped. Where it is
        // refused, everything stays as it was.
        unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE) };
    }
}
