//! Why a command did not succeed, and the exit code that says so.

use super::{diagnose, interrupt, output};
use phalanx::bench::Wrong;
use phalanx::cache::CacheError;
use phalanx::formats::LoadError;
use phalanx::jobs::{BandsError, PlanError, TileFileError};
use phalanx::open::OpenError;
use phalanx::standard::StandardError;
use std::io::ErrorKind;

/// Why a command did not succeed.
#[derive(Debug)]
pub enum Failure {
    /// Something outside the program: files, mostly. Exit code 1.
    Runtime(String),
    /// The arguments ask for what cannot be. Exit code 2, as clap's own.
    Usage(String),
    /// No scene came out of the file. Exit code 3, unless the file could not be read (1) or its ending is unknown (2).
    Load(Box<LoadError>),
    /// A standard scene, changed by options, that cannot be traced. Exit code 3.
    Scene(String),
    /// A scene cache that cannot be used. Exit code 3, unless it could not be read (1).
    Cache(CacheError),
    /// Pictures or engines differ, as reported on stdout already. Exit code 4.
    Mismatch,
    /// A benchmark's answer is wrong. Exit code 4, unless the scene has no camera (3).
    Wrong(Wrong),
    /// Slower than a baseline, as reported on stdout already. Exit code 5.
    Slower,
    /// Shards of a plan are missing. Exit code 6.
    Missing(String),
    /// SIGINT or SIGTERM. Exit code 130 or 143.
    Interrupted,
    /// The same, but what was finished has been kept: where, and how much.
    Kept(String),
}

impl Failure {
    /// Exit code of the process.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Runtime(_) => 1,
            Failure::Usage(_) => 2,
            Failure::Load(error) => match **error {
                LoadError::Io { .. } | LoadError::Memory { .. } => 1,
                LoadError::UnknownFormat { .. } => 2,
                LoadError::Scene { .. } => 3,
            },
            Failure::Scene(_) => 3,
            Failure::Cache(CacheError::Io { .. }) => 1,
            Failure::Cache(CacheError::Refused { .. }) => 3,
            Failure::Mismatch => 4,
            Failure::Wrong(Wrong::View { .. }) => 3,
            Failure::Wrong(_) => 4,
            Failure::Slower => 5,
            Failure::Missing(_) => 6,
            Failure::Interrupted | Failure::Kept(_) => interrupt::exit_code(),
        }
    }

    /// Adds what to do about it to a message of our own.
    pub fn and(self, remedy: &str) -> Failure {
        match self {
            Failure::Usage(message) => Failure::Usage(format!("{message}; {remedy}")),
            Failure::Runtime(message) => Failure::Runtime(format!("{message}; {remedy}")),
            other => other,
        }
    }

    /// Says it on stderr.
    pub fn tell(&self) {
        match self {
            Failure::Runtime(message) | Failure::Scene(message) | Failure::Missing(message) => {
                output::note(&format!("error: {message}"));
            }
            Failure::Usage(message) => {
                output::note(&format!(
                    "error: {message}\n\nFor more information, try '--help'."
                ));
            }
            Failure::Load(error) => diagnose::tell_error(error),
            Failure::Cache(error) => tell_cache(error),
            Failure::Mismatch | Failure::Slower => {}
            Failure::Wrong(wrong) => output::note(&format!(
                "error: {wrong}\n  help: no rate is given for a wrong answer"
            )),
            Failure::Interrupted => output::note("interrupted"),
            Failure::Kept(what) => output::note(&format!("interrupted: {what}")),
        }
    }
}

/// What is wrong with a cache, and what to do about it.
fn tell_cache(error: &CacheError) {
    output::note(&format!("error: {error}"));
    if let CacheError::Refused { path, .. } = error {
        let path = path.display();
        output::note(&format!(
            "  help: build it again from its scene: phalanx build SCENE -o {path}"
        ));
    }
}

impl From<OpenError> for Failure {
    fn from(error: OpenError) -> Failure {
        match error {
            OpenError::Load(error) => error.into(),
            OpenError::Cache(error) => Failure::Cache(error),
            OpenError::Standard(error) => error.into(),
            OpenError::Options(_) => Failure::Usage(error.to_string()),
        }
    }
}

impl From<StandardError> for Failure {
    fn from(error: StandardError) -> Failure {
        match error {
            StandardError::Scene(_) => Failure::Scene(error.to_string()),
            _ => Failure::Usage(format!(
                "{error}\n\nTo see all standard scenes and their sizes: phalanx scenes"
            )),
        }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Failure {
        Failure::Load(Box::new(error))
    }
}

impl From<phalanx::image::PictureError> for Failure {
    fn from(error: phalanx::image::PictureError) -> Failure {
        Failure::Runtime(error.to_string())
    }
}

impl From<phalanx::frame::FrameError> for Failure {
    fn from(error: phalanx::frame::FrameError) -> Failure {
        match error {
            phalanx::frame::FrameError::Interrupted(_) => Failure::Interrupted,
            phalanx::frame::FrameError::Lens(error) => {
                Failure::Usage(format!("--aperture and --focus: {error}"))
            }
            other => Failure::Runtime(other.to_string()),
        }
    }
}

impl From<BandsError> for Failure {
    fn from(error: BandsError) -> Failure {
        match error {
            BandsError::Frame(error) => error.into(),
            BandsError::Tiles(error) => error.into(),
            other => Failure::Runtime(other.to_string()),
        }
    }
}

impl From<TileFileError> for Failure {
    fn from(error: TileFileError) -> Failure {
        let failure = match error {
            TileFileError::Io { .. } | TileFileError::InUse { .. } => Failure::Runtime,
            _ => Failure::Usage,
        };
        let failure = failure(error.to_string());
        match error {
            TileFileError::Io { source, .. } if source.kind() == ErrorKind::StorageFull => {
                failure.and("what is finished is kept: make room, and give the same command again")
            }
            TileFileError::Different { .. }
            | TileFileError::Other { .. }
            | TileFileError::Layout { .. } => failure.and("name another file, or remove this one"),
            _ => failure,
        }
    }
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Failure {
        match error {
            PlanError::NoShard { .. } => Failure::Usage(error.to_string()),
            PlanError::Output { .. } => Failure::Usage(error.to_string())
                .and("where it goes is for you to say: name it with -o"),
            PlanError::Version { .. } => {
                Failure::Runtime(error.to_string()).and("make the plan again")
            }
            _ => Failure::Runtime(error.to_string()),
        }
    }
}
