//! Files with vertices and no faces: clouds of points, drawn as spheres.

use phalanx::formats::{Loaded, Options, ReadOptions, read_bytes};
use phalanx::scene::Scene;

fn read(text: &str, options: ReadOptions) -> Result<Loaded, Vec<String>> {
    let ending = if text.starts_with("ply") { "ply" } else { "obj" };
    let options = Options {
        read: options,
        ..Options::default()
    };
    let read = read_bytes(ending, text.as_bytes(), &options).expect("a format");
    read.map_err(|errors| errors.into_iter().map(|error| error.message).collect())
}

/// A PLY file of points, each a row of three coordinates and three bytes of colour.
fn ply(points: &[String]) -> String {
    let count = points.len();
    let numbers = "property float x\nproperty float y\nproperty float z\n";
    let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let header =
        format!("ply\nformat ascii 1.0\nelement vertex {count}\n{numbers}{colors}end_header\n");
    header + &points.join("\n") + "\n"
}

/// Points of a grid of a spacing, coloured by their place.
fn grid(side: u32, spacing: f64) -> Vec<String> {
    let places = (0..side * side).map(|k| (k % side, k / side));
    let point = |(i, k): (u32, u32)| {
        let [x, y] = [i, k].map(|place| f64::from(place) * spacing);
        format!(
            "{x} {y} 1 {} {} 128",
            i * 255 / (side - 1),
            k * 255 / (side - 1)
        )
    };
    places.map(point).collect()
}

fn spheres(scene: &Scene) -> Vec<([f32; 3], f32)> {
    let rows = 0..scene.spheres.radius.len();
    let row = |k: usize| {
        (
            scene.spheres.center.get(k).to_array(),
            scene.spheres.radius[k],
        )
    };
    rows.map(row).collect()
}

#[test]
fn points_are_spheres_of_their_spacing_or_of_a_given_radius() {
    for threads in [1, 2, 7] {
        let options = ReadOptions {
            threads,
            ..ReadOptions::default()
        };
        let loaded = read(&ply(&grid(40, 0.25)), options).expect("a cloud");
        let spheres = spheres(&loaded.scene);
        assert_eq!(spheres.len(), 1600);
        assert_eq!(spheres[41], ([0.25, 0.25, 1.0], 0.375));
        let is_noted = loaded
            .notes
            .iter()
            .any(|note| note.contains("1600 points are spheres"));
        assert!(is_noted, "{:?}", loaded.notes);
    }
    let given = ReadOptions {
        point_radius: Some(0.5),
        ..ReadOptions::default()
    };
    for text in ["v 0 0 0\n", "v 0 0 0\nv 0 0 0\np 1 2\n"] {
        let loaded = read(text, given.clone()).expect("a cloud");
        assert_eq!(spheres(&loaded.scene)[0], ([0.0; 3], 0.5));
        let refused = read(text, ReadOptions::default()).expect_err("no spacing");
        assert!(refused[0].contains("no spacing"), "{refused:?}");
    }
    let face = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n", given).expect("a mesh");
    assert_eq!(
        (face.scene.triangles.len(), face.scene.prim_count()),
        (1, 1)
    );
    let is_noted = face
        .notes
        .iter()
        .any(|note| note.contains("--point-radius has no effect"));
    assert!(is_noted, "{:?}", face.notes);
}

#[test]
fn colours_are_within_half_a_level_of_the_files() {
    let points = grid(256, 1.0);
    let scene = read(&ply(&points), ReadOptions::default())
        .expect("a cloud")
        .scene;
    assert!(
        scene.materials.len() <= (1 << 10) + 1,
        "{}",
        scene.materials.len()
    );
    for (k, point) in points.iter().enumerate() {
        let bytes = point
            .split(' ')
            .skip(3)
            .map(|byte| byte.parse::<f32>().unwrap() / 255.0);
        let material = scene.materials.get(scene.spheres.material[k] as usize);
        for (share, linear) in bytes.zip(material.kd.to_array()) {
            // The curve of sRGB is within a few hundredths of a square root.
            assert!((linear.sqrt() - share).abs() < 0.065, "{point}: {linear}");
            assert!(share != 0.0 || linear == 0.0);
            assert!(share != 1.0 || linear == 1.0);
        }
    }
}

#[test]
fn points_that_are_not_finite_are_left_out_with_their_colours() {
    let mut points = grid(3, 1.0);
    points.insert(4, "nan 0 0 255 0 0".to_owned());
    points.insert(0, "1e30 0 0 255 0 0".to_owned());
    let loaded = read(&ply(&points), ReadOptions::default()).expect("a cloud");
    let clean = read(&ply(&grid(3, 1.0)), ReadOptions::default()).expect("a cloud");
    assert!(
        loaded.warnings[0].message.contains("2 vertices"),
        "{:?}",
        loaded.warnings
    );
    assert_eq!(spheres(&loaded.scene), spheres(&clean.scene));
    let colors = |scene: &Scene| {
        let rows = scene.spheres.material.iter();
        rows.map(|&row| scene.materials.get(row as usize).kd)
            .collect::<Vec<_>>()
    };
    assert_eq!(colors(&loaded.scene), colors(&clean.scene));
}

/// Nothing is out of reach of points that are all as far apart.
#[test]
fn points_of_enormous_units_are_a_cloud_and_those_without_a_place_are_not() {
    let text = "v 0 0 0\nv 1e30 0 0\nv nan 0 0\nv 0 1e30 0\nv 0 0 1e30\n";
    let loaded = read(text, ReadOptions::default()).expect("a cloud");
    let spheres = spheres(&loaded.scene);
    assert_eq!(spheres.len(), 4);
    assert!(spheres.iter().all(|&(_, radius)| radius == spheres[0].1));
}

#[test]
fn points_far_away_are_moved_and_count_against_the_limit() {
    let far = |k: u32| format!("v {} {} 0\n", 500_000.0 + 0.25 * f64::from(k), 4_000_000.5);
    let text: String = (0..64).map(far).collect();
    let loaded = read(&text, ReadOptions::default()).expect("a cloud");
    assert!(loaded.scene.origin != [0.0; 3]);
    assert_eq!(spheres(&loaded.scene)[3].1, 0.375);
    let small = ReadOptions {
        max_memory: Some(2000),
        ..ReadOptions::default()
    };
    let refused = read(&text, small).expect_err("too large");
    assert!(refused[0].contains("the file's points"), "{refused:?}");
}
