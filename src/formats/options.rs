//! The options for reading a scene file.

use crate::origin::Origin;
use phalanx_scene::Material;
use std::path::PathBuf;

/// The user's options that change how a file is read.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Material for triangles whose file names none.
    pub material: Option<Material>,
    /// Position of the scene's origin.
    pub origin: Origin,
    /// Angle in degrees, 0 to 180, up to which neighbouring triangles without vertex normals get
    /// normals as on a smooth surface. `None` leaves them flat.
    pub smooth: Option<f32>,
    /// Radius of the points of a file without faces, in its units. `None` takes one from the
    /// points' spacing.
    pub point_radius: Option<f32>,
    /// Threads that a reader may use; 0 for one per CPU.
    pub threads: usize,
    /// Bytes that may be used beyond the file itself and columns of its size: for other files,
    /// decoded pictures, copied meshes, and polygons of few bytes per triangle. They are counted
    /// before they are used. `None` sets no limit.
    pub max_memory: Option<u64>,
    /// Further folders for files that the scene file names.
    pub allow_paths: Vec<PathBuf>,
}
