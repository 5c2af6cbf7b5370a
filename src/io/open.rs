//! Opens scenes of any kind by name, as a [`Scene`], with its tree if it has one already.

use crate::cache::{self, CacheError, Cached};
use crate::load::{self, Loaded, Options};
use phalanx_formats::{Diagnostic, LoadError, Origin};
use phalanx_look::override_scene;
use phalanx_scene::{Scene, SceneError};
use phalanx_standard::StandardError;
use phalanx_trace::bvh::Bvh;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// A scene that was opened.
#[derive(Debug)]
pub struct Opened {
    /// The scene, valid.
    pub scene: Scene,
    /// Its tree, if the scene came out of a cache.
    pub bvh: Option<Bvh>,
    /// Bytes of the cache that stay mapped; 0 for other files.
    pub mapped_bytes: u64,
    /// Files that were found next to the scene's, each by its real path.
    pub files: Vec<PathBuf>,
    /// Remarks that do not stop a render.
    pub warnings: Vec<Diagnostic>,
    /// Remarks on defaults for parts that the file lacks, and on options without effect.
    pub notes: Vec<String>,
}

impl From<Loaded> for Opened {
    fn from(loaded: Loaded) -> Opened {
        Opened {
            scene: loaded.scene,
            bvh: None,
            mapped_bytes: 0,
            files: loaded.files,
            warnings: loaded.warnings,
            notes: loaded.notes,
        }
    }
}

/// The reason why a scene could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Error of a reader.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// Error of the cache.
    #[error(transparent)]
    Cache(#[from] CacheError),
    /// Error of the catalogue of standard scenes.
    #[error(transparent)]
    Standard(#[from] StandardError),
    /// The scene cannot be traced with these options.
    #[error("the scene cannot be traced with these options: {0}")]
    Options(#[from] SceneError),
}

/// Returns true if a file is a scene cache, by the ending of its name.
pub fn is_cache(path: &Path) -> bool {
    let ending = path.extension();
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case(cache::ENDING))
}

/// The name of a standard scene, if it is one. A file of the same name can still be opened, as
/// `./standard:…`.
pub fn standard_name(name: &Path) -> Option<&str> {
    let text = name.to_str();
    text.filter(|text| text.starts_with(phalanx_standard::PREFIX))
}

/// The name of a scene, without folder, ending and size, for files that are made from it; `None`
/// if it has none.
pub fn stem(name: &Path) -> Option<&OsStr> {
    match standard_name(name) {
        Some(standard) => standard.split(':').nth(1).map(OsStr::new),
        None => name.file_stem(),
    }
}

/// Opens a scene file of the format with this ending (one of [`phalanx_formats::endings`]). The
/// ending of its own name is ignored.
///
/// # Errors
/// [`OpenError`].
pub fn open_as(path: &Path, ending: &str, options: &Options) -> Result<Opened, OpenError> {
    Ok(load::load_as(path, ending, options)?.into())
}

/// Opens a scene from bytes that came from elsewhere, for example from a pipe. They are read like a
/// file of this name and of the format with this ending.
///
/// # Errors
/// [`OpenError`].
pub fn open_bytes(
    name: &Path,
    ending: &str,
    bytes: &[u8],
    options: &Options,
) -> Result<Opened, OpenError> {
    Ok(load::load_bytes(name, ending, bytes, options)?.into())
}

/// Opens a scene file, a scene cache, or a standard scene.
///
/// # Errors
/// [`OpenError`].
pub fn open(path: &Path, options: &Options) -> Result<Opened, OpenError> {
    if let Some(name) = standard_name(path) {
        let scene =
            phalanx_standard::scene(phalanx_standard::parse_spec(name)?, options.read.threads)?;
        return amended(scene, None, 0, options);
    }
    if !is_cache(path) {
        return Ok(load::load(path, options)?.into());
    }
    let Cached {
        scene,
        bvh,
        file_bytes,
    } = cache::open(path)?;
    amended(scene, Some(bvh), file_bytes, options)
}

/// A scene that does not come from a reader, with the options applied to it.
fn amended(
    mut scene: Scene,
    mut bvh: Option<Bvh>,
    mapped_bytes: u64,
    options: &Options,
) -> Result<Opened, OpenError> {
    let Options { read, look } = options;
    let mut notes = match override_scene(&mut scene, look, read.threads) {
        Err(SceneError::TooFar(_)) => {
            // As in a reader; the tree has the old scale.
            scene.rescale_to_f32_range();
            bvh = None;
            override_scene(&mut scene, look, read.threads)?
        }
        done => done?,
    };
    notes.extend(phalanx_formats::origin_note(&scene));
    if read.origin != Origin::Auto {
        notes.push("--origin has no effect on a scene cache".to_owned());
    }
    if read.material.is_some() {
        notes.push("--material has no effect on a scene cache".to_owned());
    }
    Ok(Opened {
        scene,
        bvh,
        mapped_bytes,
        files: Vec::new(),
        warnings: Vec::new(),
        notes,
    })
}
