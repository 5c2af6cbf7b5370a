//! A scene file in memory, and its reading by the table of formats.

use crate::diagnostics::{Diagnostic, DiagnosticSink, Span};
use crate::folder::Folder;
use crate::folder::foreign;
use crate::memory::{MemoryLedger, OverLimit};
use crate::mesh;
use crate::options::ReadOptions;
use crate::origin::{self, Origin, ReadStop};
use crate::read_scene::{LoadError, ReadScene};
use crate::table::{FORMATS, SceneFormat, find};
use crate::text::{bytes, utf16, workers};
use phalanx_scene::{PrimKind, Scene};
use std::borrow::Cow;
use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::path::Path;

/// The endings of the files that can be read.
pub fn endings() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.endings).copied()
}

/// A scene file in memory, of a known format.
pub struct SceneFile<'a> {
    path: &'a Path,
    format: &'static SceneFormat,
    bytes: Cow<'a, [u8]>,
}

impl<'a> SceneFile<'a> {
    /// Takes a file into memory, on up to `threads` threads, 0 for one per CPU. `ending`, one of
    /// [`endings`], names its format; `None` is the ending of its name.
    ///
    /// # Errors
    /// [`LoadError::Io`] and [`LoadError::UnknownFormat`].
    pub fn open(
        path: &'a Path,
        ending: Option<&str>,
        threads: usize,
    ) -> Result<SceneFile<'a>, LoadError> {
        let io = |source| LoadError::Io {
            path: path.to_path_buf(),
            source,
        };
        // Opened before the ending is checked: for a mistyped name, a missing file is the more
        // useful error.
        let file = open(path).map_err(io)?;
        let format = known_format(path, ending.map(OsStr::new).or(path.extension()))?;
        let bytes = bytes::read(file, path, threads).map_err(io)?.into();
        Ok(SceneFile {
            path,
            format,
            bytes,
        })
    }

    /// Bytes that came from elsewhere, for example from a pipe, as a file of this path and of the
    /// format with this ending.
    ///
    /// # Errors
    /// [`LoadError::UnknownFormat`].
    pub fn from_bytes(
        path: &'a Path,
        ending: &str,
        bytes: &'a [u8],
    ) -> Result<SceneFile<'a>, LoadError> {
        Ok(SceneFile {
            path,
            format: known_format(path, Some(OsStr::new(ending)))?,
            bytes: bytes.into(),
        })
    }

    /// Reads the scene. Files that it names are looked for in the folder of its path.
    ///
    /// # Errors
    /// [`LoadError::Scene`], with every problem found up to
    /// [`MAX_DIAGNOSTICS`](super::MAX_DIAGNOSTICS), and [`LoadError::Memory`].
    pub fn read(&self, options: &ReadOptions) -> Result<ReadScene, LoadError> {
        let asset_dir = Folder::of(self.path).with_opened(&options.allow_paths);
        let asset_dir = asset_dir.with_limit(options.max_memory);
        let read = self.read_in(&asset_dir, options);
        let mut read = read.map_err(|diagnostics| match asset_dir.memory().refusal() {
            Some(refusal) => LoadError::over_limit(self.path, refusal),
            None => self.fault(diagnostics),
        })?;
        read.files = asset_dir.into_files();
        Ok(read)
    }

    /// Reads the scene without a folder around it.
    ///
    /// # Errors
    /// Faults of the bytes, in file order: at least one and at most
    /// [`MAX_DIAGNOSTICS`](super::MAX_DIAGNOSTICS) diagnostics.
    pub fn read_alone(&self, options: &ReadOptions) -> Result<ReadScene, Vec<Diagnostic>> {
        self.read_in(&Folder::none().with_limit(options.max_memory), options)
    }

    /// The error for these faults of the file.
    pub fn fault(&self, diagnostics: Vec<Diagnostic>) -> LoadError {
        let text = utf16::to_utf8(&self.bytes, &MemoryLedger::of(None));
        let text = text.ok().flatten();
        LoadError::Scene {
            path: self.path.to_path_buf(),
            text: (self.format.text)(text.as_deref().unwrap_or(&self.bytes)),
            diagnostics,
        }
    }

    fn read_in(
        &self,
        asset_dir: &Folder,
        options: &ReadOptions,
    ) -> Result<ReadScene, Vec<Diagnostic>> {
        let text = utf16::to_utf8(&self.bytes, asset_dir.memory())?;
        let bytes = text.as_deref().unwrap_or(&self.bytes);
        read(self.format, bytes, asset_dir, options)
    }
}

