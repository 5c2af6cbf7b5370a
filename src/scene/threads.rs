//! Numbers of threads, the threads of this process, and work on long columns.

use crate::fork_safe_once::ForkSafeOnce;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

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

/// Results of `work` on blocks of `len` rows, in order. If there are several blocks, they are
/// shared by the threads of a pool.
pub(crate) fn map_blocks<T: Sync, R: Send>(
    rows: &[T],
    len: usize,
    work: impl Fn(&[T]) -> R + Sync + Send,
) -> Vec<R> {
    if rows.len() <= len {
        rows.chunks(len).map(work).collect()
    } else {
        on_pool(|| rows.par_chunks(len).map(work).collect())
    }
}

/// As `map_blocks`, for rows that change. A single block is the caller's work: passing it to a
/// pool takes longer than an update of a small scene.
pub fn map_blocks_mut<T: Send, R: Send>(
    rows: &mut [T],
    len: usize,
    work: impl Fn(&mut [T]) -> R + Sync + Send,
) -> Vec<R> {
    if rows.len() <= len {
        rows.chunks_mut(len).map(work).collect()
    } else {
        on_pool(|| rows.par_chunks_mut(len).map(work).collect())
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
    fn the_first_fault_is_found_in_any_block() {
        for row in [0, BLOCK_ROWS - 1, BLOCK_ROWS, 3 * BLOCK_ROWS + 7] {
            let mut column = vec![1.0f32; 4 * BLOCK_ROWS];
            (column[row], column[4 * BLOCK_ROWS - 1]) = (f32::NAN, f32::NAN);
            let fault = RowCheck::Finite.first_fault(bytemuck::cast_slice(&column), 4);
            assert_eq!(fault, Some(row));
        }
        assert!(map_blocks(&[0u8; 0], 1, |block| block.len()).is_empty());
    }
}
