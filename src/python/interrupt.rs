//! Ctrl-C: long work is divided into pieces, and Python's signals are checked between them.

use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Rays per piece: about a second of work for the slowest rays. Each piece starts its threads anew.
pub(crate) const PIECE: usize = 1 << 20;

/// Rays per piece if each may hit everything: up to some 50 µs per ray.
pub(crate) const SMALL_PIECE: usize = 1 << 15;

/// Interval between checks of Python's signals.
const LOOK: Duration = Duration::from_millis(5);

/// Ranges of the pieces of a number of rays.
pub(crate) fn pieces(rays: usize, most: usize) -> impl Iterator<Item = (usize, usize)> {
    let starts = (0..rays).step_by(most);
    starts.map(move |from| (from, (from + most).min(rays)))
}

/// Runs `work` on a separate thread, without the interpreter's lock. A signal sets `stop`, and is
/// raised when the work has ended.
pub(crate) fn stoppable<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    std::thread::scope(|scope| {
        let worker = scope.spawn(work);
        let mut raised = Ok(());
        while !worker.is_finished() {
            py.detach(|| std::thread::sleep(LOOK));
            if raised.is_ok() {
                raised = py.check_signals();
                stop.store(raised.is_err(), Ordering::Relaxed);
            }
        }
        let done = worker.join();
        raised?;
        done.map_err(|_| pyo3::panic::PanicException::new_err("a worker of phalanx panicked"))
    })
}
