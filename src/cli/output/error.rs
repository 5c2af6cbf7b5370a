//! Errors of commands, and their exit codes.

use super::sinks::{self, message, print_error};

use phalanx::bench::BenchError;
use phalanx::cache::CacheError;
use phalanx::files::{shell_path, shown_path};
use phalanx::formats::LoadError;
use phalanx::frame::FrameError;
use phalanx::jobs::{BandsError, KeptFileError, PlanError};
use phalanx::open::OpenError;
use phalanx::standard::StandardError;
use std::fmt::Display;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::atomic::{AtomicU8, Ordering};

/// Base of the exit code of a process ended by a signal; the signal's number is added.
const BY_SIGNAL: u8 = 128;

/// Number of the last signal; SIGINT's until there is one.
static SIGNAL: AtomicU8 = AtomicU8::new(2);

/// Sets the signal for [`signal_exit_code`].
pub fn record_signal(number: u8) {
    SIGNAL.store(number, Ordering::SeqCst);
}

/// The exit code for work stopped by a signal.
pub fn signal_exit_code() -> u8 {
    BY_SIGNAL + SIGNAL.load(Ordering::SeqCst)
}

/// The reason why a command failed.
#[derive(Debug)]
pub enum CliError {
    /// An error outside the program, mostly about files. Exit code 1.
    Runtime(String),
    /// Arguments that cannot be satisfied. Exit code 2, like clap's own.
    Usage(String),
    /// The file is not a valid scene. Exit code 3, unless the file could not be read (1) or its
    /// extension is unknown (2).
    Load(Box<LoadError>),
    /// A standard scene that cannot be traced with its options. Exit code 3.
    Scene(String),
    /// A scene cache that cannot be used. Exit code 3, unless it could not be read (1).
    Cache(CacheError),
    /// Pictures or engines differ, as reported on stdout already. Exit code 4.
    Mismatch,
    /// A benchmark's answer is wrong. Exit code 4, unless the scene has no camera (3).
    Bench(BenchError),
    /// Slower than a baseline, as reported on stdout already. Exit code 5.
    Slower,
    /// Shards or frames of a plan are missing. Exit code 6.
    Missing(String),
    /// SIGHUP, SIGINT or SIGTERM. Exit code 129, 130 or 143.
    Interrupted,
    /// One of these signals, but finished work has been kept. The text says where and how much.
    Resumable(String),
}

impl CliError {
    /// A file that cannot be read.
    pub fn cannot_read(name: impl Display, why: impl Display) -> CliError {
        CliError::Runtime(format!("cannot read {name}: {why}"))
    }

    /// A file that cannot be written.
    pub fn cannot_write(path: &Path, why: impl Display) -> CliError {
        CliError::Runtime(format!("cannot write {}: {why}", shown_path(path)))
    }

    /// A path that the system cannot locate.
    pub fn not_located(path: &Path, why: impl Display) -> CliError {
        CliError::Runtime(format!("cannot locate {}: {why}", shown_path(path)))
    }

    /// Exit code of the process.
    pub fn code(&self) -> u8 {
        match self {
            CliError::Runtime(_) => 1,
            CliError::Usage(_) => 2,
            CliError::Load(error) => match **error {
                LoadError::Io { .. } | LoadError::Memory { .. } => 1,
                LoadError::UnknownFormat { .. } | LoadError::Options { .. } => 2,
                LoadError::Scene { .. } => 3,
            },
            CliError::Scene(_) => 3,
            CliError::Cache(CacheError::Io { .. }) => 1,
            CliError::Cache(CacheError::Refused { .. }) => 3,
            CliError::Mismatch => 4,
            CliError::Bench(BenchError::View { .. }) => 3,
            CliError::Bench(_) => 4,
            CliError::Slower => 5,
            CliError::Missing(_) => 6,
            CliError::Interrupted | CliError::Resumable(_) => signal_exit_code(),
        }
    }

    /// Adds advice to a message about the command line itself.
    pub fn with_hint(self, remedy: &str) -> CliError {
        match self {
            CliError::Usage(message) => CliError::Usage(format!("{message}; {remedy}")),
            CliError::Runtime(message) => CliError::Runtime(format!("{message}; {remedy}")),
            other => other,
        }
    }

