//! Amount of output: `--quiet` and `--verbose`.

use std::sync::OnceLock;

/// Amount of output of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verbosity {
    /// Warnings and errors only.
    Quiet,
    /// The most important figures.
    Normal,
    /// All figures.
    Verbose,
}

/// [`Verbosity::Normal`] until it is set.
static VERBOSITY: OnceLock<Verbosity> = OnceLock::new();

/// Sets the verbosity of this process, once.
pub fn set_verbosity(verbosity: Verbosity) {
    VERBOSITY.get_or_init(|| verbosity);
}

/// The verbosity of this process.
pub fn verbosity() -> Verbosity {
    *VERBOSITY.get().unwrap_or(&Verbosity::Normal)
}
