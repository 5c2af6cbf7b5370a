//! The outcome of a reader: a scene, or the reason why there is none.

use super::diagnostics::Diagnostic;
use phalanx_files::shown_path;
use phalanx_scene::Scene;
use std::path::PathBuf;

/// A scene and the remarks of its reader.
#[derive(Debug)]
pub struct Loaded {
    /// The scene, validated and range-fitted.
    pub scene: Scene,
    /// Files that were found next to the scene's (materials, textures, buffers), each by its real
    /// path. A caller that writes a picture must not replace them.
    pub files: Vec<PathBuf>,
    /// Remarks that do not stop a render.
    pub warnings: Vec<Diagnostic>,
    /// Remarks on what was added because the file has none, such as a camera.
    pub notes: Vec<String>,
}

/// The reason why a file gave no scene.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", shown_path(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is not a scene.
    #[error("{}: {}", shown_path(path), summary(diagnostics))]
    Scene {
        /// The file.
        path: PathBuf,
        /// Its text, for showing the spans; U+FFFD or `?` replaces bytes that are not UTF-8. For a
        /// binary file this is its header, if that is text.
        text: String,
        /// The errors in file order: at least one, at most
        /// [`MAX_DIAGNOSTICS`](super::MAX_DIAGNOSTICS).
        diagnostics: Vec<Diagnostic>,
    },
    /// Files named by the scene, or the data of the scene, would take more than
    /// [`Options::max_memory`](super::Options::max_memory).
    #[error(
        "{}: about {needed} bytes would be needed {what}, and {allowed} are allowed",
        shown_path(path)
    )]
    Memory {
        /// The file.
        path: PathBuf,
        /// Its purpose, as in "to decode the texture `a.png`".
        what: String,
        /// Bytes that would be used with it.
        needed: u64,
        /// Bytes that may be used.
        allowed: u64,
    },
    /// The file is a scene, but cannot be traced with these options.
    #[error("{}: {reason}", shown_path(path))]
    Options {
        /// The file.
        path: PathBuf,
        /// The option, and what is wrong with it.
        reason: String,
    },
    /// The file's ending is not that of a supported format.
    #[error("{}: not a scene format that is read here", shown_path(path))]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
}

fn summary(diagnostics: &[Diagnostic]) -> String {
    let first = &diagnostics[0];
    match first.line {
        0 => format!("byte {}: {}", first.offset, first.message),
        line => format!("{line}:{}: {}", first.column, first.message),
    }
}
