//! Peak rates of the machine: the roofline for comparison.
//!
//! All threads do the same at the same time, each with memory of its own. The best of many short
//! attempts counts: a peak is the undisturbed rate, and on a busy machine only short intervals are
//! undisturbed.

use super::timer::on_threads;
use phalanx_report::{Cache, MachineLimits, ThreadLimits};
use phalanx_trace::simd::{F32x8, F32x16, Lanes};
use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::Barrier;
use std::time::{Duration, Instant};

/// Measuring time of one attempt.
const ATTEMPT_TIME: Duration = Duration::from_millis(4);

/// Number of attempts for each value.
const ATTEMPTS: usize = 30;

/// Number of consecutive multiply-add steps between readings of the clock.
const STEPS: usize = 4096;

/// Bytes read between readings of the clock: little compared with any measured time, much compared
/// with the cost of the clock.
const STRETCH_BYTES: usize = 1 << 20;

/// Unit of reading.
type ReadBlock = [F32x16; 8];
const BLOCK_BYTES: usize = size_of::<ReadBlock>();

/// Cache sizes where the real ones are not known.
const DEFAULT_CACHES: [u64; 3] = [32 << 10, 512 << 10, 16 << 20];

/// Maximum amount of memory that is read, regardless of the caches' size.
const MAX_READ_BYTES: u64 = 512 << 20;

/// The limits of one thread and of all threads if there are several; takes about a second for each.
pub fn measure_limits(threads: usize, caches: &[Cache]) -> MachineLimits {
    let mut counts = vec![1, threads];
    counts.dedup();
    let measured = counts.into_iter().map(|count| measure(count, caches));
    MachineLimits {
        threads: measured.collect(),
    }
}

/// Peak rates of the given number of threads, for the machine's caches; takes about a second.
pub fn measure(threads: usize, caches: &[Cache]) -> ThreadLimits {
    let threads = threads.max(1);
    let working_sets = working_sets(threads, caches).into_iter();
    let bandwidth = working_sets.map(|(name, bytes)| (name.to_owned(), reading(threads, bytes)));
    ThreadLimits {
        threads: threads as u32,
        gflops: arithmetic(threads),
        bandwidth: bandwidth.collect::<BTreeMap<_, _>>(),
    }
}

/// Bytes that each thread reads to stay within a cache, or to miss all of them.
fn working_sets(threads: usize, caches: &[Cache]) -> [(&'static str, usize); 4] {
    let of_level = |level: u8| {
        let mut data = caches
            .iter()
            .filter(|c| c.level == level && c.kind != "instruction");
        // Threads that share a cache and measure together also share its size.
        let share = |c: &Cache| c.bytes / u64::from(c.shared_by).clamp(1, threads as u64);
        let default = DEFAULT_CACHES[usize::from(level) - 1];
        data.find_map(|c| (c.bytes > 0).then(|| share(c)))
            .unwrap_or(default)
    };
    let [l1, l2, l3] = [1, 2, 3].map(of_level);
    // Half of a cache leaves room for its other content. The third level is often shared with other
    // programs. Four times the second level is certainly more than that level holds, but little of
    // the third.
    let within_l3 = (4 * l2).min(l3 / 2);
    let all = caches.iter().map(|c| c.bytes).max();
    let all = all.unwrap_or(DEFAULT_CACHES[2]);
    let beyond = (2 * all).clamp(128 << 20, MAX_READ_BYTES) / threads as u64;
    [
        ("l1", l1 / 2),
        ("l2", l2 / 2),
        ("l3", within_l3),
        ("memory", beyond),
    ]
    .map(|(name, bytes)| (name, bytes as usize))
}

/// Rate of f32 additions and multiplications, in 10⁹ per second: the best of the lane counts. The
/// number of independent chains is enough to hide the latency, and fits registers of sixteen bytes.
fn arithmetic(threads: usize) -> f64 {
    let shapes = [
        |threads| chains::<F32x8, 6>(threads),
        |threads| chains::<F32x8, 12>(threads),
        |threads| chains::<F32x16, 12>(threads),
    ];
    best(shapes.into_iter().map(|shape| shape(threads)))
}

fn chains<L: Lanes, const CHAINS: usize>(threads: usize) -> f64 {
    let per_turn = (STEPS * CHAINS * 2 * 8 * L::PACKETS) as f64;
    let rate = run_together(threads, || {
        let (factor, term) = (black_box(L::splat(0.999_9)), black_box(L::splat(1e-4)));
        let mut values = [(); CHAINS].map(|()| black_box(L::ONE));
        move || {
            values = black_box(steps(values, factor, term));
            per_turn
        }
    });
    rate / 1e9
}

/// Rounds twice, like the kernels: nothing here is fused. This is a loop instead of `map`, which
/// for arrays is a call with memory on either side.
#[inline(never)]
fn steps<L: Lanes, const CHAINS: usize>(
    mut values: [L; CHAINS],
    factor: L,
    term: L,
) -> [L; CHAINS] {
    for _ in 0..STEPS {
        for value in &mut values {
            *value = *value * factor + term;
        }
    }
    values
}

/// Rate in GB/s of reading the given number of bytes repeatedly on each thread.
fn reading(threads: usize, bytes: usize) -> f64 {
    let count = (bytes / BLOCK_BYTES).max(1);
    let passes = (STRETCH_BYTES / (count * BLOCK_BYTES)).max(1);
    let rate = run_together(threads, || {
        // Written here by the reading thread, so that the pages are mapped and local to it.
        let memory: Vec<ReadBlock> = vec![black_box([F32x16::ONE; 8]); count];
        let (mut sums, mut at) = ([F32x16::ZERO; 8], 0);
        move || {
            let mut read = 0;
            for _ in 0..passes {
                // A large memory is read in stretches.
                let end = count.min(at + STRETCH_BYTES / BLOCK_BYTES);
                sums = black_box(add(sums, black_box(&memory[at..end])));
                read += (end - at) * BLOCK_BYTES;
                at = if end == count { 0 } else { end };
            }
            read as f64
        }
    });
    rate / 1e9
}

/// Sums a block into eight sums, so that additions do not wait for each other.
#[inline(never)]
fn add(mut sums: ReadBlock, blocks: &[ReadBlock]) -> ReadBlock {
    for block in blocks {
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum = *sum + block[k];
        }
    }
    sums
}

