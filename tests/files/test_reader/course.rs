//! The course's own scenes, with the counts listed with them.

use crate::folders::shared_scenes;
use phalanx::formats::{Options, load};

/// Name, triangles, spheres of either kind, lights.
const SCENES: [(&str, usize, usize, usize); 14] = [
    ("scene1", 2, 0, 2),
    ("scene1-camera1", 2, 0, 2),
    ("scene1-camera2", 2, 0, 2),
    ("scene1-camera3", 2, 0, 2),
    ("scene1-camera4", 2, 0, 2),
    ("scene2", 12, 21, 0),
    ("scene2-camera1", 12, 21, 0),
    ("scene2-camera3", 12, 21, 0),
    ("scene3", 60, 6, 0),
    ("scene4-ambient", 60, 6, 1),
    ("scene4-diffuse", 60, 6, 1),
    ("scene4-emission", 60, 6, 1),
    ("scene5", 0, 1000, 2),
    ("scene7", 100_000, 0, 1),
];

#[test]
fn the_course_scenes_load_with_the_published_counts() {
    let Some(folder) = shared_scenes("cse167") else {
        return;
    };
    for (name, triangles, spheres, lights) in SCENES {
        let loaded = load(
            &folder.join(name).with_extension("test"),
            &Options::default(),
        )
        .unwrap_or_else(|error| panic!("{error}"));
        let scene = loaded.scene;
        let counts = (
            scene.triangles.len(),
            scene.spheres.len() + scene.ellipsoids.len(),
            scene.lights.len(),
        );
        assert_eq!(counts, (triangles, spheres, lights), "{name}");
        assert_eq!(scene.scale, 1.0, "{name}");
    }
}
