//! Rows that are equal to an earlier one.
//!
//! Each thread has a share of all possible keys, by their hash, and finds the first row of each of
//! them. So the result depends neither on the number of threads nor on the hash. The hash differs
//! from run to run, so that no file can be crafted to be slow.

use crate::text::workers;
use foldhash::quality::RandomState;
use phalanx_scene::huge_pages::zeroed;
use std::hash::BuildHasher;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Bytes of a row meanwhile: its answer, and its place in a bucket.
pub(crate) const FIRST_EQUAL_BYTES: u64 = 12;
/// Number of rows of a bucket, which is in a fast cache together with its table.
const BUCKET: usize = 1 << 12;

/// For each row, the first one with an equal key.
pub(crate) fn first_equal(
    rows: usize,
    threads: usize,
    key: impl Fn(usize) -> [u32; 4] + Sync,
) -> Vec<u32> {
    let hasher = RandomState::default();
    let hash = |[x, y, z, w]: [u32; 4]| {
        let pair = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
        hasher.hash_one((pair(x, y), pair(z, w)))
    };
    let scaled = |bits: u64, count: usize| (((bits & 0xffff_ffff) * count as u64) >> 32) as usize;
    let shares = threads.clamp(1, 64);
    let buckets = rows / shares / BUCKET + 1;
    let firsts: Vec<AtomicU32> = (zeroed(rows).into_iter()).map(AtomicU32::new).collect();
    workers::map(threads, (0..shares).collect(), |share| {
        // Where each bucket ends, two places behind its own: then where it is filled next.
        let mut ends = vec![0; buckets + 2];
        // The bucket of a row, if it is of this share, and the rest of its hash.
        let own = |row| {
            let hash = hash(key(row));
            let bucket = scaled(hash >> 32, shares * buckets).wrapping_sub(share * buckets);
            (bucket < buckets).then_some((bucket, hash as u32))
        };
        let counted = (0..rows).filter_map(own);
        counted.for_each(|(bucket, _)| ends[bucket + 2] += 1);
        for k in 2..ends.len() {
            ends[k] += ends[k - 1];
        }
        let mut bucketed: Vec<[u32; 2]> = zeroed(ends[buckets + 1]);
        for row in 0..rows {
            if let Some((bucket, rest)) = own(row) {
                bucketed[ends[bucket + 1]] = [rest, row as u32];
                ends[bucket + 1] += 1;
            }
        }
        let mut places = Vec::new();
        for bucket in ends.windows(2).take(buckets) {
            let bucket = &bucketed[bucket[0]..bucket[1]];
            // Each place has the rest of a hash, and the first row of its key, counted from 1.
            places.clear();
            places.resize(bucket.len() * 3 / 2 + 1, [0, 0u32]);
            for &[rest, row] in bucket {
                let mut place = scaled(rest.into(), places.len());
                let first = loop {
                    match places[place] {
                        [_, 0] => {
                            places[place] = [rest, row + 1];
                            break row;
                        }
                        [other, first] => {
                            let first = first - 1;
                            if other == rest && key(first as usize) == key(row as usize) {
                                break first;
                            }
                        }
                    }
                    place = (place + 1) % places.len();
                };
                firsts[row as usize].store(first, Relaxed);
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
            let key = |row: usize| [7, (row * 7919 % keys) as u32, 0, (row % 3 % keys) as u32];
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
        assert!(first_equal(0, 2, |_| [0; 4]).is_empty());
    }
}
