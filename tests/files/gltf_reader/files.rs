//! Real files, against the counts listed with them.

use crate::folders::shared_scenes;
use phalanx::formats::{Options, load};

/// Name, triangles stored, triangles shown.
const FILES: [(&str, usize, u64); 11] = [
    ("large/2CylinderEngine.glb", 75_730, 121_496),
    ("large/dragon_vrip.glb", 871_414, 871_414),
    ("medium/DamagedHelmet.glb", 15_452, 15_452),
    ("medium/balloon/scene.gltf", 35_698, 35_698),
    ("medium/terrain.glb", 31_422, 31_422),
    ("small/BoxTextured.glb", 12, 12),
    ("small/Cameras.gltf", 2, 2),
    ("small/CesiumMilkTruck.glb", 2_856, 3_624),
    ("small/Duck.glb", 4_212, 4_212),
    ("small/GolfBall.glb", 356, 356),
    ("small/nested.glb", 36, 36),
];

#[test]
fn every_file_has_its_triangles() {
    let Some(folder) = shared_scenes("gltf") else {
        return;
    };
    for (name, stored, shown) in FILES {
        let loaded = load(&folder.join(name), &Options::default());
        let scene = loaded
            .unwrap_or_else(|error| panic!("{name}: {error}"))
            .scene;
        assert_eq!(
            (scene.prim_count(), scene.visible_count()),
            (stored, shown),
            "{name}"
        );
        assert_eq!(scene.triangles.len(), stored, "{name}");
    }
    let view = load(&folder.join("small/Duck.glb"), &Options::default())
        .expect("the duck")
        .scene;
    assert_eq!(
        (view.width, view.height),
        (1440, 960),
        "its camera's aspect ratio"
    );
}
