//! The progress bar: drawn on stderr, from a polling loop beside the render, where stderr is a terminal.

use super::failure::Failure;
use super::interrupt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use phalanx::frame::{self, Control, Frame, FrameError, Prepared, Settings};
use phalanx::scene::Scene;
use std::io::IsTerminal;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// The scalar tracer recurses once per bounce, up to 1000 deep, on the thread that renders.
const STACK_BYTES: usize = 64 << 20;

/// Renders, heeding signals and showing progress.
pub fn render(scene: &Scene, prepared: &Prepared, settings: &Settings) -> Result<Frame, Failure> {
    watched(settings, |control| {
        frame::render(scene, prepared, settings, control)
    })
}

/// Does what fills a picture of these settings, heeding signals and showing progress.
pub fn watched<T: Send>(
    settings: &Settings,
    fill: impl FnOnce(&Control) -> Result<T, FrameError> + Send,
) -> Result<T, Failure> {
    interrupt::stoppable(|control| {
        std::thread::scope(|scope| {
            let (done, finished) = channel::<()>();
            let work = move || {
                // Dropped when this thread ends, however it ends: that is what the loop waits for.
                let _done = done;
                fill(control)
            };
            let thread = std::thread::Builder::new()
                .stack_size(STACK_BYTES)
                .spawn_scoped(scope, work)
                .map_err(|e| Failure::Runtime(format!("cannot start a thread: {e}")))?;
            watch(control, settings, &finished);
            let filled = thread
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            filled.map_err(Failure::from)
        })
    })
}

/// A line that says how many bytes have been written and for how long, where stderr is a terminal.
pub fn bytes() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {binary_bytes} written in {elapsed}")
    {
        bar.set_style(style);
    }
    bar
}

/// Draws until the render ends.
fn watch(control: &Control, settings: &Settings, finished: &Receiver<()>) {
    if !std::io::stderr().is_terminal() {
        // The only message is the sender's end.
        let _ = finished.recv();
        return;
    }
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let bar = ProgressBar::with_draw_target(Some(pixels), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {msg}  {eta} left")
    {
        bar.set_style(style);
    }
    let start = Instant::now();
    while finished.recv_timeout(Duration::from_millis(100)) == Err(RecvTimeoutError::Timeout) {
        let rays = control.rays.load(Ordering::Relaxed) as f64;
        let speed = rays / 1e6 / start.elapsed().as_secs_f64();
        bar.set_message(format!("{speed:.2} Mrays/s"));
        bar.set_position(control.pixels.load(Ordering::Relaxed));
    }
    bar.finish_and_clear();
}
