//! Numbers of threads, and work on long columns.

use rayon::prelude::*;

/// Number of threads to use: the one asked for, or one per CPU available to this process for 0.
pub fn thread_count(asked: usize) -> usize {
    match asked {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        some => some,
    }
}

/// Number of rows of a column that a thread looks at in one go.
pub(crate) const BLOCK_ROWS: usize = 1 << 14;

/// Results of `work` on blocks of `len` rows, in order. If there are several blocks, they are
/// shared by the threads of rayon's pool.
pub(crate) fn map_blocks<T: Sync, R: Send>(
    rows: &[T],
    len: usize,
    work: impl Fn(&[T]) -> R + Sync + Send,
) -> Vec<R> {
    match rows.len() <= len {
        true => rows.chunks(len).map(work).collect(),
        false => rows.par_chunks(len).map(work).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prims::RowCheck;

    #[test]
    fn the_first_fault_is_found_in_any_block() {
        for row in [0, BLOCK_ROWS - 1, BLOCK_ROWS, 3 * BLOCK_ROWS + 7] {
            let mut column = vec![1.0f32; 4 * BLOCK_ROWS];
            (column[row], column[4 * BLOCK_ROWS - 1]) = (f32::NAN, f32::NAN);
            let found = RowCheck::Finite.first_fault(bytemuck::cast_slice(&column), 4);
            assert_eq!(found, Some(row));
        }
        assert!(map_blocks(&[0u8; 0], 1, |block| block.len()).is_empty());
    }
}
