//! Third-party files, if the shared scenes are available.

use crate::folders::shared_scenes;
use phalanx::formats::{LoadError, Options, load};

/// Spheres, cones, triangles, lights (two of its own if the file has none) and warnings.
const FILES: [(&str, [usize; 5]); 11] = [
    ("default/balls.nff", [7381, 0, 2, 3, 0]),
    ("default/gears.nff", [0, 0, 36_610, 5, 0]),
    ("default/mount.nff", [4, 0, 8192, 1, 0]),
    ("default/teapot.nff", [0, 0, 2328, 2, 0]),
    ("default/teapot_s12.nff", [0, 0, 9408, 2, 0]),
    ("default/tree.nff", [4095, 4095, 2, 7, 0]),
    ("large/balls_s5.nff", [66_430, 0, 2, 3, 0]),
    ("small/balls_s2.nff", [91, 0, 2, 3, 0]),
    ("small/cone.nff", [2, 2, 0, 2, 4]),
    ("small/cylinder.nff", [0, 1, 0, 2, 2]),
    ("small/jacks.nff", [6, 3, 0, 1, 0]),
];

#[test]
fn files_of_others_load_with_their_counts() {
    let Some(folder) = shared_scenes("nff") else {
        return;
    };
    for (name, expected) in FILES {
        let loaded = load(&folder.join(name), &Options::default());
        let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
        let scene = &loaded.scene;
        let counts = [
            scene.spheres.len(),
            scene.cones.len(),
            scene.triangles.len(),
            scene.lights.len(),
            loaded.warnings.len(),
        ];
        assert_eq!(counts, expected, "{name}: {:?}", loaded.warnings);
    }
}

/// The only file that is refused: its records lack operands, or have too many.
#[test]
fn the_file_with_faulty_records_is_refused_at_each_of_them() {
    let Some(folder) = shared_scenes("nff") else {
        return;
    };
    let error = load(&folder.join("small/spheres.nff"), &Options::default()).unwrap_err();
    let LoadError::Scene { diagnostics, .. } = error else {
        panic!("{error}")
    };
    let lines: Vec<usize> = diagnostics.iter().map(|d| d.line).collect();
    assert_eq!(lines, [8, 17, 20, 25], "{diagnostics:#?}");
}
