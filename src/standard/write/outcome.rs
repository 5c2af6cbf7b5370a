//! The outcome of writing: the features that the file lacks, or the reason why there is none.

use std::io;

/// The reason why a scene could not be written.
#[derive(Debug, thiserror::Error)]
pub enum SceneWriteError {
    /// The file could not be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The format has no such shapes.
    #[error("{format} holds no {shape}; they can be tessellated into triangles")]
    CannotHold {
        /// The format's name.
        format: &'static str,
        /// The shapes it cannot hold, in the plural.
        shape: &'static str,
    },
    /// There are more vertices than the format's indices can count.
    #[error("{0} vertices are more than the format can index")]
    TooMany(u64),
}

/// Features that a written file lacks or simplifies, as text for users. The shapes themselves are
/// complete.
pub type DroppedFeatures = Vec<&'static str>;
