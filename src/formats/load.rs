//! Files and bytes to scenes, by the table of formats.

use super::bytes;
use super::diagnostics::{Diagnostic, DiagnosticSink, Span};
use super::folder::Folder;
use super::loaded::{LoadError, Loaded};
use super::options::Options;
use super::origin::{self, Origin, ReadStop};
use super::table::{FORMATS, SceneFormat, find};
use super::{foreign, utf16};
use phalanx_scene::Scene;
use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::path::Path;

/// The endings of the files that [`load`] reads.
pub fn endings() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.endings).copied()
}

/// Reads a scene file, choosing the format by its ending.
///
/// # Errors
/// [`LoadError`], with every problem found up to [`MAX_DIAGNOSTICS`](super::MAX_DIAGNOSTICS).
pub fn load(path: &Path, options: &Options) -> Result<Loaded, LoadError> {
    load_format(path, path.extension(), options)
}

/// Reads a scene file of the format with this ending (one of [`endings`]). The ending of its own
/// name is ignored.
///
/// # Errors
/// The errors of [`load`].
pub fn load_as(path: &Path, ending: &str, options: &Options) -> Result<Loaded, LoadError> {
    load_format(path, Some(OsStr::new(ending)), options)
}

fn load_format(
    path: &Path,
    ending: Option<&OsStr>,
    options: &Options,
) -> Result<Loaded, LoadError> {
    let io = |source| LoadError::Io {
        path: path.to_path_buf(),
        source,
    };
    // Opened before the ending is checked: for a mistyped name, a missing file is the more useful
    // error.
    let file = open(path).map_err(io)?;
    let format = known_format(path, ending)?;
    let bytes = bytes::read(file, path, options.threads).map_err(io)?;
    load_read(path, format, &bytes, options)
}

/// Reads a scene from bytes that came from elsewhere, for example from a pipe. They are read like a
/// file of this path and of the format with this ending (one of [`endings`]). Files that the scene
/// names are looked for in the path's folder.
///
/// # Errors
/// The errors of [`load`].
pub fn load_bytes(
    path: &Path,
    ending: &str,
    bytes: &[u8],
    options: &Options,
) -> Result<Loaded, LoadError> {
    let format = known_format(path, Some(OsStr::new(ending)))?;
    load_read(path, format, bytes, options)
}

fn known_format(path: &Path, ending: Option<&OsStr>) -> Result<&'static SceneFormat, LoadError> {
    let known = ending.and_then(find);
    known.ok_or_else(|| LoadError::UnknownFormat {
        path: path.to_path_buf(),
    })
}

fn load_read(
    path: &Path,
    format: &SceneFormat,
    bytes: &[u8],
    options: &Options,
) -> Result<Loaded, LoadError> {
    let asset_dir = Folder::of(path).and(&options.allow_paths);
    let asset_dir = asset_dir.within(options.max_memory);
    let failed = |bytes: &[u8], diagnostics| {
        let path = path.to_path_buf();
        match asset_dir.memory().refusal() {
            Some(refused) => LoadError::Memory {
                path,
                what: refused.what,
                needed: refused.needed,
                allowed: refused.allowed,
            },
            None => LoadError::Scene {
                path,
                text: (format.text)(bytes),
                diagnostics,
            },
        }
    };
    let text = utf16::to_utf8(bytes, asset_dir.memory()).map_err(|why| failed(bytes, why))?;
    let bytes = text.as_deref().unwrap_or(bytes);
    let loaded = read(format, bytes, &asset_dir, options);
    let mut loaded = loaded.map_err(|stop| match stop {
        ReadStop::Options(reason) => LoadError::Options {
            path: path.to_path_buf(),
            reason,
        },
        wrong => failed(bytes, wrong.diagnostics()),
    })?;
    loaded.files = asset_dir.into_files();
    Ok(loaded)
}

