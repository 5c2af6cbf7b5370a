//! Progress of a render: a bar, lines of JSON, or a preview. A polling loop runs alongside the
//! render.

use super::interrupt;
use super::live_preview::{LivePreview, PreviewWriter};
use super::stderr::message;
use super::verbosity::{Verbosity, verbosity};
use crate::cli::output::error::CliError;
use crate::cli::output::summary::mrays_per_s;
use clap::ValueEnum;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use phalanx::frame::{self, Accel, Control, Frame, Settings};
use phalanx::scene::Scene;
use serde::Serialize;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Stack size of the rendering thread, on which the scalar tracer recurses once per bounce, up to
/// 1000 deep.
const STACK_BYTES: usize = 64 << 20;

/// Options of a render's progress display.
#[derive(Clone, Copy, Default)]
pub struct ProgressOptions<'a> {
    /// Pixels of the picture.
    pub pixels: u64,
    pub mode: ProgressMode,
    /// Preview of the unfinished picture, if requested.
    pub live_preview: Option<&'a LivePreview<'a>>,
}

impl ProgressOptions<'_> {
    /// The default options.
    pub fn of(pixels: u64) -> ProgressOptions<'static> {
        ProgressOptions {
            pixels,
            ..ProgressOptions::default()
        }
    }
}

/// Form of progress reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ProgressMode {
    /// Bar if stderr is a terminal
    #[default]
    Auto,
    /// Bar
    Bar,
    /// One line of JSON per second, on stderr
    Json,
    /// No progress
    None,
}

/// Renders, with signal handling and progress.
pub fn render(
    scene: &Scene,
    prepared: &Accel,
    settings: &Settings,
    mode: ProgressMode,
) -> Result<Frame, CliError> {
    let options = ProgressOptions {
        mode,
        ..ProgressOptions::of(settings.pixels())
    };
    with_progress(options, |control| {
        frame::render(scene, prepared, settings, control)
    })
}

/// Runs `fill`, which renders a picture and may write a file, with signal handling and progress.
pub fn with_progress<T: Send, E: Into<CliError> + Send>(
    options: ProgressOptions,
    fill: impl FnOnce(&Control) -> Result<T, E> + Send,
) -> Result<T, CliError> {
    interrupt::interruptible(|control| on_large_stack(control, options, fill))
}

fn on_large_stack<T: Send, E: Into<CliError> + Send>(
    control: &Control,
    options: ProgressOptions,
    fill: impl FnOnce(&Control) -> Result<T, E> + Send,
) -> Result<T, CliError> {
    std::thread::scope(|scope| {
        let (done, finished) = channel::<()>();
        let work = move || {
            // Dropped when this thread ends, even by a panic; the loop waits for that.
            let _done = done;
            fill(control)
        };
        let thread = std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, work)
            .map_err(|e| CliError::Runtime(format!("cannot start a thread: {e}")))?;
        options.run(control, &finished);
        let filled = thread
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        filled.map_err(Into::into)
    })
}

/// A bar in this style, shown only if stderr is a terminal; `length` is `None` if unknown.
pub fn bar(length: Option<u64>, template: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(length, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Interval between updates of the bar.
const TICK: Duration = Duration::from_millis(100);
/// Interval between JSON lines and previews.
const SECOND: Duration = Duration::from_secs(1);

impl ProgressOptions<'_> {
    /// Reports progress until the render ends.
    fn run(self, control: &Control, finished: &Receiver<()>) {
        let start = Instant::now();
        let mut reporter = ProgressReporter::of(self);
        let state = |event| ProgressState::of(event, self.pixels, control, start);
        let mut reported: Option<Instant> = None;
        loop {
            let state = state("progress");
            reporter.move_bar(&state);
            if reported.is_none_or(|since| since.elapsed() >= SECOND) {
                reporter.report(&state, false, &control.stop);
                reported = Some(Instant::now());
            }
            if finished.recv_timeout(TICK) != Err(RecvTimeoutError::Timeout) {
                break;
            }
        }
        if let Some(bar) = &reporter.bar {
            bar.finish_and_clear();
        }
        reporter.report(&state("end"), true, &control.stop);
    }
}

/// Progress of a render.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ProgressState {
    event: &'static str,
    /// Finished pixels, including those of an earlier run.
    pixels: u64,
    of: u64,
    fraction: f64,
    rays: u64,
    mrays_per_s: f64,
    seconds: f64,
    /// Estimate from the pixels that this run has rendered; `None` if there are none yet.
    seconds_left: Option<f64>,
}

