//! Scene files to scenes that can be rendered: what a reader returns, with default parts and the
//! user's overrides.

use phalanx_formats::{Diagnostic, LoadError, ReadOptions, ReadScene, SceneFile};
use phalanx_look::{Overrides, UnfitScene, finish_scene};
use phalanx_scene::Scene;
use std::path::{Path, PathBuf};

/// The user's options for opening a scene.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// How its file is read.
    pub read: ReadOptions,
    /// What replaces parts of it.
    pub look: Overrides,
}

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

/// Reads a scene file, choosing the format by its ending.
///
/// # Errors
/// [`LoadError`], with every problem found up to
/// [`MAX_DIAGNOSTICS`](phalanx_formats::MAX_DIAGNOSTICS).
pub fn load(path: &Path, options: &Options) -> Result<Loaded, LoadError> {
    load_file(
        path,
        SceneFile::open(path, None, options.read.threads)?,
        options,
    )
}

/// Reads a scene file of the format with this ending (one of [`phalanx_formats::endings`]). The
/// ending of its own name is ignored.
///
/// # Errors
/// The errors of [`load`].
pub fn load_as(path: &Path, ending: &str, options: &Options) -> Result<Loaded, LoadError> {
    let file = SceneFile::open(path, Some(ending), options.read.threads)?;
    load_file(path, file, options)
}

/// Reads a scene from bytes that came from elsewhere, for example from a pipe. They are read like a
/// file of this path and of the format with this ending (one of [`phalanx_formats::endings`]).
/// Files that the scene names are looked for in the path's folder.
///
/// # Errors
/// The errors of [`load`].
pub fn load_bytes(
    path: &Path,
    ending: &str,
    bytes: &[u8],
    options: &Options,
) -> Result<Loaded, LoadError> {
    load_file(path, SceneFile::from_bytes(path, ending, bytes)?, options)
}

fn load_file(path: &Path, file: SceneFile, options: &Options) -> Result<Loaded, LoadError> {
    let read = file.read(&options.read)?;
    let is_text = read.is_text;
    finish(read, options).map_err(|unfit| match unfit {
        UnfitScene::Overrides(reason) => LoadError::Options {
            path: path.to_path_buf(),
            reason,
        },
        UnfitScene::File { message, help } => {
            file.fault(vec![Diagnostic::of_file(is_text, message, help)])
        }
    })
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
) -> Option<Result<Loaded, Vec<Diagnostic>>> {
    let file = SceneFile::from_bytes(Path::new(""), ending, bytes).ok()?;
    Some(file.read_alone(&options.read).and_then(|read| {
        let is_text = read.is_text;
        finish(read, options).map_err(|unfit| {
            vec![match unfit {
                UnfitScene::Overrides(reason) => Diagnostic::of_file(false, reason, None),
                UnfitScene::File { message, help } => Diagnostic::of_file(is_text, message, help),
            }]
        })
    }))
}

/// Reads a scene from the text of a `.test` file.
///
/// # Errors
/// Faults of the text, in file order: at least one and at most
/// [`MAX_DIAGNOSTICS`](phalanx_formats::MAX_DIAGNOSTICS) diagnostics.
pub fn read_test(text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    read_text("test", text)
}

/// Reads a scene from the text of an NFF file (Eric Haines' neutral file format).
///
/// # Errors
/// Faults of the text, in file order: at least one and at most
/// [`MAX_DIAGNOSTICS`](phalanx_formats::MAX_DIAGNOSTICS) diagnostics.
pub fn read_nff(text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    read_text("nff", text)
}

fn read_text(ending: &str, text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    let read = read_bytes(ending, text.as_bytes(), &Options::default());
    read.expect("a format")
}

/// Adds the parts that the file lacks, and applies the overrides.
fn finish(read: ReadScene, options: &Options) -> Result<Loaded, UnfitScene> {
    let mut scene = read.scene;
    let threads = options.read.threads;
    let on_look = finish_scene(&mut scene, read.up_is_assumed, &options.look, threads)?;
    let notes = read
        .origin_note
        .into_iter()
        .chain(on_look)
        .chain(read.notes);
    Ok(Loaded {
        scene,
        files: read.files,
        warnings: read.warnings,
        notes: notes.collect(),
    })
}
