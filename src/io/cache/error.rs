//! Reasons why a file is rejected as a cache.

use super::file_type::VERSION;
use phalanx_files::shown_path;
use phalanx_scene::SceneError;
use phalanx_trace::bvh::BvhError;
use std::io;
use std::path::PathBuf;

/// The reason why a cache could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum CacheError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", shown_path(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is not a cache that this program can use.
    #[error("{}: {fault}", shown_path(path))]
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
    #[error("a scene cache of version {0}; this is a program for version {version}", version = VERSION)]
    Version(u32),
    /// Written by a build whose rows have other sizes.
    #[error("a scene cache of another build of this program, with another layout")]
    Layout,
    /// The end is missing.
    #[error("the scene cache is cut off: it has {length} of {needed} bytes")]
    Truncated {
        /// Bytes that are present.
        length: u64,
        /// Bytes that should be present, as far as known.
        needed: u64,
    },
    /// A checksum does not match.
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
