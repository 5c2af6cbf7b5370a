//! Rows that are equal to an earlier one.
//!
//! Each thread has a share of all possible keys, by their hash, and finds the first row of each of
//! them. So the result depends neither on the number of threads nor on the hash. The hash differs
//! from run to run, so that no file can be crafted to be slow.

use crate::text::workers;
use foldhash::quality::RandomState;
use phalanx_scene::huge_pages::zeroed;
use std::hash::{BuildHasher, Hash};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Bytes of a row meanwhile: its answer, and its part of a table.
pub(crate) const FIRST_EQUAL_BYTES: u64 = 10;
/// Places of a table beyond half as many again as the rows that it is for: enough, whatever the
/// share of the keys that it gets.
const SPARE: usize = 1 << 10;

/// Number of rows whose places are read at once.
const AHEAD: usize = 32;

/// For each row, the first one with an equal key.
pub(crate) fn first_equal<K: Eq + Hash>(
    rows: usize,
    threads: usize,
    key: impl Fn(usize) -> K + Sync,
) -> Vec<u32> {
    let hasher = RandomState::default();
    let shares = threads.clamp(1, 64);
    let firsts = std::iter::repeat_with(AtomicU32::default);
    let firsts: Vec<AtomicU32> = firsts.take(rows).collect();
    workers::map(threads, (0..shares as u64).collect(), |share| {
        // Each place has the first row of a key, counted from 1; or 0.
        let mut places: Vec<u32> = zeroed(rows / shares * 3 / 2 + SPARE);
        let scaled = |bits: u64, count: usize| ((bits & 0xffff_ffff) * count as u64) >> 32;
        let mut ahead = [(0, 0, 0); AHEAD];
        for first in (0..rows).step_by(AHEAD) {
            // Reads of all places of a block wait for memory at once.
            let mut count = 0;
            for row in first..rows.min(first + AHEAD) {
                let hash = hasher.hash_one(key(row));
                let place = scaled(hash, places.len()) as usize;
                ahead[count] = (row, place, places[place]);
                count += usize::from(scaled(hash >> 32, shares) == share);
            }
            for &(row, mut place, mut taken) in &ahead[..count] {
                if taken == 0 {
                    taken = places[place];
                }
                while taken != 0 && key(taken as usize - 1) != key(row) {
                    place = (place + 1) % places.len();
                    taken = places[place];
                }
                if taken == 0 {
                    taken = row as u32 + 1;
                    places[place] = taken;
                }
                firsts[row].store(taken - 1, Relaxed);
            }
        }
    });
    firsts.into_iter().map(AtomicU32::into_inner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_equal_rows_is_found_by_any_number_of_threads() {
        let rows = 50_017;
        let keys = [1, 7, rows / 3, rows];
        for keys in keys {
            let key = |row: usize| row * 7919 % keys;
            let mut seen = std::collections::HashMap::new();
            let expected = (0..rows).map(|row| *seen.entry(key(row)).or_insert(row as u32));
            let expected: Vec<u32> = expected.collect();
            for threads in [1, 2, 5] {
                assert_eq!(
                    first_equal(rows, threads, key),
                    expected,
                    "{keys} {threads}"
                );
            }
        }
        assert!(first_equal(0, 2, |row| row).is_empty());
    }
}
