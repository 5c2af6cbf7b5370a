//! Opens scenes of any kind by name, as a [`Scene`], with its tree if it has one already. This is
//! where default parts and the user's overrides come to what a reader returns.

use crate::cache::{self, CacheError};
use crate::environment::EnvironmentSource;
use phalanx_formats::{Diagnostic, LoadError, Origin, ReadOptions, ReadScene, SceneFile};
use phalanx_look::{Overrides, UnfitScene, finish_scene, override_scene};
use phalanx_scene::{Scene, SceneError};
use phalanx_standard::StandardError;
use phalanx_trace::bvh::Bvh;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The user's options for opening a scene.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Options of its reader.
    pub read: ReadOptions,
    /// Replacements of its parts.
    pub look: Overrides,
    /// The environment, in place of that of `look`.
    pub environment: Option<EnvironmentSource>,
}

/// A scene that was opened.
#[derive(Debug, Default)]
pub struct Opened {
    /// The scene, validated and range-fitted.
    pub scene: Scene,
    /// Its tree, if the scene came out of a cache.
    pub bvh: Option<Bvh>,
    /// Bytes of the cache that stay mapped; 0 for other files.
    pub mapped_bytes: u64,
    /// Files that were found next to the scene's (materials, textures, buffers), each by its real
    /// path. A caller that writes a picture must not replace them.
    pub files: Vec<PathBuf>,
    /// Remarks that do not stop a render.
    pub warnings: Vec<Diagnostic>,
    /// Remarks on default parts for those that the file lacks, and on options without effect.
    pub notes: Vec<String>,
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
    let file = SceneFile::open(path, Some(ending), options.read.threads)?;
    Ok(load_file(path, &file, options)?)
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
    let file = SceneFile::from_bytes(name, ending, bytes)?;
    Ok(load_file(name, &file, options)?)
}

/// Opens a scene file, a scene cache, or a standard scene.
///
/// # Errors
/// [`OpenError`].
pub fn open(path: &Path, options: &Options) -> Result<Opened, OpenError> {
    let mut opened = Opened::default();
    if let Some(name) = standard_name(path) {
        let spec = phalanx_standard::parse_spec(name)?;
        opened.scene = phalanx_standard::scene(spec, options.read.threads)?;
    } else if is_cache(path) {
        let cached = cache::open(path)?;
        (opened.scene, opened.bvh) = (cached.scene, Some(cached.bvh));
        opened.mapped_bytes = cached.file_bytes;
    } else {
        return Ok(load(path, options)?);
    }
    surrounded(options, |options| amended(opened, options))
}

/// A scene that does not come from a reader, with the options applied to it.
fn amended(mut opened: Opened, options: &Options) -> Result<Opened, OpenError> {
    let Options { read, look, .. } = options;
    let scene = &mut opened.scene;
    let notes = &mut opened.notes;
    notes.extend(match override_scene(scene, look, read.threads) {
        Err(SceneError::TooFar(_)) => {
            // As in a reader; the tree has the old scale.
            scene.rescale_to_f32_range();
            opened.bvh = None;
            override_scene(scene, look, read.threads)?
        }
        done => done?,
    });
    notes.extend(phalanx_formats::origin_note(scene));
    if read.origin != Origin::Auto {
        notes.push("--origin has no effect on a scene cache".to_owned());
    }
    let others = [
        (read.material.is_some(), "material"),
        (read.smooth.is_some(), "smooth"),
        (read.point_radius.is_some(), "point-radius"),
    ];
    let given = others.iter().filter(|(is_given, _)| *is_given);
    notes.extend(given.map(|(_, name)| format!("--{name} has no effect on a scene cache")));
    Ok(opened)
}

/// Reads a scene file, choosing the format by its ending.
///
/// # Errors
/// [`LoadError`], with every problem found up to
/// [`MAX_DIAGNOSTICS`](phalanx_formats::MAX_DIAGNOSTICS).
pub fn load(path: &Path, options: &Options) -> Result<Opened, LoadError> {
    let file = SceneFile::open(path, None, options.read.threads)?;
    load_file(path, &file, options)
}

