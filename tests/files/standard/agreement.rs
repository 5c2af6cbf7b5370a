//! Our databases against the NFF files of the original programs, which print six digits.

use super::{numbers, scene};
use crate::folders::shared_scenes;
use phalanx::formats::{Options, load};
use phalanx::scene::{Scene, Vec3s};

/// Largest difference over the scene's size; the files' own rounding is half a unit of the sixth
/// digit.
const TOLERANCE: f32 = 2e-6;
/// Relative difference allowed by six digits.
const SIX_DIGITS: f32 = 5e-6;
/// Tolerance for dimensionless numbers: surfaces and normals.
const ABSOLUTE: f32 = 2e-5;

const FILES: [(&str, &str); 9] = [
    ("default/balls.nff", "balls"),
    ("default/gears.nff", "gears"),
    ("default/mount.nff", "mount"),
    ("default/tree.nff", "tree"),
    ("default/teapot.nff", "teapot:6"),
    ("default/teapot_s12.nff", "teapot"),
    ("large/balls_s5.nff", "balls:5"),
    ("small/balls_s2.nff", "balls:2"),
    ("small/jacks.nff", "jacks"),
];

fn vectors(v: &Vec3s) -> Vec<f32> {
    (0..v.len()).flat_map(|i| v.get(i).to_array()).collect()
}

#[track_caller]
fn close(what: &str, a: &[f32], b: &[f32], tolerance: f32) {
    assert_eq!(a.len(), b.len(), "{what}");
    for (x, y) in a.iter().zip(b) {
        assert!(
            (x - y).abs() <= tolerance * y.abs().max(1.0),
            "{what}: {a:?}, not {b:?}"
        );
    }
}

fn compare(name: &str, ours: &Scene, theirs: &Scene) {
    let bounds = theirs.bounds();
    let size = (bounds.hi - bounds.lo).length();
    assert_eq!(ours.prim_count(), theirs.prim_count(), "{name}");
    for prim in 0..theirs.prim_count() {
        let (kind, coordinates, material) = numbers(ours, prim);
        let (their_kind, their_coordinates, their_material) = numbers(theirs, prim);
        let what = format!("{name}, primitive {prim}");
        assert_eq!(kind, their_kind, "{what}");
        assert_eq!(coordinates.len(), their_coordinates.len(), "{what}");
        for (k, (a, b)) in coordinates.iter().zip(&their_coordinates).enumerate() {
            // Beyond its nine coordinates a triangle has normals.
            let tolerance = if k < 9 { TOLERANCE * size } else { ABSOLUTE };
            assert!(
                (a - b).abs() <= tolerance,
                "{what}: {coordinates:?}, not {their_coordinates:?}"
            );
        }
        close(&what, &material, &their_material, ABSOLUTE);
    }
    close(
        name,
        &vectors(&ours.lights.position),
        &vectors(&theirs.lights.position),
        SIX_DIGITS,
    );
    assert_eq!(
        vectors(&ours.lights.color),
        vectors(&theirs.lights.color),
        "{name}"
    );
    assert_eq!(ours.background, theirs.background, "{name}");
    let view = |s: &Scene| {
        [s.view.eye, s.view.center, s.view.up]
            .map(|v| v.to_array())
            .concat()
    };
    close(name, &view(ours), &view(theirs), SIX_DIGITS);
    assert_eq!(ours.view.fovy, theirs.view.fovy, "{name}");
    assert_eq!(
        (ours.width, ours.height),
        (theirs.width, theirs.height),
        "{name}"
    );
    assert_eq!(
        (ours.max_depth, ours.encoding),
        (theirs.max_depth, theirs.encoding),
        "{name}"
    );
}

#[test]
fn our_databases_are_those_of_the_original_programs() {
    let Some(folder) = shared_scenes("nff") else {
        return;
    };
    for (file, name) in FILES {
        let theirs = load(&folder.join(file), &Options::default());
        let theirs = theirs.unwrap_or_else(|e| panic!("{e}")).scene;
        compare(file, &scene(name), &theirs);
    }
}
