//! Bytes to [`Scene`]. All errors in a scene file are found here.

mod bytes;
mod decimal;
mod defaults;
mod diagnostics;
mod faces;
mod folder;
mod gltf;
mod memory_budget;
mod mesh;
mod mesh_defaults;
mod nff;
mod number;
mod obj;
mod origin;
mod picture;
mod ply;
mod stl;
mod test_scene;
mod texture;
mod workers;

pub use defaults::override_scene;
pub use diagnostics::MAX_DIAGNOSTICS;
pub use origin::Origin;
pub(crate) use origin::note as origin_note;

use diagnostics::{DiagnosticSink, Span};
use folder::Folder;
use glam::{DVec3, Vec3};
use origin::ReadStop;
use phalanx_scene::{FileView, Material, Scene};
use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// One message about a span of a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Line, from 1; 0 in a binary file, where only the offset gives the position.
    pub line: usize,
    /// Column in characters, from 1; a byte order mark counts as none. 0 in a binary file.
    pub column: usize,
    /// Byte offset of the span in the file, byte order mark included.
    pub offset: usize,
    /// Length of the span in bytes.
    pub length: usize,
    /// The error or remark.
    pub message: String,
    /// Advice on how to mend it, if there is any.
    pub help: Option<String>,
}

/// The reason why a file gave no scene.
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
        /// Its text, for showing the spans; U+FFFD or `?` stands for bytes that are not UTF-8. For
        /// a binary file this is its header, if that is text.
        text: String,
        /// The errors: at least one, at most [`MAX_DIAGNOSTICS`], in file order.
        diagnostics: Vec<Diagnostic>,
    },
    /// Files that the scene names, or data that it makes, would take more than
    /// [`Options::max_memory`].
    #[error("{}: about {needed} bytes would be needed {what}, and {allowed} are allowed", path.display())]
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
    /// The file's ending names no format that is read here.
    #[error("{}: not a scene format that is read here", path.display())]
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

/// A scene and the remarks of its reader.
#[derive(Debug)]
pub struct Loaded {
    /// The scene, validated and range-fitted.
    pub scene: Scene,
    /// Remarks that do not stop a render.
    pub warnings: Vec<Diagnostic>,
    /// Remarks on what was added because the file has none, such as a camera.
    pub notes: Vec<String>,
}

/// The user's options beside the file: defaults for parts that a mesh lacks, and overrides of parts
/// that a file has.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Replaces the file's camera.
    pub view: Option<FileView>,
    /// Replaces the file's lights, unless empty.
    pub lights: Vec<AddedLight>,
    /// Replaces the file's background.
    pub background: Option<Vec3>,
    /// Material for triangles whose file names none.
    pub material: Option<Material>,
    /// Position of the scene's origin.
    pub origin: Origin,
    /// Threads that a reader may use; 0 for one per CPU.
    pub threads: usize,
    /// Bytes that may be used beyond the file itself and columns of its size: for other files,
    /// decoded pictures, copied meshes, and polygons of few bytes a triangle. They are counted
    /// before they are used. `None` sets no limit.
    pub max_memory: Option<u64>,
}

/// A light of [`Options`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AddedLight {
    /// A point light that does not fade.
    Point {
        /// Position, in the file's coordinates.
        position: DVec3,
        /// Colour.
        color: Vec3,
    },
    /// Light from infinitely far away.
    Directional {
        /// The vector toward it, of any length but zero.
        toward: Vec3,
        /// Colour.
        color: Vec3,
    },
}

/// A scene format, by the ending of its files.
#[derive(Clone, Copy)]
enum SceneFormat {
    Test,
    Nff,
    Gltf,
    Obj,
    Ply,
    Stl,
}

impl SceneFormat {
    const ALL: [(&'static str, SceneFormat); 7] = [
        ("test", SceneFormat::Test),
        ("nff", SceneFormat::Nff),
        ("gltf", SceneFormat::Gltf),
        ("glb", SceneFormat::Gltf),
        ("obj", SceneFormat::Obj),
        ("ply", SceneFormat::Ply),
        ("stl", SceneFormat::Stl),
    ];

    fn of(ending: &OsStr) -> Option<SceneFormat> {
        let named = SceneFormat::ALL.iter();
        named
            .filter(|(name, _)| ending.eq_ignore_ascii_case(name))
            .map(|&(_, format)| format)
            .next()
    }

    /// The part of the file whose lines can be shown to a person.
    fn text(self, bytes: &[u8]) -> String {
        match self {
            SceneFormat::Gltf if gltf::is_binary(bytes) => String::new(),
            SceneFormat::Test | SceneFormat::Nff | SceneFormat::Gltf => {
                String::from_utf8_lossy(bytes).into_owned()
            }
            SceneFormat::Obj => lossy_text(bytes),
            SceneFormat::Ply => lossy_text(ply::text_part(bytes)),
            SceneFormat::Stl => lossy_text(stl::text_part(bytes)),
        }
    }
}

/// The endings of the files that [`load`] reads.
pub fn endings() -> impl Iterator<Item = &'static str> {
    SceneFormat::ALL.iter().map(|&(ending, _)| ending)
}

/// Reads a scene file, choosing the format by its ending.
///
/// # Errors
/// [`LoadError`], with every problem found up to [`MAX_DIAGNOSTICS`].
pub fn load(path: &Path, options: &Options) -> Result<Loaded, LoadError> {
    load_format(path, path.extension(), options)
}

/// Reads a scene file of the format with this ending (one of [`endings`]). The ending of its own
/// name is not looked at.
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

