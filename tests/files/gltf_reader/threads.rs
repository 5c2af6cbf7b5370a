//! Large files: the number of threads changes neither the scene nor what is said about the file.

use super::{File, messages};
use glam::Vec3;
use phalanx::cache::fingerprint;
use phalanx::formats::{Options, ReadOptions, read_bytes};
use serde_json::json;

const UINT: u32 = 5125;

/// Sides of a grid of more triangles than one thread bakes, and of a grid of few.
const LARGE: usize = 200;
const SMALL: usize = 60;

/// The file's positions of a grid, one of which is lost.
fn positions(side: usize, height: f32) -> Vec<[f32; 3]> {
    let places = (0..side * side).map(|k| [(k % side) as f32, (k / side) as f32, height]);
    let mut places: Vec<[f32; 3]> = places.collect();
    places[side * side / 2 + side / 2][2] = f32::NAN;
    places
}

/// Triangles of a grid, the last ones first, so that no vertex keeps its number.
fn triangles(side: usize) -> Vec<[u32; 3]> {
    let cells = (0..(side - 1) * side).filter(|k| k % side < side - 1).rev();
    let cut = |k: usize| {
        let [a, b, c, d] = [k, k + 1, k + side, k + side + 1].map(|k| k as u32);
        [[a, b, c], [d, c, b]]
    };
    cells.flat_map(cut).collect()
}

/// A grid with attributes some of which cannot be used.
fn grid(file: &mut File, side: usize, height: f32) -> serde_json::Value {
    let vertices = side * side;
    let place = file.floats(3, positions(side, height).as_flattened());
    let flat = |k: usize| {
        if k % 1009 == 7 { 0.0 } else { 0.25 + (k % 13) as f32 }
    };
    let normals: Vec<f32> = (0..vertices).flat_map(|k| [0.0, 0.0, flat(k)]).collect();
    let share = |k: usize| match k % 2003 {
        5 => f32::NAN,
        other => (other % 100) as f32 / 99.0,
    };
    let colors: Vec<f32> = (0..3 * vertices).map(share).collect();
    let corners = triangles(side);
    let indices: Vec<u8> = (corners.as_flattened().iter())
        .flat_map(|k| k.to_le_bytes())
        .collect();
    json!({
        "attributes": {
            "POSITION": place,
            "NORMAL": file.floats(3, &normals),
            "COLOR_0": file.floats(3, &colors),
        },
        "indices": file.accessor(&indices, UINT, 1, 3 * corners.len()),
    })
}

/// A large mesh, one of several primitives, one that two nodes show, and many small ones.
fn large_file() -> File {
    let mut file = File::empty();
    let alone = grid(&mut file, LARGE, 1.0);
    file.mesh(alone);
    let several = [2.0, 3.0, 4.0].map(|height| grid(&mut file, SMALL, height));
    file.add("meshes", json!({"primitives": several}));
    let shared = grid(&mut file, SMALL, 5.0);
    file.mesh(shared);
    for mesh in 0..3 {
        file.node(json!({"mesh": mesh, "name": format!("node {mesh}")}));
    }
    file.node(json!({"mesh": 2, "translation": [500.0, 0.0, 0.0]}));
    for height in 10..13 {
        let small = grid(&mut file, SMALL, height as f32);
        let mesh = file.mesh(small);
        file.node(json!({"mesh": mesh, "scale": [-1.0, 1.0, 1.0]}));
    }
    file
}

#[test]
fn threads_do_not_change_what_is_read() {
    let glb = large_file().glb();
    let read = |threads| {
        let options = Options {
            read: ReadOptions {
                threads,
                ..ReadOptions::default()
            },
            ..Options::default()
        };
        let loaded = read_bytes("glb", &glb, &options).expect("a known ending");
        loaded.unwrap_or_else(|errors| panic!("{errors:#?}"))
    };
    let one = read(1);
    let warnings = messages(&one.warnings);
    assert_eq!(
        warnings.len(),
        3 * 6,
        "triangles, normals, colours: {warnings:#?}"
    );
    for threads in [2, 3, 7, 16] {
        let several = read(threads);
        assert_eq!(messages(&several.warnings), warnings, "{threads} threads");
        let [a, b] = [&one.scene, &several.scene].map(fingerprint);
        assert_eq!(a, b, "{threads} threads");
    }
    // The triangles of the first mesh are those of the file, in its order.
    let places = positions(LARGE, 1.0);
    let expected = triangles(LARGE).into_iter();
    let expected = expected.map(|corners| corners.map(|k| Vec3::from_array(places[k as usize])));
    let expected = expected.filter(|corners| corners.iter().all(|corner| corner.is_finite()));
    for (triangle, expected) in expected.enumerate() {
        assert_eq!(
            one.scene.triangles.corners(triangle),
            expected,
            "{triangle}"
        );
    }
}

#[test]
fn the_first_wrong_index_is_reported_whatever_the_threads() {
    let mut file = File::empty();
    let mut grid = grid(&mut file, LARGE, 1.0);
    let mut corners = triangles(LARGE);
    let (last, middle) = (corners.len() - 1, corners.len() / 2);
    corners[middle][1] = 1_000_001;
    corners[last][0] = 1_000_002;
    let indices: Vec<u8> = (corners.as_flattened().iter())
        .flat_map(|k| k.to_le_bytes())
        .collect();
    grid["indices"] = json!(file.accessor(&indices, UINT, 1, 3 * corners.len()));
    file.mesh(grid);
    file.node(json!({"mesh": 0}));
    for threads in [1, 2, 16] {
        let options = Options {
            read: ReadOptions {
                threads,
                ..ReadOptions::default()
            },
            ..Options::default()
        };
        let read = read_bytes("glb", &file.glb(), &options).expect("a known ending");
        let errors = read.map(|_| "a scene").expect_err("refused");
        let expected =
            "meshes[0]: primitives[0]: its index 1000001 is not below its 40000 vertices";
        assert_eq!(messages(&errors), [expected]);
    }
}
