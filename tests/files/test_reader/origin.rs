//! Scenes far from the origin of their coordinates.

use glam::{DVec3, Vec3};
use phalanx::formats::{Options, Origin, ReadOptions, read_bytes, read_test};
use phalanx::scene::Scene;

fn scene(text: &str) -> Scene {
    read_test(text)
        .unwrap_or_else(|errors| panic!("{errors:#?}"))
        .scene
}

/// One of everything that has a position, around x = 6400000, z = -250000.
const FAR: &str = "size 4 4
camera 6400000.1 2 -249990 6400000.3 1 -250000.7 0 1 0 45
point 6400004.1 9 -250000 1 1 1
spherelight 6399998.3 5 -250001 0.25 1 1 1
rectlight 6400001.7 6 -250000 1 0 0 0 0 1 1 1 1
vertex 6399999.1 0 -250001.3
vertex 6400003.2 0 -250001.3
vertex 6400000.1 3.3 -250000.7
tri 0 1 2
pushTransform
translate 6400000.3 0.5 -250000.1
sphere 0.1 0 0 0.75
rotate 0 1 0 90
scale 1 2 3
sphere 0 0 0.1 0.5
popTransform
";

#[test]
fn every_position_is_taken_from_the_origin_in_double_precision() {
    let scene = scene(FAR);
    let origin = DVec3::from(scene.origin);
    let want = |x: f64, y: f64, z: f64| (DVec3::new(x, y, z) - origin).as_vec3();
    assert!(scene.is_moved() && scene.origin[1] == 0.0, "{origin}");
    assert_eq!(scene.view.eye, want(6_400_000.1, 2.0, -249_990.0));
    assert_eq!(scene.view.center, want(6_400_000.3, 1.0, -250_000.7));
    assert_eq!(
        scene.lights.position.get(0),
        want(6_400_004.1, 9.0, -250_000.0)
    );
    assert_eq!(
        scene.lights.position.get(1),
        want(6_399_998.3, 5.0, -250_001.0)
    );
    assert_eq!(
        scene.lights.position.get(2),
        want(6_400_001.7, 6.0, -250_000.0)
    );
    assert_eq!(
        scene.lights.edges[0].get(2),
        Vec3::X,
        "an edge is no position"
    );
    let corners = scene.triangles.corners(0);
    assert_eq!(corners[0], want(6_399_999.1, 0.0, -250_001.3));
    assert_eq!(corners[2], want(6_400_000.1, 3.3, -250_000.7));
    assert_eq!(
        scene.spheres.center.get(0),
        want(6_400_000.3 + 0.1, 0.5, -250_000.1)
    );
    let [x, .., position] = scene.ellipsoids.world_columns(0);
    let far = position.distance(want(6_400_000.3 + 0.1 * 3.0, 0.5, -250_000.1));
    assert!(far < 1e-6, "{far}");
    assert_eq!(x, Vec3::new(0.0, 0.0, -0.5));
    let [.., back] = scene.ellipsoids.object_columns(0);
    assert!(back.abs().max_element() < 20.0, "{back}");
}

#[test]
fn near_scenes_round_operands_as_they_always_did() {
    let text = FAR
        .replace("64000", "")
        .replace("63999", "-")
        .replace("-2500", "-")
        .replace("-2499", "-")
        .replace("sphere 0.1", "sphere 0.4");
    let scene = scene(&text);
    assert_eq!(scene.origin, [0.0; 3]);
    // Operands are rounded to single precision, and then added in double precision.
    let center = f64::from(0.3f32) + f64::from(0.4f32);
    assert_ne!(center as f32, (0.3 + 0.4) as f32);
    assert_eq!(scene.spheres.center.get(0).x, center as f32);
}

/// In single precision the eye and its target coincide.
#[test]
fn a_camera_is_checked_where_the_scene_is_moved() {
    let text = "size 4 4\ncamera 6400000.1 0 0 6400000.2 0 0 0 1 0 45\nsphere 6400003.1 0 0 0.5\n";
    let scene = scene(text);
    let to = scene.view.center.x - scene.view.eye.x;
    assert!((to - 0.1).abs() < 1e-6, "{to}");
    // As it stands, or where it really is one place.
    let options = Options {
        read: ReadOptions {
            origin: Origin::File,
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let standing = read_bytes("test", text.as_bytes(), &options).unwrap();
    assert!(
        standing.unwrap_err()[0]
            .message
            .contains("stands on the point")
    );
    let errors = read_test(&text.replace("6400000.2", "6400000.1")).unwrap_err();
    assert_eq!((errors.len(), errors[0].line), (1, 2), "{errors:?}");
    assert!(errors[0].message.contains("stands on the point"));
}

#[test]
fn a_floor_that_reaches_to_the_origin_keeps_it() {
    let floor = "vertex -7000000 0 0\nvertex 7000000 0 0\nvertex 0 0 7000000\ntri 0 1 2\n";
    let text = FAR.replace("vertex 6399999.1", &format!("{floor}vertex 6399999.1"));
    assert_eq!(scene(&text).origin, [0.0; 3]);
}