fn known_format(path: &Path, ending: Option<&OsStr>) -> Result<SceneFormat, LoadError> {
    let known = ending.and_then(SceneFormat::of);
    known.ok_or_else(|| LoadError::UnknownFormat {
        path: path.to_path_buf(),
    })
}

fn load_read(
    path: &Path,
    format: SceneFormat,
    bytes: &[u8],
    options: &Options,
) -> Result<Loaded, LoadError> {
    let asset_dir = Folder::of(path).within(options.max_memory);
    read(format, bytes, &asset_dir, options).map_err(|diagnostics| {
        let path = path.to_path_buf();
        match asset_dir.allowance().refusal() {
            Some(refused) => LoadError::Memory {
                path,
                what: refused.what,
                needed: refused.needed,
                allowed: refused.allowed,
            },
            None => LoadError::Scene {
                path,
                text: format.text(bytes),
                diagnostics,
            },
        }
    })
}

/// Reads a file in its own coordinates, and once more if its geometry turns out to be far away: see
/// [`origin`].
fn read(
    format: SceneFormat,
    bytes: &[u8],
    asset_dir: &Folder,
    options: &Options,
) -> Result<Loaded, Vec<Diagnostic>> {
    let mut options = options.clone();
    let chosen = options.origin != Origin::Auto;
    let mut notes = Vec::new();
    let mut readings = 0;
    loop {
        readings += 1;
        let origin = options.origin.position();
        match read_once(format, bytes, asset_dir, &options) {
            Ok(mut loaded) => {
                let again = !chosen && loaded.scene.is_moved() && readings < origin::MAX_READINGS;
                match origin::of_scene(&loaded.scene).filter(|_| again) {
                    Some(farther) => options.origin = Origin::At((origin + farther).into()),
                    None => {
                        notes.extend(origin::note(&loaded.scene));
                        notes.append(&mut loaded.notes);
                        return Ok(Loaded { notes, ..loaded });
                    }
                }
            }
            Err(ReadStop::Wrong(diagnostics)) => return Err(diagnostics),
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

fn read_once(
    format: SceneFormat,
    bytes: &[u8],
    asset_dir: &Folder,
    options: &Options,
) -> Result<Loaded, ReadStop> {
    match format {
        SceneFormat::Test => test_scene::read(text_of(bytes)?, options),
        SceneFormat::Nff => nff::read(text_of(bytes)?, options),
        SceneFormat::Gltf if gltf::is_binary(bytes) => gltf::read(bytes, asset_dir, options),
        SceneFormat::Gltf => gltf::read(text_of(bytes)?.as_bytes(), asset_dir, options),
        SceneFormat::Obj => obj::read(bytes, asset_dir, options),
        SceneFormat::Ply => ply::read(bytes, asset_dir.allowance(), options),
        SceneFormat::Stl => stl::read(bytes, options),
    }
}

/// Reads a scene from bytes, as from a file with that ending (one of [`endings`]) but without a
/// folder around it. `None` if the ending names no format.
///
/// # Errors
/// Faults of the bytes, in file order: at least one and at most [`MAX_DIAGNOSTICS`] diagnostics.
pub fn read_bytes(
    ending: &str,
    bytes: &[u8],
    options: &Options,
) -> Option<Result<Loaded, Vec<Diagnostic>>> {
    let format = SceneFormat::of(OsStr::new(ending))?;
    let asset_dir = Folder::none().within(options.max_memory);
    Some(read(format, bytes, &asset_dir, options))
}

fn text_of(bytes: &[u8]) -> Result<&str, Vec<Diagnostic>> {
    std::str::from_utf8(bytes).map_err(|error| not_text(bytes, error.valid_up_to()))
}

/// Reads a scene from the text of a `.test` file.
///
/// # Errors
/// Faults of the text, in file order: at least one and at most [`MAX_DIAGNOSTICS`] diagnostics.
pub fn read_test(text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    read_text(SceneFormat::Test, text)
}

/// Reads a scene from the text of an NFF file (Eric Haines' neutral file format).
///
/// # Errors
/// Faults of the text, in file order: at least one and at most [`MAX_DIAGNOSTICS`] diagnostics.
pub fn read_nff(text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    read_text(SceneFormat::Nff, text)
}

fn read_text(format: SceneFormat, text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    let options = Options::default();
    read(format, text.as_bytes(), &Folder::none(), &options)
}

fn open(path: &Path) -> io::Result<File> {
    // Some systems open a directory as if it were a file and fail at the first read, others say
    // "access denied".
    if std::fs::metadata(path)?.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "is a directory",
        ));
    }
    File::open(path)
}

/// Text that need not be UTF-8, such as names in old encodings. Each byte that is not UTF-8 becomes
/// `?`, so that all offsets stay the same.
fn lossy_text(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        out.push_str(chunk.valid());
        out.extend(chunk.invalid().iter().map(|_| '?'));
    }
    out
}

/// The error of a text file that has a byte at `offset` which is no text.
fn not_text(bytes: &[u8], offset: usize) -> Vec<Diagnostic> {
    let mut report = DiagnosticSink::new(bytes);
    // The span is empty, because a byte of the file is another number of bytes in the text that is
    // shown.
    let span = Span { offset, length: 0 };
    report.error_with_help(
        span,
        format!("byte 0x{:02X} is not UTF-8", bytes[offset]),
        "save the file as UTF-8 (or plain ASCII) text",
    );
    report.finish().err().unwrap_or_default()
}
