//! Parts of a scene that its reader made up.

/// Parts that a reader made up, because the file gives none. They may be made again for another
/// picture, and are no longer made up once they are replaced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MadeUpParts {
    /// True if the view is one that frames everything. Its up vector is the axis that points up.
    pub view: bool,
    /// True if the only light is a key light beside the camera.
    pub light: bool,
}
