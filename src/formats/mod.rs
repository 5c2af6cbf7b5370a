//! Bytes to [`Scene`]: the only place where a scene file can be wrong.

mod report;
mod surface;
mod test_scene;

pub use report::MAX_DIAGNOSTICS;

use crate::scene::Scene;
use report::{Place, Report};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// One thing to say about a place in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1; a byte order mark counts as none.
    pub column: usize,
    /// Byte offset of the place in the file, byte order mark included.
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
        /// Its text, for showing the places; U+FFFD stands for what is not UTF-8.
        text: String,
        /// What is wrong: at least one, at most [`MAX_DIAGNOSTICS`], in file order.
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

/// A scene format, by the ending of its files.
#[derive(Clone, Copy)]
enum Format {
    Test,
}

impl Format {
    fn of(path: &Path) -> Option<Format> {
        let ending = path.extension()?;
        ending.eq_ignore_ascii_case("test").then_some(Format::Test)
    }
}

/// Reads a scene file, choosing the format by its ending.
///
/// # Errors
/// [`LoadError`], with every problem found up to [`MAX_DIAGNOSTICS`].
pub fn load(path: &Path) -> Result<Loaded, LoadError> {
    let io = |source| LoadError::Io {
        path: path.to_path_buf(),
        source,
    };
    // Opened before the ending is looked at: that a file is not there is the better answer to a mistyped name.
    let mut file = open(path).map_err(io)?;
    let Some(Format::Test) = Format::of(path) else {
        return Err(LoadError::UnknownFormat {
            path: path.to_path_buf(),
        });
    };
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(io)?;
    let (text, loaded) = match String::from_utf8(bytes) {
        Ok(text) => {
            let loaded = read_test(&text);
            (text, loaded)
        }
        Err(error) => not_text(&error),
    };
    loaded.map_err(|diagnostics| LoadError::Scene {
        path: path.to_path_buf(),
        text,
        diagnostics,
    })
}

/// Reads a scene from the text of a `.test` file.
///
/// # Errors
/// What is wrong with the text, in file order: at least one and at most [`MAX_DIAGNOSTICS`] diagnostics.
pub fn read_test(text: &str) -> Result<Loaded, Vec<Diagnostic>> {
    test_scene::read(text)
}

fn open(path: &Path) -> io::Result<File> {
    // Some systems open a directory as if it were a file and fail at the first read, others say "access denied".
    if std::fs::metadata(path)?.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "is a directory",
        ));
    }
    File::open(path)
}

/// The text as far as it is one, and the place where it stops to be.
fn not_text(error: &std::string::FromUtf8Error) -> (String, Result<Loaded, Vec<Diagnostic>>) {
    let bytes = error.as_bytes();
    let offset = error.utf8_error().valid_up_to();
    let text = String::from_utf8_lossy(bytes).into_owned();
    let mut report = Report::new(&text);
    let place = Place {
        offset,
        length: char::REPLACEMENT_CHARACTER.len_utf8(),
    };
    report.error_with_help(
        place,
        format!("byte 0x{:02X} is not UTF-8", bytes[offset]),
        "save the file as UTF-8 (or plain ASCII) text",
    );
    let errors = report.finish().err().unwrap_or_default();
    (text, Err(errors))
}
