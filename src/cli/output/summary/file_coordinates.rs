//! Reports of the file's coordinates: the origin of the scene's, and the camera in them.

use phalanx::jobs::spec::camera_options;
use phalanx::scene::Scene;
use serde::Serialize;

/// The camera of a picture, in the coordinates of the scene's file.
#[derive(Debug, Serialize)]
pub struct CameraReport {
    from: [f64; 3],
    at: [f64; 3],
    up: [f32; 3],
    /// Vertical field of view in degrees.
    fov: f32,
    /// Visible height of parallel rays; `None` for a perspective.
    ortho: Option<f64>,
    /// Options that give this camera and the picture's size.
    pub options: String,
    /// True if the file has none, and no option gives one.
    #[serde(skip)]
    pub is_made_up: bool,
}

impl CameraReport {
    /// The camera of a picture of this size.
    pub fn of(scene: &Scene, (width, height): (u32, u32)) -> CameraReport {
        let view = scene.shortest_view(&scene.view);
        let options = format!("{} --size {width}x{height}", camera_options(&view));
        CameraReport {
            from: view.eye.to_array(),
            at: view.center.to_array(),
            up: view.up.to_array(),
            fov: view.fovy,
            ortho: view.ortho,
            options,
            is_made_up: scene.defaulted.view,
        }
    }

    /// The row of a table.
    pub fn row(&self) -> (&'static str, String) {
        ("camera", self.options.clone())
    }
}

/// The table row for a scene's origin; `None` for a scene that was not moved.
pub fn origin_row(origin: [f64; 3]) -> Option<(&'static str, String)> {
    let [x, y, z] = origin;
    let words = || format!("moved to a local origin: {x}, {y}, {z}");
    (origin != [0.0; 3]).then(|| ("origin", words()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_scene_that_moved_has_a_row() {
        assert_eq!(origin_row([0.0; 3]), None);
        let (name, words) = origin_row([5e5, 0.0, -0.5]).unwrap();
        assert_eq!(
            (name, &words[..]),
            ("origin", "moved to a local origin: 500000, 0, -0.5")
        );
    }
}
