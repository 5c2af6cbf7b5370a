//! The published counts.

use super::spec;
use phalanx::standard::{
    CATALOGUE, Family, ShapeCounter, ShapeCounts, Spec, Tessellate, counts, scene,
};

/// Name and size; spheres, cones, polygons and lights, as published with the databases.
const PUBLISHED: [(&str, u64, u64, u64, u64); 11] = [
    ("balls:4", 7381, 0, 1, 3),
    ("gears:4", 0, 0, 9345, 5),
    ("jacks:1", 6, 3, 0, 1),
    ("lattice:12", 2197, 6084, 0, 6),
    ("mount:6", 4, 0, 8192, 1),
    ("rings:7", 4200, 4200, 1, 3),
    ("shells:5", 5761, 0, 0, 1),
    ("sombrero:1", 0, 0, 1922, 1),
    ("teapot:12", 0, 0, 9264, 2),
    ("tetra:6", 0, 0, 4096, 1),
    ("tree:11", 4095, 4095, 1, 7),
];

/// Other sizes, from the headers of the original programs.
const OTHER_SIZES: [(&str, u64, u64, u64, u64); 11] = [
    ("balls:2", 91, 0, 1, 3),
    ("balls:5", 66430, 0, 1, 3),
    ("gears:1", 0, 0, 147, 5),
    ("lattice:1", 8, 12, 0, 6),
    ("lattice:5", 216, 540, 0, 6),
    ("rings:3", 420, 420, 1, 3),
    ("shells:1", 361, 0, 0, 1),
    ("teapot:2", 0, 0, 244, 2),
    ("teapot:6", 0, 0, 2292, 2),
    ("tetra:1", 0, 0, 4, 1),
    ("jacks:3", 438, 219, 0, 1),
];

fn check(table: &[(&str, u64, u64, u64, u64)]) {
    for &(name, spheres, cones, polygons, lights) in table {
        let actual = counts(spec(name));
        let expected = ShapeCounts {
            spheres,
            cones,
            polygons,
            lights,
            triangles: actual.triangles,
        };
        assert_eq!(actual, expected, "{name}");
    }
}

#[test]
fn default_sizes_have_the_published_counts() {
    check(&PUBLISHED);
    let databases = CATALOGUE.iter().filter(|e| e.family == Family::Spd);
    let defaults: Vec<String> = databases
        .map(|e| format!("{}:{}", e.name, e.default_size))
        .collect();
    let published: Vec<&str> = PUBLISHED.iter().map(|row| row.0).collect();
    assert_eq!(defaults, published);
}

#[test]
fn other_sizes_have_the_counts_of_the_programs_heads() {
    check(&OTHER_SIZES);
}

/// "poly/patches" in the databases' table: polygons and patches at a resolution of 4, in thousands
/// where the table says so.
#[test]
fn tessellated_scenes_have_the_published_numbers_of_polygons() {
    let table = [
        ("balls:4", 1417, 1000),
        ("mount:6", 8960, 1),
        ("rings:7", 874, 1000),
        ("teapot:12", 9264, 1),
        ("tree:11", 852, 1000),
    ];
    for (name, published, unit) in table {
        let Spec { scene: entry, size } = spec(name);
        let mut builder = ShapeCounter::default();
        (entry.generate)(size, &mut Tessellate::new(4, &mut builder));
        let actual = builder.counts();
        assert_eq!((actual.polygons + unit / 2) / unit, published, "{name}");
        assert_eq!((actual.spheres, actual.cones), (0, 0), "{name}");
    }
}

#[test]
fn scenes_hold_what_is_counted() {
    for (name, ..) in PUBLISHED {
        let (scene, counts) = (scene(spec(name), 0).unwrap(), counts(spec(name)));
        assert_eq!(scene.spheres.len() as u64, counts.spheres, "{name}");
        assert_eq!(scene.cones.len() as u64, counts.cones, "{name}");
        assert_eq!(scene.triangles.len() as u64, counts.triangles, "{name}");
        assert_eq!(scene.lights.len() as u64, counts.lights, "{name}");
        assert_eq!(scene.max_depth, 4, "{name}");
    }
}

#[test]
fn the_smallest_size_of_each_scene_is_valid() {
    for entry in CATALOGUE {
        let size = u64::from(*entry.sizes.start());
        scene(Spec::sized(entry, size).unwrap(), 0)
            .unwrap_or_else(|e| panic!("{}: {e}", entry.name));
    }
}
