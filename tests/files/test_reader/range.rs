//! Scenes in units far from 1 are scaled by an exact power of two, without any change to the
//! picture.

use super::{read, scene};
use glam::Vec3;
use phalanx::formats::read_test;
use phalanx::scene::Scene;

/// A scene with a sphere, an ellipsoid, a triangle and both lights, in units of `unit` (as
/// written).
fn in_units(unit: &str) -> Scene {
    let text = format!(
        "size 4 4\ncamera 0 0 9{unit} 0 0 1{unit} 0 1 0 45\nattenuation 1 2 3\npoint 1{unit} 2{unit} 3{unit} 1 1 1\n\
         directional 0 3 4 1 1 1\nvertex 0 0 0\nvertex 1{unit} 0 0\nvertex 0 2{unit} 0\ntri 0 1 2\n\
         sphere 1{unit} 2{unit} 3{unit} 1.5{unit}\nscale 1 2 4\nsphere 3{unit} 1{unit} 0 2{unit}\n"
    );
    read_test(&text).unwrap_or_else(|e| panic!("{e:#?}")).scene
}

/// Returns true if `a` is `b` times `factor`, bit for bit where the product is a normal number.
fn scaled(a: Vec3, b: Vec3, factor: f64) -> bool {
    a.as_dvec3() == b.as_dvec3() * factor
}

fn is_power_of_two(x: f32) -> bool {
    x.is_normal() && x.to_bits() & 0x007f_ffff == 0
}

#[test]
fn ordinary_units_are_left_alone() {
    for unit in ["", "e3", "e-3", "e6", "e-7"] {
        assert_eq!(in_units(unit).scale, 1.0, "{unit}");
    }
}

#[test]
fn extreme_units_are_scaled_by_a_power_of_two() {
    for (unit, size) in [
        ("e20", 1e20f64),
        ("e-20", 1e-20),
        ("e36", 1e36),
        ("e-30", 1e-30),
    ] {
        let scene = in_units(unit);
        assert!(is_power_of_two(scene.scale), "{unit}: {}", scene.scale);
        // The largest coordinate is that of the ellipsoid or of the eye, 9 to 10 units.
        let extent = scene.bounds().hi.max(scene.view.eye).max_element();
        assert!((0.5..=1.0).contains(&extent), "{unit}: {extent}");
        let s = f64::from(scene.scale);
        let written = |x: f64, y: f64, z: f64| {
            Vec3::new((x * size) as f32, (y * size) as f32, (z * size) as f32)
        };
        assert!(scaled(scene.view.eye, written(0.0, 0.0, 9.0), s), "{unit}");
        assert!(
            scaled(scene.view.center, written(0.0, 0.0, 1.0), s),
            "{unit}"
        );
        assert_eq!(scene.view.up, Vec3::Y);
        assert!(
            scaled(scene.triangles.corners(0)[1], written(1.0, 0.0, 0.0), s),
            "{unit}"
        );
        assert!(
            scaled(scene.triangles.corners(0)[2], written(0.0, 2.0, 0.0), s),
            "{unit}"
        );
        assert!(
            scaled(scene.spheres.center.get(0), written(1.0, 2.0, 3.0), s),
            "{unit}"
        );
        assert_eq!(
            f64::from(scene.spheres.radius[0]),
            f64::from((1.5 * size) as f32) * s
        );
        assert!(
            scaled(scene.lights.position.get(0), written(1.0, 2.0, 3.0), s),
            "{unit}"
        );
        assert!((scene.lights.position.get(1) - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
        scene.validate().unwrap();
    }
}

#[test]
fn ellipsoids_keep_both_maps_inverse_to_each_other() {
    for unit in ["e20", "e-20"] {
        let scene = in_units(unit);
        let [x, y, z, t] = scene.ellipsoids.world_columns(0);
        let [u, v, w, s] = scene.ellipsoids.object_columns(0);
        let back = |p: Vec3| u * p.x + v * p.y + w * p.z + s;
        for (p, expected) in [
            (t, Vec3::ZERO),
            (t + x, Vec3::X),
            (t + y, Vec3::Y),
            (t + z, Vec3::Z),
        ] {
            assert!((back(p) - expected).length() < 1e-5, "{unit}: {}", back(p));
        }
    }
}

/// L/(const + lin·d + quad·d²) in f64, with the file's values or the scene's.
fn light_at(color: f64, attenuation: [f64; 3], d: f64) -> f64 {
    color / (attenuation[0] + attenuation[1] * d + attenuation[2] * d * d)
}

fn light_of(scene: &Scene, i: usize, d: f64) -> f64 {
    let a = scene.lights.attenuation.get(i).as_dvec3();
    let color = f64::from(scene.lights.color.get(i).x);
    light_at(color, a.to_array(), d * f64::from(scene.scale))
}

#[test]
fn light_fades_over_the_scaled_distance_as_over_the_written_one() {
    for (unit, size) in [("e20", 1e20f64), ("e-20", 1e-20)] {
        let all = [
            [1.0, 0.0, 0.0],
            [1.0, 2.0, 3.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1e-20],
            [0.0, 0.0, 1.0],
        ];
        for factors in all {
            let [a, b, c] = factors;
            // Such that the light that arrives is within f32's range in either unit.
            let color: f64 = if size > 1.0 { 1e20 } else { 1e-20 };
            let loaded = read(&format!(
                "sphere 0 0 0 1{unit}\nattenuation {a} {b} {c}\npoint 0 0 2{unit} {color} 0 0\n"
            ));
            let d = 1.25 * size;
            let read = factors.map(|f| f64::from(f as f32));
            let expected = light_at(f64::from(color as f32), read, d);
            let got = light_of(&loaded.scene, 0, d);
            assert!(
                (got / expected - 1.0).abs() < 1e-6,
                "{unit} {factors:?}: {got:e} {expected:e}"
            );
        }
    }
}

#[test]
fn the_ends_of_single_precision_are_within_reach() {
    let huge = scene("sphere 3e38 0 0 3e38\n");
    assert!(huge.scale < 1.0 && huge.bounds().hi.is_finite());
    let huge = scene("sphere 0 0 0 1e19\nscale 1e19 3e19 1e19\nsphere 0 0 0 1\n");
    assert!(
        huge.scale < 1.0,
        "an ellipsoid's squared axes overflow, the axes do not"
    );
    let tiny = "size 4 4\ncamera 0 0 1e-44 0 0 0 0 1 0 45\nsphere 0 0 0 1e-45\n";
    let tiny = read_test(tiny).unwrap().scene;
    assert!(tiny.scale > 1.0 && tiny.spheres.radius[0].is_normal());
}
