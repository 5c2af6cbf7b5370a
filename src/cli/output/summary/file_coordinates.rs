//! Positions in the file's coordinates, for display.

use glam::Vec3;
use phalanx::scene::Scene;

/// A scene position in the file's coordinates, with the digits that single precision has near the
/// scene's origin: a coordinate of 500000.31 in the file is displayed as such.
pub fn to_file_coordinates(scene: &Scene, position: Vec3) -> [f64; 3] {
    let local = (position / scene.scale).to_array();
    let coordinate = |axis: usize| match (scene.origin[axis], shortest(local[axis])) {
        (0.0, c) => c,
        (origin, c) => origin + c,
    };
    [0, 1, 2].map(coordinate)
}

/// The shortest decimal that rounds to a number.
fn shortest(c: f32) -> f64 {
    c.to_string().parse().unwrap_or(f64::from(c))
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
    fn places_are_told_as_files_have_them() {
        let mut scene = Scene {
            scale: 0.25,
            ..Scene::default()
        };
        assert_eq!(
            to_file_coordinates(&scene, Vec3::new(0.025, -0.0, 1e9)),
            [0.1, 0.0, 4e9]
        );
        scene.origin = [500_000.0, 0.0, -4_012_352.0];
        scene.scale = 1.0;
        let position = to_file_coordinates(&scene, Vec3::new(0.31, 0.1, 7.25));
        assert_eq!(position, [500_000.31, 0.1, -4_012_344.75]);
    }

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
