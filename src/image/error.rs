//! Errors of reading, writing and comparing pictures.

use phalanx_files::{shown_path, shown_text};
use std::io;
use std::path::{Path, PathBuf};

/// The reason why a picture could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file could not be written; a regular file that was there is still there.
    #[error("cannot write {}: {source}", shown_path(path))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file could not be read.
    #[error("cannot read {}: {source}", shown_path(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is not a picture, or is broken or too large.
    #[error("{}: not {kind} that can be read: {reason}", shown_path(path))]
    Decode {
        /// The file.
        path: PathBuf,
        /// The kind of picture by the file's first bytes, as in "a PNG picture".
        kind: &'static str,
        /// The decoder's message.
        reason: String,
    },
}

impl PictureError {
    /// The error of a file that could not be written, by the system's reason.
    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> PictureError {
        let path = path.to_path_buf();
        |source| PictureError::Write { path, source }
    }
}

/// Pictures of different sizes cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the pictures differ in size: {}x{} and {}x{}", .0.0, .0.1, .1.0, .1.1)]
pub struct DifferentSizes(pub (u32, u32), pub (u32, u32));

/// The reason why two pictures could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// One of the pictures could not be read, or the picture of the differences not be written.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// They have different sizes.
    #[error(transparent)]
    Sizes(#[from] DifferentSizes),
    /// Their display windows begin at different pixels.
    #[error(
        "the pictures lie in different display windows: one begins at ({} {}), the other at ({} {})",
        .0.0, .0.1, .1.0, .1.1
    )]
    Windows((i32, i32), (i32, i32)),
    /// One holds linear radiance, the other samples for a screen.
    #[error(
        "{} holds linear radiance, and {} samples for a screen: their numbers mean different things",
        shown_path(linear),
        shown_path(display)
    )]
    Meaning {
        /// The file of linear radiance.
        linear: PathBuf,
        /// The file of samples for a screen.
        display: PathBuf,
    },
    /// They have no channel of the same name.
    #[error(
        "the pictures have no layer in common: one has {}, the other {}",
        shown_text(&.0[0].join(", ")),
        shown_text(&.0[1].join(", "))
    )]
    NothingInCommon([Vec<String>; 2]),
    /// A few rows of both do not fit in the memory that a comparison may use.
    #[error(
        "{rows} rows of both pictures take {bytes} bytes, more than the {most} that a comparison \
         may use"
    )]
    Memory {
        /// Number of rows that are compared at once.
        rows: u32,
        /// Bytes that they take.
        bytes: u64,
        /// Bytes that they may take.
        most: u64,
    },
}
