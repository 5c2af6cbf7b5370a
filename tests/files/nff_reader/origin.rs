//! Scenes far from the origin of their coordinates.

use super::read;
use glam::{DVec3, Vec3};

const FAR: &str = "b 0.1 0.2 0.3
v
from 500000.1 2 -9
at 500000.3 1 0
up 0 1 0
angle 45
hither 1
resolution 4 4
l 500004.1 9 0
f 1 1 1 0.5 0 1 0 1
s 500000.7 0.5 1.1 0.3
c 499998.1 0 0 0.5 499998.3 1.5 0 0.2
p 3
499997.1 0 -1
500003.2 0 -1
500000.1 0 3.3
pp 3
499997.3 0 -1 0 1 0
500003.2 0 -1 0 2 0
500000.1 0 3.3 0 1 0
";

#[test]
fn every_position_is_taken_from_the_origin_in_double_precision() {
    let loaded = read(FAR);
    let scene = &loaded.scene;
    let origin = DVec3::from(scene.origin);
    let want = |x: f64, y: f64, z: f64| (DVec3::new(x, y, z) - origin).as_vec3();
    assert_eq!(scene.origin, [500_000.0, 0.0, 0.0]);
    assert!(loaded.notes[0].contains("moved to a local origin: 500000, 0, 0"));
    assert_eq!(scene.view.eye, want(500_000.1, 2.0, -9.0));
    assert_eq!(scene.view.center, want(500_000.3, 1.0, 0.0));
    assert_eq!(scene.lights.position.get(0), want(500_004.1, 9.0, 0.0));
    assert_eq!(scene.spheres.center.get(0), want(500_000.7, 0.5, 1.1));
    assert_eq!(scene.spheres.radius[0], 0.3);
    let cone = scene.cones.get(0);
    assert_eq!(cone.base, want(499_998.1, 0.0, 0.0));
    assert_eq!(cone.apex, want(499_998.3, 1.5, 0.0));
    assert_eq!(scene.triangles.corners(0)[0], want(499_997.1, 0.0, -1.0));
    assert_eq!(scene.triangles.corners(1)[0], want(499_997.3, 0.0, -1.0));
    assert_eq!(scene.triangles.corner_normals(1).unwrap()[1], Vec3::Y * 2.0);
}

/// Slightly more than half a unit in the last place above 1, which double precision cannot
/// represent.
#[test]
fn near_scenes_round_positions_once() {
    let number = "1.00000005960464477539062500001";
    let near = FAR.replace("50000", "").replace("4999", "-");
    let scene = read(&near.replace("s 0.7", &format!("s {number}"))).scene;
    assert_eq!(scene.origin, [0.0; 3]);
    assert_eq!(scene.spheres.center.get(0).x, 1.0f32.next_up());
    assert_eq!(number.parse::<f64>().unwrap() as f32, 1.0);
}

/// The ends of the cone are one position in single precision.
#[test]
fn shapes_are_checked_where_the_scene_is_moved() {
    let text = FAR.replace("499998.3 1.5 0 0.2", "499998.11 0 0 0.2");
    let cone = read(&text).scene.cones.get(0);
    assert!((cone.apex.x - cone.base.x - 0.01).abs() < 1e-6);
}
