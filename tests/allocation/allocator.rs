//! The allocator of this test binary. It counts each thread's requests and memory, and records the
//! largest single request of all threads.
#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The system's allocator, with counters.
struct Counting;

/// Largest single request of any thread, in bytes.
static LARGEST: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Allocations and reallocations of this thread. Const and without a destructor, so reading it
    /// allocates nothing.
    static ASKED: Cell<u64> = const { Cell::new(0) };
    /// Bytes that this thread holds, and its peak.
    static HELD: Cell<(i64, i64)> = const { Cell::new((0, 0)) };
}

/// Counts a request of `size` bytes that changes the thread's memory by `more`. While a thread is
/// torn down, its counters may be gone; nobody reads them then.
fn count(size: usize, more: i64) {
    LARGEST.fetch_max(size, Ordering::Relaxed);
    let _ = ASKED.try_with(|count| count.set(count.get() + 1));
    hold(more);
}

fn hold(more: i64) {
    let _ = HELD.try_with(|held| {
        let (now, most) = held.get();
        held.set((now + more, most.max(now + more)));
    });
}

// SAFETY: every method hands its arguments, unchanged, to `System`, which upholds the contract of
// `GlobalAlloc`; counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), layout.size() as i64);
        // SAFETY: the caller's promises are those that `System` wants.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), layout.size() as i64);
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size, size as i64 - layout.size() as i64);
        // SAFETY: as above; `old` came from `System`, since all memory does.
        unsafe { System.realloc(old, layout, size) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        hold(-(layout.size() as i64));
        // SAFETY: as above.
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Serialises the binary's tests, because the largest request is recorded for the whole process. A
/// failed test leaves no state that affects another.
pub fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Allocations and reallocations of this thread so far.
pub fn allocations() -> u64 {
    ASKED.get()
}

/// Runs `work` and returns the peak growth of this thread's memory, in bytes.
pub fn peak_of(work: impl FnOnce()) -> i64 {
    let (before, _) = HELD.get();
    HELD.set((before, before));
    work();
    HELD.get().1 - before
}

/// Forgets the largest request so far.
pub fn forget() {
    LARGEST.store(0, Ordering::Relaxed);
}

/// The largest request of any thread since [`forget`], in bytes.
pub fn largest() -> usize {
    LARGEST.load(Ordering::Relaxed)
}
