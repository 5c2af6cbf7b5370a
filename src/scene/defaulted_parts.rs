//! Default parts of a scene that depend on the picture.

use crate::up_axis::UpAxis;

/// Flags and measurements for default parts that depend on the picture, made once its size and the
/// user's options are known. A part set explicitly is no longer a default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DefaultedParts {
    /// True if the view is one that frames everything.
    pub view: bool,
    /// True if the only lights are a key light and a fill light beside the camera.
    pub light: bool,
    /// True if the format prescribes no number of samples per pixel, so that several are taken.
    pub samples: bool,
    /// True if there are no surroundings: mirrors, if any, reflect a sky.
    pub sky: bool,
    /// The up axis of the default view and sky.
    pub up: UpAxis,
    /// Height that the user wants parallel rays to show, if any.
    pub ortho: Option<OrthoHeight>,
    /// Width and height, in units of the file, that its own camera of parallel rays shows at least,
    /// whatever the shape of the picture; positive.
    pub ortho_size: Option<[f64; 2]>,
    /// Picture for which these parts were last made: its aspect ratio, and whether the camera
    /// orbits. Nothing is remade for an equal picture. `None` if the parts have not been made yet.
    pub made_for: Option<(f64, bool)>,
}

/// Visible height of a camera of parallel rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OrthoHeight {
    /// A made-up camera shows everything. A camera of parallel rays stays as it is. Any other shows
    /// what lies as far away as the point that it looks at in the size that its perspective gives.
    Fitting,
    /// A height, in units of the file; positive.
    Given(f64),
}
