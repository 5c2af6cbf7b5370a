//! Numbers of threads, the threads of this process, and work on long columns.

use crate::fork_safe_once::ForkSafeOnce;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// Number of threads to use: the one asked for, or one per CPU available to this process for 0.
pub fn thread_count(requested: usize) -> usize {
    match requested {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        some => some,
    }
}

/// Number of threads of this process's pool; 0 for one per CPU.
static POOL_THREADS: AtomicUsize = AtomicUsize::new(0);

/// Sets the number of threads that [`on_pool`] starts at its first call.
pub fn set_pool_threads(threads: usize) {
    POOL_THREADS.store(threads, Relaxed);
}

/// Runs work whose parallel iterators share the threads of a pool: of the caller's, if it is a
/// worker of one, else of the one that this process starts at the first call. Every parallel
/// iterator of the library runs within. Rayon's global pool belongs to the process that started it:
/// after a fork, it has no threads in the child, which would wait for them for ever. The child's
/// copy of its parent's pool is left alone: ending it would wait for those threads, too.
pub fn on_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    static POOL: ForkSafeOnce<Option<ThreadPool>> = ForkSafeOnce::new();
    if rayon::current_thread_index().is_some() {
        return work();
    }
    let builder = || ThreadPoolBuilder::new().num_threads(POOL_THREADS.load(Relaxed));
    match POOL.get_own_or_init(|| builder().build().ok()) {
        Some(pool) => pool.install(work),
        // The system has no more threads, or none at all: the caller becomes the worker of a pool
        // of one, for good.
        None => {
            let pool = builder().num_threads(1).use_current_thread().build();
            std::mem::forget(pool);
            work()
        }
    }
}

/// Number of rows of a column that a thread looks at in one go.
pub(crate) const BLOCK_ROWS: usize = 1 << 14;

/// Results of `work` on parts, in order. Several parts are shared by the threads of a pool. A
/// single one is the caller's work: passing it to a pool takes longer than an update of a small
/// scene.
pub fn map_on_pool<P: Send, R: Send>(
    parts: impl IntoIterator<Item = P>,
    work: impl Fn(P) -> R + Sync,
) -> Vec<R> {
    let slots = parts.into_iter().map(|part| Mutex::new((Some(part), None)));
    let slots: Vec<_> = slots.collect();
    for_each_on_pool(slots.len(), &|index| {
        let slot = || slots[index].lock().unwrap_or_else(PoisonError::into_inner);
        let part = slot().0.take();
        let result = part.map(&work);
        slot().1 = result;
    });
    let slots = slots.into_iter().map(Mutex::into_inner);
    let results = slots.map(|slot| slot.unwrap_or_else(PoisonError::into_inner).1);
    results.flatten().collect()
}

/// Not generic, so that rayon's sharing of work is compiled once.
fn for_each_on_pool(count: usize, work: &(dyn Fn(usize) + Sync)) {
    if count <= 1 {
        (0..count).for_each(work);
    } else {
        on_pool(|| (0..count).into_par_iter().for_each(work));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prims::RowCheck;

    #[test]
    fn work_runs_on_the_callers_pool_or_on_that_of_this_process() {
        let threads = || (rayon::current_num_threads(), rayon::current_thread_index());
        let builder = ThreadPoolBuilder::new().num_threads(3);
        let inside = builder.build().unwrap();
        assert!(inside.install(|| on_pool(threads) == threads()));
        assert_eq!(inside.install(|| on_pool(threads).0), 3);
        let (count, index) = on_pool(|| on_pool(threads));
        assert!(index.is_some_and(|index| index < count));
    }

    #[test]
    fn results_are_in_the_order_of_their_parts() {
        for count in [0, 1, 2, 1000] {
            let results = map_on_pool(0..count, |part| 3 * part);
            assert!(results.into_iter().eq((0..count).map(|part| 3 * part)));
        }
    }

    #[test]
    fn the_first_fault_is_found_in_any_block() {
        for row in [0, BLOCK_ROWS - 1, BLOCK_ROWS, 3 * BLOCK_ROWS + 7] {
            let mut column = vec![1.0f32; 4 * BLOCK_ROWS];
            (column[row], column[4 * BLOCK_ROWS - 1]) = (f32::NAN, f32::NAN);
            let fault = RowCheck::Finite.first_fault(bytemuck::cast_slice(&column), 4);
            assert_eq!(fault, Some(row));
        }
    }
}
