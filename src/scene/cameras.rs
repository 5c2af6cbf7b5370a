//! Cameras that a file has, of which one gives the view.

use crate::scene::Scene;
use crate::view::View;

/// A camera of a scene's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneCamera {
    /// Number of its name in [`Scene::names`], or [`NO_NAME`](crate::NO_NAME).
    pub name: u32,
    /// Its view.
    pub view: View,
    /// As [`DefaultedParts::ortho_size`](crate::DefaultedParts::ortho_size).
    pub ortho_size: Option<[f64; 2]>,
    /// Width in pixels of its picture, whose height is the scene's.
    pub width: u32,
}

impl Scene {
    /// Takes the view and the picture's shape of a camera of the file.
    pub fn use_camera(&mut self, camera: SceneCamera) {
        self.view = camera.view;
        self.width = camera.width;
        self.defaulted.view = false;
        self.defaulted.ortho_size = camera.ortho_size;
    }

    /// Index of the camera that gives the view. The height of its parallel rays may be another,
    /// which depends on the picture.
    pub fn used_camera(&self) -> Option<usize> {
        let placed = |view: View| View {
            ortho: None,
            ..view
        };
        let mut cameras = self.cameras.iter();
        cameras.position(|camera| placed(camera.view) == placed(self.view))
    }
}
