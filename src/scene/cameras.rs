//! Cameras that a file has, of which one gives the view.

use crate::view::View;

/// A camera of a scene's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneCamera {
    /// Number of its name in [`Scene::names`](crate::Scene::names), or [`NO_NAME`](crate::NO_NAME).
    pub name: u32,
    /// Its view.
    pub view: View,
    /// As [`DefaultedParts::ortho_size`](crate::DefaultedParts::ortho_size).
    pub ortho_size: Option<[f64; 2]>,
    /// Width in pixels of its picture, whose height is the scene's.
    pub width: u32,
}
