//! Reasons why there is no frame.

use crate::Interrupted;
use phalanx_scene::ViewError;
use phalanx_scene::camera::LensError;

/// The reason why there is no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// Stopped through [`Control`](crate::Control).
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// The scene was not validated.
    #[error(transparent)]
    View(#[from] ViewError),
    /// The settings describe an impossible lens.
    #[error(transparent)]
    Lens(#[from] LensError),
    /// The picture has no width or no height, or the region lies outside of it.
    #[error("the picture has no pixels, or none within the region")]
    NoPixels,
    /// The minimum weight of bounces is NaN.
    #[error("the minimum weight of bounces is not a number")]
    MinWeight,
}
