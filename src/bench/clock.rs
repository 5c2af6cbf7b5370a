//! One sample: a set of rays traced by one contender, on so many threads, and the seconds that took.

use super::answer::Answer;
use super::kind::Question;
use crate::packet::HitPacket;
use crate::peers::{Contender, Runner};
use crate::render::Cores;
use std::hint::black_box;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Barrier, Mutex};
use std::time::Instant;

/// Packets that a thread takes at once: 1024 rays, a tile's worth.
pub const CHUNK: usize = 128;

/// What a thread takes next, of the chunks of a set.
pub struct Chunks {
    packets: usize,
    /// Every so many chunks are taken.
    stride: usize,
}

impl Chunks {
    /// All chunks of so many packets.
    pub fn all(packets: usize) -> Chunks {
        Chunks { packets, stride: 1 }
    }

    /// About `share` of the chunks of so many packets, evenly spread.
    pub fn some(packets: usize, share: f64) -> Chunks {
        let most = packets.div_ceil(CHUNK).max(1);
        let stride = ((1.0 / share).ceil().max(1.0) as usize).min(most);
        Chunks { packets, stride }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.packets.div_ceil(CHUNK).div_ceil(self.stride)
    }

    /// Packets of the k-th.
    pub fn range(&self, k: usize) -> Range<usize> {
        let first = k * self.stride * CHUNK;
        first..self.packets.min(first + CHUNK)
    }

    /// Numbers of the rays in them, of a set of so many.
    pub fn ray_numbers(&self, rays: usize) -> impl Iterator<Item = usize> {
        let of = move |r: Range<usize>| r.start * 8..rays.min(r.end * 8);
        (0..self.count()).flat_map(move |k| of(self.range(k)))
    }

    /// Rays in them, of a set of so many.
    pub fn rays(&self, rays: usize) -> usize {
        self.ray_numbers(rays).count()
    }
}

/// Seconds from the first thread's start to the last one's end of `passes` passes over the chunks. Threads, and what the
/// contender needs on each, are there before the clock starts.
pub fn sample(
    contender: &dyn Contender,
    question: Question,
    chunks: &Chunks,
    passes: usize,
    threads: usize,
    cores: &Cores,
) -> f64 {
    let (next, barrier) = (AtomicUsize::new(0), Barrier::new(threads));
    let work = |worker: usize| {
        cores.bind(worker);
        let mut runner = contender.runner();
        let mut scratch = Answer::room(question, CHUNK);
        barrier.wait();
        let start = Instant::now();
        // Passes follow each other without a pause, so that threads wait for each other only once.
        loop {
            let k = next.fetch_add(1, Relaxed);
            if k >= passes * chunks.count() {
                break;
            }
            let packets = chunks.range(k % chunks.count());
            ask(&mut *runner, packets, &mut scratch);
        }
        (start, Instant::now())
    };
    let work = &work;
    let spans: Vec<(Instant, Instant)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|k| scope.spawn(move || work(k))).collect();
        workers
            .into_iter()
            .map(|worker| {
                worker
                    .join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            })
            .collect()
    });
    let start = spans.iter().map(|span| span.0).min();
    let end = spans.iter().map(|span| span.1).max();
    match (start, end) {
        (Some(start), Some(end)) => (end - start).as_secs_f64(),
        _ => 0.0,
    }
}

fn ask(runner: &mut dyn Runner, packets: Range<usize>, scratch: &mut Answer) {
    let count = packets.len();
    match scratch {
        Answer::Closest(hits) => {
            runner.closest(packets, &mut hits[..count]);
            black_box(&hits[..count]);
        }
        Answer::Occluded(blocked) => {
            runner.occluded(packets, &mut blocked[..count]);
            black_box(&blocked[..count]);
        }
    }
}

/// The answer of a contender to the rays of some chunks, without a clock; to others it says that nothing is hit.
pub fn answer(
    contender: &dyn Contender,
    question: Question,
    chunks: &Chunks,
    threads: usize,
) -> Answer {
    let mut answer = Answer::room(question, chunks.packets);
    let pieces: Vec<Piece> = match &mut answer {
        Answer::Closest(hits) => hits.chunks_mut(CHUNK).map(Piece::Closest).collect(),
        Answer::Occluded(blocked) => blocked.chunks_mut(CHUNK).map(Piece::Occluded).collect(),
    };
    let pieces = pieces.into_iter().step_by(chunks.stride);
    let pieces = Mutex::new(pieces.enumerate());
    let work = || {
        let mut runner = contender.runner();
        while let Some((k, piece)) = take(&pieces) {
            let packets = chunks.range(k);
            match piece {
                Piece::Closest(hits) => runner.closest(packets, hits),
                Piece::Occluded(blocked) => runner.occluded(packets, blocked),
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    drop(pieces);
    answer
}

enum Piece<'a> {
    Closest(&'a mut [HitPacket]),
    Occluded(&'a mut [u8]),
}

fn take<T>(pieces: &Mutex<impl Iterator<Item = T>>) -> Option<T> {
    let mut pieces = pieces.lock().unwrap_or_else(|broken| broken.into_inner());
    pieces.next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_a_set_or_an_even_share_of_it() {
        let all = Chunks::some(1000, 1.0);
        let covered: Vec<_> = (0..all.count()).flat_map(|k| all.range(k)).collect();
        assert_eq!(covered, (0..1000).collect::<Vec<_>>());
        assert_eq!(all.rays(7997), 7997);
        let some = Chunks::some(1000, 0.3);
        assert_eq!(some.count(), 2);
        assert_eq!(some.range(1), 512..640);
        // However small the share, there is a chunk; an empty set has none.
        assert_eq!(Chunks::some(1000, 1e-9).count(), 1);
        assert_eq!(Chunks::some(0, 1.0).count(), 0);
    }
}
