//! Rows on huge pages, if the system supports them. Incoherent rays read rows all over a tree, and
//! each page of four kibibytes needs a separate TLB entry.

use bytemuck::Zeroable;
use rayon::prelude::*;

/// Minimum size for which huge pages pay off: two huge pages of x86-64.
const MIN_BYTES: usize = 4 << 20;

/// Collects rows into a new vector, on huge pages if it is large.
pub(super) fn collect_on_huge_pages<T: Send>(
    rows: impl IndexedParallelIterator<Item = T>,
) -> Vec<T> {
    let mut all = Vec::with_capacity(rows.len());
    if rows.len() * size_of::<T>() >= MIN_BYTES {
        advise_huge_pages(all.spare_capacity_mut());
    }
    // The rows fit into the reserved memory: the vector does not move.
    rows.collect_into_vec(&mut all);
    all
}

/// Zeroed rows, on huge pages if they are many. The system allocates their memory on the first
/// write, on the writing thread.
pub(super) fn zeroed_on_huge_pages<T: Zeroable>(len: usize) -> Vec<T> {
    let mut all = bytemuck::zeroed_vec(len);
    if size_of_val(&all[..]) >= MIN_BYTES {
        advise_huge_pages(&mut all[..]);
    }
    all
}

/// Consecutive slices of the given lengths, for threads to fill.
pub(super) fn consecutive<T>(
    mut rows: &mut [T],
    lens: impl IntoIterator<Item = usize>,
) -> Vec<&mut [T]> {
    let mut slices = Vec::new();
    for len in lens {
        let (own, rest) = std::mem::take(&mut rows).split_at_mut(len);
        slices.push(own);
        rows = rest;
    }
    slices
}

/// Moves rows onto huge pages, if they are many; two copies exist briefly. The contents do not
/// change, and whether the system complied is unknown.
pub(super) fn move_to_huge_pages<T: Copy>(rows: &mut Vec<T>) {
    if size_of_val(&rows[..]) < MIN_BYTES {
        return;
    }
    let mut moved = Vec::with_capacity(rows.len());
    advise_huge_pages(moved.spare_capacity_mut());
    moved.extend_from_slice(rows);
    *rows = moved;
}

/// Advises the system before memory is first written to: pages that exist already stay as they
/// are.
#[cfg(target_os = "linux")]
fn advise_huge_pages<T>(room: &mut [T]) {
    const PAGE: usize = 4096;
    let start = room.as_mut_ptr().addr().next_multiple_of(PAGE);
    let end = (room.as_mut_ptr().addr() + size_of_val(room)) / PAGE * PAGE;
    if start < end {
        // SAFETY: the whole pages of this range are memory that is lent to this function, and the
        // advice changes nothing that can be read.
        unsafe { libc::madvise(start as *mut libc::c_void, end - start, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise_huge_pages<T>(_: &mut [T]) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stay_what_they_are() {
        for count in [
            0,
            1,
            MIN_BYTES / 8 - 1,
            MIN_BYTES / 8,
            MIN_BYTES / 8 * 3 + 77,
        ] {
            let rows: Vec<u64> = (0..count as u64)
                .map(|k| k.wrapping_mul(0x9e37_79b9))
                .collect();
            let mut moved = rows.clone();
            move_to_huge_pages(&mut moved);
            assert_eq!(moved, rows);
            let new = collect_on_huge_pages(rows.par_iter().map(|x| x + 1));
            assert!(new.iter().zip(&rows).all(|(new, x)| *new == x + 1));
            assert_eq!(new.len(), rows.len());
        }
    }
}
