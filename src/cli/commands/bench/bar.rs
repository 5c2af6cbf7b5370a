//! The progress bar of a run: scenes done, current work, time left.

use crate::cli::commands::render::interior_hint;
use crate::cli::output::{self, CliError, printable, progress};
use indicatif::ProgressBar;
use phalanx::Bvh;
use phalanx::bench::{BenchError, ProgressListener};
use phalanx::frame::Control;
use phalanx::scene::Scene;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Steps of the bar for each scene.
const STEPS: u64 = 1000;

/// A progress bar on stderr, shown only if that is a terminal. It ends the run at a signal, or at
/// its time limit.
pub struct BenchProgressBar<'a> {
    bar: ProgressBar,
    control: &'a Control,
    end: Option<Instant>,
    scenes: u64,
    name: String,
}

impl BenchProgressBar<'_> {
    /// A bar for `scenes` scenes.
    pub fn new(scenes: usize, control: &Control, end: Option<Instant>) -> BenchProgressBar<'_> {
        let style = "{bar:30} {percent:>3} %  {eta} left  {msg}";
        let bar = progress::bar(Some(scenes as u64 * STEPS), style);
        BenchProgressBar {
            bar,
            control,
            end,
            scenes: 0,
            name: String::new(),
        }
    }

    /// Begins a scene, unless the run is to end.
    pub fn scene(&mut self, name: &str) -> Result<(), BenchError> {
        self.bar.set_position(self.scenes * STEPS);
        self.scenes += 1;
        self.name = printable(name).into_owned();
        self.begin_step("loading")
    }

    fn go_on(&self) -> Result<(), BenchError> {
        let is_over = self.end.is_some_and(|end| Instant::now() >= end);
        if is_over || self.control.stop.load(Ordering::Relaxed) {
            return Err(BenchError::Stopped);
        }
        Ok(())
    }

    /// Prints something while the bar is hidden.
    pub fn hidden(&self, print: impl FnOnce() -> Result<(), CliError>) -> Result<(), CliError> {
        self.bar.suspend(print)
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl ProgressListener for BenchProgressBar<'_> {
    fn begin_step(&mut self, what: &str) -> Result<(), BenchError> {
        self.bar.set_message(format!("{}: {what}", self.name));
        self.bar.tick();
        self.go_on()
    }

    fn built(&mut self, scene: &Scene, bvh: &Bvh) {
        let hint = interior_hint(scene, bvh);
        self.bar.suspend(|| hint.inspect(|hint| output::note(hint)));
    }

    fn progress(&mut self, done: f64) -> Result<(), BenchError> {
        let before = self.scenes.saturating_sub(1) * STEPS;
        self.bar.set_position(before + (done * STEPS as f64) as u64);
        self.go_on()
    }
}
