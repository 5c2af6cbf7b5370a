//! Rows on huge pages, if the system supports them. Pages of four kibibytes cost half of the time
//! in which columns are filled for the first time. Incoherent rays read rows all over a tree, and
//! each page needs a separate TLB entry.

use crate::threads::{map_on_pool, on_pool};
use bytemuck::Zeroable;
use rayon::prelude::*;
use std::mem::MaybeUninit;

/// Minimum size for which huge pages pay off: two huge pages of x86-64.
const MIN_BYTES: usize = 4 << 20;

/// An empty vector with room for rows. Its memory is first written to, and so made by the system,
/// on the thread that writes a row: zeroed memory would come from one thread where rows are aligned
/// to more than 16 bytes.
pub fn room<T>(len: usize) -> Vec<T> {
    let mut rows = Vec::with_capacity(len);
    advise_huge_pages(rows.spare_capacity_mut());
    rows
}

/// Room for rows, and for a sixteenth more, which costs nothing until it is written to: trees get
/// parts later, and moving a large one takes longer than a build of what comes.
fn room_to_grow<T>(len: usize) -> Vec<T> {
    room(len + len / 16)
}

/// Rows of zeros. Their memory comes zeroed from the system, for the thread that first touches it.
pub fn zeroed<T: Zeroable + Clone>(len: usize) -> Vec<T> {
    let mut rows = vec![T::zeroed(); len];
    advise_huge_pages(&mut rows);
    rows
}

/// Collects rows into a new vector, on huge pages if it is large.
pub fn collect_on_huge_pages<T: Send>(rows: impl IndexedParallelIterator<Item = T>) -> Vec<T> {
    let mut all = room_to_grow(rows.len());
    // The rows fit into the reserved memory: the vector does not move.
    on_pool(|| rows.collect_into_vec(&mut all));
    all
}

/// Rows of consecutive parts, on huge pages if they are many. `write` adds the rows of the k-th
/// part, of which there are `lens[k]`, and its results are returned in order. Threads write
/// different parts at the same time.
///
/// # Panics
/// If a part gets fewer or more rows than its length.
pub fn write_parts<T: Copy + Send, R: Send>(
    lens: &[usize],
    write: impl Fn(usize, &mut PartWriter<T>) -> R + Sync,
) -> (Vec<T>, Vec<R>) {
    let len = lens.iter().sum();
    let mut all = room_to_grow(len);
    let places = consecutive(all.spare_capacity_mut(), lens.iter().copied());
    let write_part = |(k, rows): (usize, &mut [MaybeUninit<T>])| {
        let mut part = PartWriter { rows, written: 0 };
        let result = write(k, &mut part);
        assert_eq!(part.written, part.rows.len(), "rows of part {k}");
        result
    };
    let results = map_on_pool(places.into_iter().enumerate(), write_part);
    // SAFETY: the parts are the first `len` rows, and each has been written to its end.
    unsafe { all.set_len(len) };
    (all, results)
}

/// A part of a vector, whose rows are written in order.
pub struct PartWriter<'a, T> {
    rows: &'a mut [MaybeUninit<T>],
    written: usize,
}

impl<T> PartWriter<'_, T> {
    /// Number of rows of the whole part.
    pub fn capacity(&self) -> usize {
        self.rows.len()
    }

    /// Writes the next row.
    #[inline(always)]
    pub fn push(&mut self, row: T) {
        self.rows[self.written].write(row);
        self.written += 1;
    }
}

/// Consecutive slices of the given lengths, for threads to fill.
pub fn consecutive<T>(mut rows: &mut [T], lens: impl IntoIterator<Item = usize>) -> Vec<&mut [T]> {
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
pub fn move_to_huge_pages<T: Copy>(rows: &mut Vec<T>) {
    if size_of_val(&rows[..]) < MIN_BYTES {
        return;
    }
    let mut moved = room_to_grow(rows.len());
    moved.extend_from_slice(rows);
    *rows = moved;
}

/// Writes rows from row `first` on, in place of those that are there, and behind the last. If the
/// vector has to move, it gets room for as many again, on huge pages if they are many.
pub fn write_rows<T: Copy>(all: &mut Vec<T>, first: usize, rows: &[T]) {
    let within = rows.len().min(all.len() - first);
    all[first..first + within].copy_from_slice(&rows[..within]);
    let end = first + rows.len();
    if end > all.capacity() {
        let mut moved = room(2 * end);
        moved.extend_from_slice(all);
        *all = moved;
    }
    all.extend_from_slice(&rows[within..]);
}

/// Advises the system before memory is first written to: pages that exist already stay as they
/// are.
#[cfg(target_os = "linux")]
fn advise_huge_pages<T>(rows: &mut [T]) {
    const PAGE: usize = 4096;
    if size_of_val(rows) < MIN_BYTES {
        return;
    }
    let start = rows.as_mut_ptr().addr().next_multiple_of(PAGE);
    let end = (rows.as_mut_ptr().addr() + size_of_val(rows)) / PAGE * PAGE;
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
            let lens = [count / 3, 0, count - count / 3];
            let (parts, ends) = write_parts(&lens, |k, part| {
                let start: usize = lens[..k].iter().sum();
                let own = &rows[start..start + part.capacity()];
                own.iter().for_each(|&row| part.push(row));
                start + own.len()
            });
            assert_eq!(parts, rows);
            assert_eq!(ends, [count / 3, count / 3, count]);
        }
    }

    #[test]
    #[should_panic(expected = "rows of part 1")]
    fn a_part_is_written_to_its_end() {
        write_parts(&[2, 2], |k, part| (k..2).for_each(|row| part.push(row)));
    }
}
