//! The outcome of a reader: a scene, or the reason why there is none.

use crate::diagnostics::{Diagnostic, DiagnosticSink};
use crate::memory::OverLimit;
use crate::options::ReadOptions;
use crate::origin::{self, Origin, ReadStop};
use phalanx_files::shown_path;
use phalanx_scene::{Scene, UpAxis};
use std::path::{Path, PathBuf};

/// A scene as its file gives it, and the remarks of its reader.
#[derive(Debug)]
pub struct ReadScene {
    /// The scene. [`Scene::defaulted`] names the parts that the file does not give. Not validated.
    pub scene: Scene,
    /// True if the format does not say which axis points up.
    pub up_is_assumed: bool,
    /// True if the file is text.
    pub is_text: bool,
    /// True if the scene is the points of a file without faces.
    pub(super) is_cloud: bool,
    /// The first vertex of each object, ascending, if surfaces end between objects.
    pub(super) objects: Vec<u32>,
    /// Files that were found next to the scene's (materials, textures, buffers), each by its real
    /// path.
    pub files: Vec<PathBuf>,
    /// Remarks that do not stop a render.
    pub warnings: Vec<Diagnostic>,
    /// A remark on the origin of a scene that is far away.
    pub origin_note: Option<String>,
    /// Remarks on parts of the file that are not shown, and on options that have no effect.
    pub notes: Vec<String>,
}

/// The last step of every reader: the scene, unless something is wrong or it is far away.
pub(super) fn finish(
    mut scene: Scene,
    options: &ReadOptions,
    report: DiagnosticSink,
) -> Result<ReadScene, ReadStop> {
    // Done even if something is wrong: rounding alone may put a camera on the point it looks at.
    if options.origin == Origin::Auto
        && scene.meshes.is_empty()
        && let Some(far) = origin::of_scene(&scene)
    {
        return Err(ReadStop::Far(far));
    }
    let is_text = report.is_text();
    let warnings = report.finish()?;
    scene.origin = options.origin.position().into();
    // A format with a single camera tells by it which way is up.
    if !scene.defaulted.view && scene.cameras.is_empty() {
        scene.defaulted.up = UpAxis::nearest(scene.view.up);
    }
    Ok(ReadScene {
        scene,
        up_is_assumed: false,
        is_text,
        is_cloud: false,
        objects: Vec::new(),
        files: Vec::new(),
        warnings,
        origin_note: None,
        notes: Vec::new(),
    })
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
    /// [`ReadOptions::max_memory`].
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

impl LoadError {
    /// The error of a file for which there was not enough memory.
    pub(super) fn over_limit(path: &Path, refusal: OverLimit) -> LoadError {
        LoadError::Memory {
            path: path.to_path_buf(),
            what: refusal.what,
            needed: refusal.needed,
            allowed: refusal.allowed,
        }
    }
}

fn summary(diagnostics: &[Diagnostic]) -> String {
    let first = &diagnostics[0];
    match first.line {
        0 => format!("byte {}: {}", first.offset, first.message),
        line => format!("{line}:{}: {}", first.column, first.message),
    }
}