/// Reads a file in its own coordinates, and once more if its geometry turns out to be far away: see
/// [`origin`].
fn read(
    format: &SceneFormat,
    bytes: &[u8],
    asset_dir: &Folder,
    options: &Options,
) -> Result<Loaded, ReadStop> {
    let other = foreign::refusal(bytes).or_else(|| foreign::other_kind(bytes, format.endings));
    if let Some(words) = other {
        return Err(DiagnosticSink::binary().refuse(Span::START, words).into());
    }
    let mut options = options.clone();
    let chosen = options.origin != Origin::Auto;
    let mut notes = Vec::new();
    let mut readings = 0;
    let used = asset_dir.memory().used();
    loop {
        readings += 1;
        asset_dir.memory().reset(used);
        let origin = options.origin.position();
        match (format.read)(bytes, asset_dir, &options) {
            Ok(mut loaded) => {
                let again = !chosen && loaded.scene.is_moved() && readings < origin::MAX_READINGS;
                match again.then(|| origin::of_scene(&loaded.scene)).flatten() {
                    Some(farther) => options.origin = Origin::At((origin + farther).into()),
                    None => {
                        notes.extend(origin::note(&loaded.scene));
                        notes.append(&mut loaded.notes);
                        notes.extend(note_on_material(&loaded.scene, &options));
                        return Ok(Loaded { notes, ..loaded });
                    }
                }
            }
            Err(stop @ (ReadStop::Wrong(_) | ReadStop::Options(_))) => return Err(stop),
            Err(ReadStop::Far(position)) => options.origin = Origin::At(position.into()),
            Err(ReadStop::Inexact) => {
                options.origin = Origin::File;
                notes.push(
                    "the scene keeps the origin of its file: its coordinates are single precision, and moving them \
                     would round them"
                        .to_owned(),
                );
            }
        }
    }
}

/// A note that the requested material has no effect, if every triangle has one from the file.
fn note_on_material(scene: &Scene, options: &Options) -> Option<String> {
    let asked = options.material?;
    let rows = 0..scene.materials.len();
    let is_asked: Vec<bool> = rows.map(|row| scene.materials.get(row) == asked).collect();
    let used = |row: &u32| is_asked.get(*row as usize) == Some(&true);
    let is_used = scene.triangles.material.iter().any(used)
        || scene.spheres.material.iter().any(used)
        || scene.ellipsoids.material.iter().any(used)
        || scene.cones.material.iter().any(used);
    let note = "--material has no effect: everything has a material in the file";
    (!is_used).then(|| note.to_owned())
}

/// Reads a scene from bytes, as from a file with that ending (one of [`endings`]) but without a
/// folder around it. `None` if the ending names no format.
///
/// # Errors
/// Faults of the bytes, in file order: at least one and at most
/// [`MAX_DIAGNOSTICS`](super::MAX_DIAGNOSTICS) diagnostics.
pub fn read_bytes(
    ending: &str,
    bytes: &[u8],
    options: &Options,
) -> Option<Result<Loaded, Vec<Diagnostic>>> {
    let format = find(OsStr::new(ending))?;
    let asset_dir = Folder::none().within(options.max_memory);
    let loaded = utf16::to_utf8(bytes, asset_dir.memory()).and_then(|text| {
        let bytes = text.as_deref().unwrap_or(bytes);
        read(format, bytes, &asset_dir, options).map_err(ReadStop::diagnostics)
    });
    Some(loaded)
}

/// Reads a scene from the text of a `.test` file.
///
/// # Errors
/// Faults of the text, in file order: at least one and at most
/// [`MAX_DIAGNOSTICS`](super::MAX_DIAGNOSTICS) diagnostics.
pub fn read_test(text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    let [test, ..] = &FORMATS;
    read_text(test, text)
}

/// Reads a scene from the text of an NFF file (Eric Haines' neutral file format).
///
/// # Errors
/// Faults of the text, in file order: at least one and at most
/// [`MAX_DIAGNOSTICS`](super::MAX_DIAGNOSTICS) diagnostics.
pub fn read_nff(text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    let [_, nff, ..] = &FORMATS;
    read_text(nff, text)
}

fn read_text(format: &SceneFormat, text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    let loaded = read(
        format,
        text.as_bytes(),
        &Folder::none(),
        &Options::default(),
    );
    loaded.map_err(ReadStop::diagnostics)
}

fn open(path: &Path) -> io::Result<File> {
    // Some systems open a directory as if it were a file and fail at the first read, others say
    // "access denied".
    if std::fs::metadata(path)?.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    File::open(path)
}
