//! Times of the clock and of all threads' CPUs: the machine may have other work.

use std::time::Instant;

unsafe extern "C" {
    /// Microseconds of CPU time of all threads of the process.
    safe fn clock() -> i64;
}

/// Milliseconds of the clock, and of CPU time.
pub type Times = [f64; 2];

/// The times of work, and its result.
pub fn time<T>(work: impl FnOnce() -> T) -> (Times, T) {
    let (start, cpu) = (Instant::now(), clock());
    let made = std::hint::black_box(work());
    let wall = start.elapsed().as_secs_f64() * 1e3;
    ([wall, (clock() - cpu) as f64 / 1e3], made)
}

/// Medians of both times.
pub fn middle(times: &[Times]) -> Times {
    [0, 1].map(|column| {
        let mut times: Vec<f64> = times.iter().map(|times| times[column]).collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    })
}
