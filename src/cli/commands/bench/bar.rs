//! The progress bar of a run: scenes done, current work, time left.

use crate::cli::output::{CliError, printable, progress};
use indicatif::ProgressBar;
use phalanx::bench::ProgressListener;

/// Steps of the bar for each scene.
const STEPS: u64 = 1000;

/// A progress bar on stderr, shown only if that is a terminal.
pub struct BenchProgressBar {
    bar: ProgressBar,
    scenes: u64,
    name: String,
}

impl BenchProgressBar {
    /// A bar for `scenes` scenes.
    pub fn new(scenes: usize) -> BenchProgressBar {
        let style = "{bar:30} {percent:>3} %  {eta} left  {msg}";
        let bar = progress::bar(Some(scenes as u64 * STEPS), style);
        BenchProgressBar {
            bar,
            scenes: 0,
            name: String::new(),
        }
    }

    /// Begins a scene.
    pub fn scene(&mut self, name: &str) {
        self.bar.set_position(self.scenes * STEPS);
        self.scenes += 1;
        self.name = printable(name).into_owned();
        self.begin_step("loading");
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

impl ProgressListener for BenchProgressBar {
    fn begin_step(&mut self, what: &str) {
        self.bar.set_message(format!("{}: {what}", self.name));
        self.bar.tick();
    }

    fn progress(&mut self, done: f64) {
        let before = self.scenes.saturating_sub(1) * STEPS;
        self.bar.set_position(before + (done * STEPS as f64) as u64);
    }
}