impl ProgressState {
    fn of(event: &'static str, total: u64, control: &Control, start: Instant) -> ProgressState {
        let load = |number: &AtomicU64| number.load(Ordering::Relaxed);
        let (pixels, resumed, rays) = (
            load(&control.pixels).min(total),
            load(&control.pixels_resumed),
            load(&control.rays),
        );
        let seconds = start.elapsed().as_secs_f64();
        let rendered = pixels.saturating_sub(resumed);
        let left = seconds * (total - pixels) as f64 / rendered as f64;
        ProgressState {
            event,
            pixels,
            of: total,
            fraction: pixels as f64 / total.max(1) as f64,
            rays,
            mrays_per_s: mrays_per_s(rays, seconds),
            seconds,
            seconds_left: (rendered > 0).then_some(left),
        }
    }

    /// The speed and, after `between`, the time left if it is known.
    fn speed_words(&self, between: &str) -> String {
        let left = self.seconds_left.map(Duration::from_secs_f64);
        let left = left.map(|left| format!("{between}{} left", HumanDuration(left)));
        let left = left.unwrap_or_default();
        format!("{:.2} Mrays/s{left}", self.mrays_per_s)
    }
}

/// The outputs for progress.
struct ProgressReporter<'a> {
    bar: Option<ProgressBar>,
    json: bool,
    preview: Option<PreviewWriter<'a>>,
}

impl<'a> ProgressReporter<'a> {
    fn of(options: ProgressOptions<'a>) -> ProgressReporter<'a> {
        let terminal = std::io::stderr().is_terminal();
        let preview = options.live_preview.map(PreviewWriter::of);
        let covered = preview.as_ref().is_some_and(PreviewWriter::draws);
        let drawn = match options.mode {
            ProgressMode::Auto => terminal && !covered && verbosity() != Verbosity::Quiet,
            ProgressMode::Bar => !covered,
            ProgressMode::Json | ProgressMode::None => false,
        };
        ProgressReporter {
            bar: drawn.then(|| bar(Some(options.pixels), "{wide_bar} {percent:>3} %  {msg}")),
            json: options.mode == ProgressMode::Json,
            preview,
        }
    }

    fn move_bar(&self, state: &ProgressState) {
        if let Some(bar) = &self.bar {
            bar.set_message(state.speed_words("  "));
            bar.set_position(state.pixels);
        }
    }

    /// Writes a line and shows the preview; at the end, waits for readers.
    fn report(&mut self, state: &ProgressState, end: bool, stop: &AtomicBool) {
        if self.json
            && let Ok(line) = serde_json::to_string(state)
        {
            message(&line);
        }
        if let Some(preview) = &mut self.preview {
            let (percent, speed) = (100.0 * state.fraction, state.speed_words(", "));
            preview.show(&format!("{percent:.1} %, {speed}"), end, stop);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_like_what_was_rendered_now() {
        let control = Control::default();
        let start = Instant::now() - Duration::from_secs(10);
        let state = ProgressState::of("progress", 1000, &control, start);
        assert_eq!(
            (state.pixels, state.fraction, state.seconds_left),
            (0, 0.0, None)
        );
        // 500 were there, and 100 took ten seconds: 400 take forty.
        control.pixels_resumed.store(500, Ordering::Relaxed);
        control.pixels.store(600, Ordering::Relaxed);
        control.rays.store(20_000_000, Ordering::Relaxed);
        let state = ProgressState::of("progress", 1000, &control, start);
        let left = state.seconds_left.unwrap();
        assert!((left / 40.0 - 1.0).abs() < 0.05, "{left}");
        assert!((state.mrays_per_s / 2.0 - 1.0).abs() < 0.05);
        assert_eq!(state.fraction, 0.6);
    }
}
