//! The scene cache: columns and tree in one file, as they lie in memory.
//!
//! [`write()`] stores all columns of a [`Scene`](phalanx_scene::Scene) and all arrays of its
//! [`Bvh`](phalanx_trace::bvh::Bvh). [`open`] maps the file and returns both without copying a row.
//! In between the file may have been damaged, cut off, made by another build or by an attacker. So
//! every byte is covered by a checksum, and every index that tracing relies on is checked, on all
//! threads, before [`open`] returns. A scene that [`open`] returns can therefore be traced safely
//! and to an end, from any file. Only files that this program wrote are sure to give the picture of
//! the scene they were made from.
//!
//! The file must not change while it is mapped: see `mapping`, the only file here with `unsafe`.
//! The format is described in `header`. It belongs to one version of this program: a cache is built
//! again, never converted.

mod check;
mod columns;
mod header;
#[allow(
    unsafe_code,
    reason = "bytes of a mapped file become rows of columns; each block says why they may"
)]
mod mapping;
mod read;
mod settings;
mod write;

pub use read::{Cached, open};
pub use write::{CacheWriteError, fingerprint, write};

use phalanx_scene::SceneError;
use phalanx_trace::bvh::BvhError;
use std::io;
use std::path::PathBuf;

/// Ending of the names of cache files.
pub const ENDING: &str = "phx";

/// Bytes that one task checks: they stay in a core's own cache between the checksum and the check
/// of the rows.
const BLOCK: usize = 1 << 18;

/// The reason why a cache could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum CacheError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is not a cache that this program can use.
    #[error("{}: {fault}", path.display())]
    Refused {
        /// The file.
        path: PathBuf,
        /// The fault in the file.
        fault: CacheFault,
    },
}

/// A fault in a cache.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CacheFault {
    /// Another kind of file, or an empty one.
    #[error("not a scene cache")]
    NotACache,
    /// Written on a machine of the other byte order.
    #[error("a scene cache of a machine with another byte order")]
    ByteOrder,
    /// Written by a build with another version of the format.
    #[error("a scene cache of version {0}; this is a program for version {version}", version = header::VERSION)]
    Version(u32),
    /// Written by a build whose rows have other sizes.
    #[error("a scene cache of another build of this program, with another layout")]
    Layout,
    /// The end is missing.
    #[error("the scene cache is cut off: it has {length} of {needed} bytes")]
    Truncated {
        /// Bytes that are there.
        length: u64,
        /// Bytes that should be there, as far as is known.
        needed: u64,
    },
    /// A checksum does not fit.
    #[error("the scene cache is damaged: its checksum does not fit the {0}")]
    Damaged(&'static str),
    /// There are bytes where none should be: after the end, or other than zero between sections.
    #[error("the scene cache is damaged: it has surplus bytes {0}")]
    Surplus(&'static str),
    /// Checksums fit, but this program would never have written one of the rows.
    #[error("the scene cache holds nonsense in its {0}")]
    Nonsense(&'static str),
    /// The columns do not make a scene.
    #[error("the scene cache holds no valid scene: {0}")]
    Scene(#[from] SceneError),
    /// The arrays do not make a tree.
    #[error("the scene cache holds no valid tree: {0}")]
    Tree(#[from] BvhError),
}