fn known_format(path: &Path, ending: Option<&OsStr>) -> Result<&'static SceneFormat, LoadError> {
    let format = ending.and_then(find);
    format.ok_or_else(|| LoadError::UnknownFormat {
        path: path.to_path_buf(),
    })
}

/// Reads a file in its own coordinates, and once more if its geometry turns out to be far away: see
/// [`origin`].
fn read(
    format: &SceneFormat,
    bytes: &[u8],
    asset_dir: &Folder,
    options: &ReadOptions,
) -> Result<ReadScene, Vec<Diagnostic>> {
    let other = foreign::refusal(bytes).or_else(|| foreign::other_kind(bytes, format.endings));
    if let Some(words) = other {
        return Err(DiagnosticSink::binary().refuse(Span::START, words));
    }
    let mut options = options.clone();
    let is_origin_given = options.origin != Origin::Auto;
    let mut keeps_origin = false;
    let used = asset_dir.memory().used();
    let mut readings = 0;
    loop {
        readings += 1;
        asset_dir.memory().reset(used);
        let origin = options.origin.position();
        match (format.read)(bytes, asset_dir, &options) {
            Ok(mut read) => {
                let again =
                    !is_origin_given && read.scene.is_moved() && readings < origin::MAX_READINGS;
                match again.then(|| origin::of_scene(&read.scene)).flatten() {
                    Some(farther) => options.origin = Origin::At((origin + farther).into()),
                    None => {
                        let note = smooth(&mut read, &options, asset_dir.memory())?;
                        read.scene.add_missing_tangents();
                        read.origin_note = if keeps_origin {
                            Some(origin::KEPT_NOTE.to_owned())
                        } else {
                            origin::note(&read.scene)
                        };
                        read.notes.extend(note);
                        if options.point_radius.is_some() && !read.is_cloud {
                            let note = "--point-radius has no effect: the scene is no point cloud";
                            read.notes.push(note.to_owned());
                        }
                        read.notes.extend(note_on_material(&read.scene, &options));
                        return Ok(read);
                    }
                }
            }
            Err(ReadStop::Wrong(diagnostics)) => return Err(diagnostics),
            Err(ReadStop::Far(position)) => options.origin = Origin::At(position.into()),
            Err(ReadStop::Inexact) => {
                options.origin = Origin::File;
                keeps_origin = true;
            }
        }
    }
}

/// Gives normals to the scene's triangles that have none, if that is requested. Returns a note if
/// it changes nothing.
fn smooth(
    read: &mut ReadScene,
    options: &ReadOptions,
    memory: &MemoryLedger,
) -> Result<Option<String>, OverLimit> {
    let Some(angle) = options.smooth else {
        return Ok(None);
    };
    let (triangles, objects) = (&mut read.scene.triangles, &read.objects);
    let threads = workers::thread_count(options.threads);
    let is_smooth = mesh::add_smooth_normals(triangles, objects, angle, threads, memory)?;
    let note =
        "--smooth has no effect: all triangles have normals in the file, or edges beyond its angle";
    Ok((!is_smooth).then(|| note.to_owned()))
}

/// A note that the requested material has no effect, if every triangle has one from the file.
fn note_on_material(scene: &Scene, options: &ReadOptions) -> Option<String> {
    let default = options.material?;
    let rows = 0..scene.materials.len();
    let is_default: Vec<bool> = rows
        .map(|row| scene.materials.get(row) == default)
        .collect();
    let used = |row: &u32| is_default.get(*row as usize) == Some(&true);
    let materials = PrimKind::ALL.map(|kind| scene.columns_of(kind).material());
    let is_used = materials.into_iter().flatten().any(used);
    let note = "--material has no effect: everything has a material in the file";
    (!is_used).then(|| note.to_owned())
}

fn open(path: &Path) -> io::Result<File> {
    // Some systems open a directory as if it were a file and fail at the first read, others say
    // "access denied".
    if std::fs::metadata(path)?.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    File::open(path)
}
