//! One sample: a set of rays, traced by one engine on a number of threads, and the time in seconds.

use super::answer::Answer;
use super::plan::BenchPlan;
use crate::peers::{BenchEngine, BenchEngineThread};
use phalanx_render::Cores;
use phalanx_report::QueryKind;
use std::hint::black_box;
use std::ops::Range;
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

/// Packets that a thread takes at once: 1024 rays, as in a tile.
pub const CHUNK_PACKETS: usize = 128;

/// Chunks of a set of packets, which threads take one by one.
pub struct Chunks {
    packets: usize,
    /// Packets of a chunk.
    size: usize,
    /// Interval of the selected chunks: one in `stride`.
    stride: usize,
}

impl Chunks {
    /// Chunks of all packets.
    pub fn all(packets: usize) -> Chunks {
        Chunks {
            packets,
            size: CHUNK_PACKETS,
            stride: 1,
        }
    }

    /// Chunks of `size` packets with about `rays` of the rays, evenly spread; all chunks if there
    /// are no more.
    ///
    /// One in `stride` chunks is taken, and `stride` is odd. Rows of tiles are powers of two long,
    /// and an even stride would stay in the same columns of a picture.
    pub fn some(packets: usize, size: usize, rays: usize) -> Chunks {
        let stride = packets.div_ceil((rays / 8).max(1)) | 1;
        let most = packets.div_ceil(size).max(1);
        Chunks {
            packets,
            size,
            stride: stride.min(most),
        }
    }

    /// Number of chunks.
    pub fn count(&self) -> usize {
        self.packets.div_ceil(self.size).div_ceil(self.stride)
    }

    /// Packets of the k-th chunk.
    pub fn range(&self, k: usize) -> Range<usize> {
        let first = k * self.stride * self.size;
        first..self.packets.min(first + self.size)
    }

    /// Indices of the rays in the chunks, of a set of `rays` rays.
    pub fn ray_numbers(&self, rays: usize) -> impl Iterator<Item = usize> {
        let rays_in = move |r: Range<usize>| r.start * 8..rays.min(r.end * 8);
        (0..self.count()).flat_map(move |k| rays_in(self.range(k)))
    }

    /// Number of rays in the chunks, of a set of `rays` rays.
    pub fn rays(&self, rays: usize) -> usize {
        self.ray_numbers(rays).count()
    }
}

/// Measured times of a sample, which is one pass or more.
#[derive(Default)]
pub struct Timing {
    /// Seconds from the first thread's start to the last one's end.
    pub wall: f64,
    /// Time of each piece of a pass when it was fastest, as its share of a pass on all threads.
    /// Their sum is the time of an undisturbed pass in seconds.
    pub fastest: Vec<f64>,
}

impl Timing {
    /// Adds a frame: its tiles are the pieces, and the remaining time is one more piece.
    pub fn add_frame(&mut self, wall: f64, tiles: &[f64], threads: usize) {
        self.wall += wall;
        if is_oversubscribed(threads) {
            return self.keep_fastest(&[wall]);
        }
        let mut pieces: Vec<f64> = tiles
            .iter()
            .map(|seconds| seconds / threads as f64)
            .collect();
        let rest = wall - pieces.iter().sum::<f64>();
        pieces.push(rest.max(0.0));
        self.keep_fastest(&pieces);
    }

    fn keep_fastest(&mut self, pieces: &[f64]) {
        self.fastest.resize(pieces.len(), f64::INFINITY);
        for (fastest, seconds) in self.fastest.iter_mut().zip(pieces) {
            *fastest = fastest.min(*seconds);
        }
    }

    /// Seconds of an undisturbed pass.
    pub fn pass(&self) -> f64 {
        self.fastest.iter().sum()
    }
}

/// Returns true if the given number of threads must share cores. A piece of work between two thread
/// switches does not show the time of the other threads, so then only whole passes count.
fn is_oversubscribed(threads: usize) -> bool {
    threads > BenchPlan::all_threads()
}