    /// The error in a line, for places without a terminal; empty if it has been reported.
    #[cfg(feature = "view")]
    pub fn reason(&self) -> String {
        match self {
            CliError::Load(error) => error.to_string(),
            CliError::Cache(error) => error.to_string(),
            CliError::Bench(error) => error.to_string(),
            CliError::Runtime(message)
            | CliError::Usage(message)
            | CliError::Scene(message)
            | CliError::Missing(message)
            | CliError::Resumable(message) => message.clone(),
            CliError::Mismatch | CliError::Slower => String::new(),
            CliError::Interrupted => "interrupted".to_owned(),
        }
    }

    /// Prints the error on stderr.
    pub fn report(&self) {
        match self {
            CliError::Runtime(message) | CliError::Scene(message) | CliError::Missing(message) => {
                sinks::error(message);
            }
            CliError::Usage(message) => {
                sinks::error(&format!("{message}\n\nFor more information, try '--help'."));
            }
            CliError::Load(error) => print_error(error),
            CliError::Cache(error) => report_cache(error),
            CliError::Mismatch | CliError::Slower => {}
            CliError::Bench(wrong) => sinks::error(&format!(
                "{wrong}\n  help: rates are reported only if all answers are correct"
            )),
            CliError::Interrupted => message("interrupted"),
            CliError::Resumable(what) => message(&format!("interrupted: {what}")),
        }
    }
}

/// Prints an error in a cache, with advice.
fn report_cache(error: &CacheError) {
    sinks::error(&error.to_string());
    if let CacheError::Refused { path, .. } = error {
        let path = shell_path(path);
        message(&format!(
            "  help: rebuild it from its scene: phalanx build SCENE -o {path}"
        ));
    }
}

impl From<OpenError> for CliError {
    fn from(error: OpenError) -> CliError {
        match error {
            OpenError::Load(error) => error.into(),
            OpenError::Cache(error) => CliError::Cache(error),
            OpenError::Standard(error) => error.into(),
            OpenError::Options(_) => CliError::Usage(error.to_string()),
        }
    }
}

impl From<StandardError> for CliError {
    fn from(error: StandardError) -> CliError {
        match error {
            StandardError::Scene(_) => CliError::Scene(error.to_string()),
            _ => CliError::Usage(format!(
                "{error}\n\nTo list all standard scenes and their sizes: phalanx scenes"
            )),
        }
    }
}

impl From<LoadError> for CliError {
    fn from(error: LoadError) -> CliError {
        CliError::Load(Box::new(error))
    }
}

impl From<phalanx::image::PictureError> for CliError {
    fn from(error: phalanx::image::PictureError) -> CliError {
        CliError::Runtime(error.to_string())
    }
}

impl From<FrameError> for CliError {
    fn from(error: FrameError) -> CliError {
        match error {
            FrameError::Interrupted(_) => CliError::Interrupted,
            FrameError::Lens(error) => CliError::Usage(format!("--aperture and --focus: {error}")),
            other => CliError::Runtime(other.to_string()),
        }
    }
}

impl From<BandsError> for CliError {
    fn from(error: BandsError) -> CliError {
        match error {
            BandsError::Frame(error) => error.into(),
            BandsError::Tiles(error) => error.into(),
            other => CliError::Runtime(other.to_string()),
        }
    }
}

impl From<KeptFileError> for CliError {
    fn from(error: KeptFileError) -> CliError {
        let text = error.to_string();
        match error {
            KeptFileError::Io { source, .. } if source.kind() == ErrorKind::StorageFull => {
                CliError::Runtime(text).with_hint(
                    "finished work is kept: free some disk space, then run the same command again",
                )
            }
            KeptFileError::Io { .. } | KeptFileError::InUse { .. } => CliError::Runtime(text),
            KeptFileError::Different { .. }
            | KeptFileError::Other { .. }
            | KeptFileError::Layout { .. } => {
                CliError::Usage(text).with_hint("choose another file, or delete this one")
            }
        }
    }
}

impl From<PlanError> for CliError {
    fn from(error: PlanError) -> CliError {
        let text = error.to_string();
        match error {
            PlanError::NoShard { .. } | PlanError::Frame { .. } => CliError::Usage(text),
            PlanError::Output { .. } => CliError::Usage(text).with_hint("choose a file with -o"),
            PlanError::Version { .. } => CliError::Runtime(text).with_hint("make the plan again"),
            _ => CliError::Runtime(text),
        }
    }
}
