//! Files of finished work, to which one process at a time may add.

use super::render_key::{KeyDifference, list_differences};
use phalanx_files::Destination;
use phalanx_files::shown_path;
use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// The reason why a file of finished tiles, or a list of finished frames, cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum KeptFileError {
    /// The file could not be read or written.
    #[error("cannot use {}: {source}", shown_path(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Another process writes to it.
    #[error("{}: another render is using it", shown_path(path))]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// The file is of another kind.
    #[error("{}: not {expected}", shown_path(path))]
    Other {
        /// The file.
        path: PathBuf,
        /// The kind that it should be of.
        expected: &'static str,
    },
    /// The file was made by a program with another layout.
    #[error(
        "{}: made by another version of phalanx: its layout has version {found}, this program reads version {known}",
        shown_path(path)
    )]
    Layout {
        /// The file.
        path: PathBuf,
        /// Version of the file's layout.
        found: u32,
        /// The supported version.
        known: u32,
    },
    /// The file holds work on another picture or sequence.
    #[error("{}: {holds}: {}", shown_path(path), list_differences(differences))]
    Different {
        /// The file.
        path: PathBuf,
        /// The work that it holds.
        holds: &'static str,
        /// Differences, at least one.
        differences: Vec<KeyDifference>,
    },
}

impl KeptFileError {
    pub(super) fn io(path: &Path, source: io::Error) -> KeptFileError {
        let path = path.into();
        KeptFileError::Io { path, source }
    }

    pub(super) fn other(path: &Path, expected: &'static str) -> KeptFileError {
        let path = path.into();
        KeptFileError::Other { path, expected }
    }
}

/// Rejects a path that cannot be such a file, without opening it: opening a pipe would block.
pub(super) fn check_regular(path: &Path) -> Result<(), KeptFileError> {
    let io = |source| KeptFileError::io(path, source);
    match Destination::of(path).map_err(io)? {
        Destination::File(_) => Ok(()),
        Destination::Stream(_) | Destination::Open(_) => Err(io(io::Error::other(
            "what is finished is kept in a regular file only",
        ))),
    }
}

/// Opens a file, or creates it, and locks it for this process until it is closed.
///
/// Some network file systems have no locks: there nothing is rejected, because a file stays valid
/// even if two processes add to it.
pub(super) fn open_exclusive(path: &Path) -> Result<File, KeptFileError> {
    check_regular(path)?;
    let mut options = OpenOptions::new();
    let options = options.read(true).write(true).create(true).truncate(false);
    let opened = options.open(path);
    let file = opened.map_err(|source| KeptFileError::io(path, source))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(KeptFileError::InUse { path: path.into() }),
        _ => Ok(file),
    }
}