/// Times `passes` passes over the chunks, which are the pieces. Threads, and the engine's state for
/// each, are ready before the clock starts.
pub fn sample(
    engine: &dyn BenchEngine,
    query: QueryKind,
    chunks: &Chunks,
    passes: usize,
    threads: usize,
    cores: &Cores,
) -> Timing {
    let (next, barrier) = (AtomicUsize::new(0), Barrier::new(threads));
    let work = |worker: usize| {
        cores.bind(worker);
        let mut engine_thread = engine.thread();
        let mut scratch = Answer::with_capacity(query, chunks.size);
        let mut fastest = vec![f64::INFINITY; chunks.count()];
        barrier.wait();
        let start = Instant::now();
        let mut now = start;
        // Passes follow each other without a pause, so that threads wait for each other only once.
        loop {
            let k = next.fetch_add(1, Relaxed);
            if k >= passes * chunks.count() {
                break;
            }
            let k = k % chunks.count();
            trace_packets(&mut *engine_thread, chunks.range(k), &mut scratch);
            let before = std::mem::replace(&mut now, Instant::now());
            fastest[k] = fastest[k].min((now - before).as_secs_f64());
        }
        let share = |seconds: f64| seconds / threads as f64;
        TimedSpan {
            start,
            end: now,
            shares: fastest.into_iter().map(share).collect(),
        }
    };
    let spans = on_threads(threads, work);
    let start = spans.iter().map(|span| span.start).min();
    let end = spans.iter().map(|span| span.end).max();
    let wall = match (start, end) {
        (Some(start), Some(end)) => (end - start).as_secs_f64(),
        _ => 0.0,
    };
    let mut timing = Timing {
        wall,
        ..Timing::default()
    };
    if is_oversubscribed(threads) {
        timing.keep_fastest(&[wall / passes as f64]);
    } else {
        for span in &spans {
            timing.keep_fastest(&span.shares);
        }
    }
    timing
}

/// The results of `work` on some threads at once, each of which receives its number.
pub fn on_threads<T: Send>(threads: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let work = &work;
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|k| scope.spawn(move || work(k))).collect();
        let results = workers.into_iter().map(|worker| worker.join());
        results
            .map(|result| result.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

/// A thread's part of a sample.
struct TimedSpan {
    start: Instant,
    end: Instant,
    /// Seconds of each chunk when it was fastest; infinite if other threads took it.
    shares: Vec<f64>,
}

fn trace_packets(
    engine_thread: &mut dyn BenchEngineThread,
    packets: Range<usize>,
    scratch: &mut Answer,
) {
    let count = packets.len();
    match scratch {
        Answer::Closest(hits) => {
            engine_thread.closest(packets, &mut hits[..count]);
            black_box(&hits[..count]);
        }
        Answer::Occluded(blocked) => {
            engine_thread.occluded(packets, &mut blocked[..count]);
            black_box(&blocked[..count]);
        }
    }
}

/// The results of an engine for the rays of some chunks, without a clock; other rays count as
/// misses.
pub fn answer(
    engine: &dyn BenchEngine,
    query: QueryKind,
    chunks: &Chunks,
    threads: usize,
) -> Answer {
    let parts = on_threads(threads, |worker| {
        let mut engine_thread = engine.thread();
        let trace = |k: usize| {
            let packets = chunks.range(k);
            let mut part = Answer::with_capacity(query, packets.len());
            trace_packets(&mut *engine_thread, packets.clone(), &mut part);
            (packets, part)
        };
        let share = (worker..chunks.count()).step_by(threads);
        share.map(trace).collect::<Vec<_>>()
    });
    let mut answer = Answer::with_capacity(query, chunks.packets);
    for (packets, part) in parts.into_iter().flatten() {
        match (&mut answer, part) {
            (Answer::Closest(all), Answer::Closest(hits)) => all[packets].copy_from_slice(&hits),
            (Answer::Occluded(all), Answer::Occluded(blocked)) => {
                all[packets].copy_from_slice(&blocked);
            }
            // Not possible: the query is the same.
            _ => {}
        }
    }
    answer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_a_set_or_an_even_share_of_it() {
        let all = Chunks::some(1000, CHUNK_PACKETS, 8000);
        let covered: Vec<_> = (0..all.count()).flat_map(|k| all.range(k)).collect();
        assert_eq!(covered, (0..1000).collect::<Vec<_>>());
        assert_eq!(all.rays(7997), 7997);
        // A quarter would be every fourth chunk; the next odd number is taken.
        let some = Chunks::some(1000, 16, 2000);
        assert_eq!(some.count(), 13);
        assert_eq!(some.range(1), 80..96);
        // Even if no rays are requested, there is a chunk; an empty set has none.
        assert_eq!(Chunks::some(1000, CHUNK_PACKETS, 0).count(), 1);
        assert_eq!(Chunks::some(0, CHUNK_PACKETS, 8).count(), 0);
    }
}
