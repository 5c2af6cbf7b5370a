//! Bytes to [`Scene`](crate::scene::Scene): the only place where a scene file can be wrong.

use crate::scene::Scene;
use std::path::{Path, PathBuf};

/// One thing to say about a place in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Byte offset of the place in the file.
    pub offset: usize,
    /// Bytes the place spans.
    pub length: usize,
    /// What is wrong.
    pub message: String,
    /// What to do about it, where that can be said.
    pub help: Option<String>,
}

/// Why no scene came out of a file.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is not a scene.
    #[error("{}: {}", path.display(), summary(diagnostics))]
    Scene {
        /// The file.
        path: PathBuf,
        /// Its text, for showing the places.
        text: String,
        /// What is wrong: at least one, at most 20.
        diagnostics: Vec<Diagnostic>,
    },
    /// The file's ending names no format that is read here.
    #[error("{}: not a scene format that is read here", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
}

fn summary(diagnostics: &[Diagnostic]) -> String {
    let first = &diagnostics[0];
    format!("{}:{}: {}", first.line, first.column, first.message)
}

/// A scene and what its reader noticed.
#[derive(Debug)]
pub struct Loaded {
    /// The scene, validated and range-fitted.
    pub scene: Scene,
    /// Remarks that do not stop a render.
    pub warnings: Vec<Diagnostic>,
}

/// Reads a scene file, choosing the format by its ending.
///
/// # Errors
/// [`LoadError`], with every problem found up to 20.
pub fn load(path: &Path) -> Result<Loaded, LoadError> {
    Err(LoadError::UnknownFormat {
        path: path.to_path_buf(),
    })
}