/// One thread's part of an attempt.
struct ThreadShare {
    start: Instant,
    end: Instant,
    done: f64,
}

/// The best rate of all attempts. `worker` prepares and returns one turn, which returns its amount
/// of work.
fn run_together<T: FnMut() -> f64>(threads: usize, worker: impl Fn() -> T + Sync) -> f64 {
    let barrier = Barrier::new(threads);
    let run = |_| {
        let mut turn = worker();
        // Warm-up: pages, caches, the clock's frequency.
        turn();
        let attempt = |_| {
            barrier.wait();
            let (start, mut done) = (Instant::now(), 0.0);
            while start.elapsed() < ATTEMPT_TIME {
                done += turn();
            }
            let end = Instant::now();
            ThreadShare { start, end, done }
        };
        (0..ATTEMPTS).map(attempt).collect::<Vec<ThreadShare>>()
    };
    let parts: Vec<Vec<ThreadShare>> = on_threads(threads, run);
    let of_attempt = |k: usize| {
        let parts = || parts.iter().map(|of_thread| &of_thread[k]);
        let (start, end) = (parts().map(|p| p.start).min(), parts().map(|p| p.end).max());
        // From the first thread's start to the last one's end: threads that do not run at the same
        // time do not share anything.
        let span = start
            .zip(end)
            .map_or(f64::INFINITY, |(s, e)| (e - s).as_secs_f64());
        parts().map(|p| p.done).sum::<f64>() / span
    };
    best((0..ATTEMPTS).map(of_attempt))
}

fn best(rates: impl Iterator<Item = f64>) -> f64 {
    rates.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::this_machine;

    #[test]
    fn memory_to_read_is_within_the_cache_it_is_for() {
        let cache = |level, kind: &str, kib: u64, shared_by| Cache {
            level,
            kind: kind.into(),
            bytes: kib << 10,
            shared_by,
        };
        let caches = [
            cache(1, "instruction", 64, 1),
            cache(1, "data", 48, 1),
            cache(2, "unified", 2048, 1),
            cache(3, "unified", 32 << 10, 2),
        ];
        let kib = |threads| working_sets(threads, &caches).map(|(_, bytes)| bytes >> 10);
        assert_eq!(kib(1), [24, 1024, 8 << 10, 128 << 10]);
        assert_eq!(kib(2), [24, 1024, 8 << 10, 64 << 10]);
        // Unknown caches, and caches of extreme size.
        assert_eq!(working_sets(1, &[])[0], ("l1", 16 << 10));
        let huge = [cache(3, "unified", 4 << 20, 64)];
        assert_eq!(working_sets(2, &huge)[3].1 as u64, MAX_READ_BYTES / 2);
    }

    /// Orders of magnitude only: other tests run at the same time.
    #[test]
    fn limits_are_plausible() {
        let start = Instant::now();
        let limits = measure_limits(2, &this_machine().caches);
        let seconds = start.elapsed().as_secs_f64();
        println!("{limits:#?} in {seconds} s");
        let [one, two] = &limits.threads[..] else {
            panic!("{limits:?}");
        };
        for limits in [one, two] {
            assert!((1.0..10_000.0).contains(&limits.gflops), "{limits:?}");
            for (level, &rate) in &limits.bandwidth {
                assert!((0.5..20_000.0).contains(&rate), "{level}: {limits:?}");
            }
        }
        assert!(one.bandwidth["l1"] > one.bandwidth["memory"], "{limits:?}");
    }
}