/// Opens a scene with its environment, which is read first.
fn surrounded<E: From<LoadError>>(
    options: &Options,
    open: impl FnOnce(&Options) -> Result<Opened, E>,
) -> Result<Opened, E> {
    let Some(source) = &options.environment else {
        return open(options);
    };
    let mut options = options.clone();
    let (light, remark) = source.light(options.read.max_memory)?;
    if let Some(most) = &mut options.read.max_memory {
        *most = most.saturating_sub(light.texel_bytes().len() as u64);
    }
    options.look.environment = Some(light);
    let mut opened = open(&options)?;
    opened.notes.extend(remark);
    if let EnvironmentSource::File(path) = source {
        opened.files.push(path.clone());
    }
    Ok(opened)
}

fn load_file(path: &Path, file: &SceneFile, options: &Options) -> Result<Opened, LoadError> {
    surrounded(options, |options| {
        let read = file.read(&options.read)?;
        let is_text = read.is_text;
        finish(read, options).map_err(|unfit| {
            if unfit.is_override {
                LoadError::Options {
                    path: path.to_path_buf(),
                    reason: unfit.message,
                }
            } else {
                file.fault(vec![diagnostic(unfit, is_text)])
            }
        })
    })
}

/// The fault of a scene. An override is not in the file, so that it has no line.
fn diagnostic(unfit: UnfitScene, is_text: bool) -> Diagnostic {
    Diagnostic::of_file(is_text && !unfit.is_override, unfit.message, unfit.help)
}

/// Reads a scene from bytes, as from a file with that ending (one of
/// [`phalanx_formats::endings`]) but without a folder around it. `None` if the ending names no
/// format.
///
/// # Errors
/// Faults of the bytes, in file order: at least one and at most
/// [`MAX_DIAGNOSTICS`](phalanx_formats::MAX_DIAGNOSTICS) diagnostics.
pub fn read_bytes(
    ending: &str,
    bytes: &[u8],
    options: &Options,
) -> Option<Result<Opened, Vec<Diagnostic>>> {
    let file = SceneFile::from_bytes(Path::new(""), ending, bytes).ok()?;
    let opened = surrounded(options, |options| {
        let read = file.read_alone(&options.read);
        let read = read.map_err(|diagnostics| file.fault(diagnostics))?;
        let is_text = read.is_text;
        finish(read, options).map_err(|unfit| file.fault(vec![diagnostic(unfit, is_text)]))
    });
    Some(opened.map_err(|error| match error {
        LoadError::Scene { diagnostics, .. } => diagnostics,
        error => vec![Diagnostic::of_file(false, error.to_string(), None)],
    }))
}

/// Reads a scene from the text of a `.test` file.
///
/// # Errors
/// Faults of the text, in file order: at least one and at most
/// [`MAX_DIAGNOSTICS`](phalanx_formats::MAX_DIAGNOSTICS) diagnostics.
pub fn read_test(text: &str) -> Result<Opened, Vec<Diagnostic>> {
    read_text("test", text)
}

/// Reads a scene from the text of an NFF file (Eric Haines' neutral file format).
///
/// # Errors
/// Faults of the text, in file order: at least one and at most
/// [`MAX_DIAGNOSTICS`](phalanx_formats::MAX_DIAGNOSTICS) diagnostics.
pub fn read_nff(text: &str) -> Result<Opened, Vec<Diagnostic>> {
    read_text("nff", text)
}

fn read_text(ending: &str, text: &str) -> Result<Opened, Vec<Diagnostic>> {
    read_bytes(ending, text.as_bytes(), &Options::default()).expect("a format")
}

/// Adds the parts that the file lacks, and applies the overrides.
fn finish(read: ReadScene, options: &Options) -> Result<Opened, UnfitScene> {
    let mut scene = read.scene;
    let threads = options.read.threads;
    let mut notes = Vec::from_iter(read.origin_note);
    notes.extend(finish_scene(
        &mut scene,
        read.up_is_assumed,
        &options.look,
        threads,
    )?);
    notes.extend(read.notes);
    Ok(Opened {
        scene,
        files: read.files,
        warnings: read.warnings,
        notes,
        ..Opened::default()
    })
}
