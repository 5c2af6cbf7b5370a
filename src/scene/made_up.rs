//! Parts of a scene that are made for each picture anew.

use crate::up_axis::UpAxis;

/// Marks and measures from which parts that depend on the picture are made, once its size and the
/// user's options are known. A part that is given is no longer made up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MadeUpParts {
    /// True if the view is one that frames everything.
    pub view: bool,
    /// True if the only light is a key light beside the camera.
    pub light: bool,
    /// True if there are no surroundings: mirrors, if there are any, see a sky.
    pub sky: bool,
    /// The axis that points up in a view and a sky that are made up.
    pub up: UpAxis,
    /// Height that the user wants parallel rays to show, if any.
    pub ortho: Option<OrthoHeight>,
    /// Width and height, in units of the file, that its own camera of parallel rays shows at least,
    /// whatever the shape of the picture; positive.
    pub ortho_size: Option<[f64; 2]>,
    /// Picture that these parts were last made for: its width over its height, and whether the
    /// camera goes around. Nothing is made again for its like. `None` if they are yet to be made.
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
