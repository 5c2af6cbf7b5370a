//! Meshes far from the origin of their coordinates.

use super::triangles;
use glam::{DVec3, Vec3};
use phalanx::formats::{AddedLight, Loaded, Options, Origin, Overrides, ReadOptions, read_bytes};
use phalanx::scene::FileView;

/// A triangle at map coordinates, in decimals beyond single precision.
const FAR: [[f64; 3]; 3] = [
    [499_999.9, 8.1, -4_012_344.3],
    [500_001.2, 8.0, -4_012_344.0],
    [500_000.0, 9.1, -4_012_343.7],
];

/// The same point minus the automatically chosen origin.
const ORIGIN: [f64; 3] = [500_000.5, 0.0, -4_012_344.0];

/// The expected result: coordinates minus the origin in double precision, rounded once.
fn moved(corners: [[f64; 3]; 3], origin: [f64; 3]) -> Vec<[[f32; 3]; 3]> {
    let position = |c: [f64; 3]| (DVec3::from(c) - DVec3::from(origin)).as_vec3().to_array();
    vec![corners.map(position)]
}

fn read_at(ending: &str, bytes: &[u8], origin: Origin) -> Loaded {
    let options = Options {
        read: ReadOptions {
            origin,
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let read = read_bytes(ending, bytes, &options).expect("a known ending");
    read.unwrap_or_else(|errors| panic!("{errors:#?}"))
}

fn obj(corners: [[f64; 3]; 3]) -> Vec<u8> {
    let line = |[x, y, z]: [f64; 3]| format!("v {x} {y} {z}\n");
    format!("{}f 1 2 3\n", corners.map(line).concat()).into_bytes()
}

fn ply(kind: &str, rows: &[u8]) -> Vec<u8> {
    let encoding = if kind == "ascii" { "ascii" } else { "binary_little_endian" };
    let kind = if kind == "ascii" { "float" } else { kind };
    let header = format!(
        "ply\nformat {encoding} 1.0\nelement vertex 3\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n\
         element face 1\nproperty list uchar uchar vertex_indices\nend_header\n"
    );
    let faces: &[u8] = if encoding == "ascii" { b"3 0 1 2\n" } else { &[3, 0, 1, 2] };
    [header.as_bytes(), rows, faces].concat()
}

fn binary_stl(corners: [[f64; 3]; 3]) -> Vec<u8> {
    let mut file = vec![0; 80];
    file.extend(1u32.to_le_bytes());
    file.extend([0; 12]);
    let numbers = corners.as_flattened().iter();
    file.extend(numbers.flat_map(|&c| (c as f32).to_le_bytes()));
    file.extend([0; 2]);
    file
}

fn bytes_of<const N: usize>(corners: [[f64; 3]; 3], bytes: impl Fn(f64) -> [u8; N]) -> Vec<u8> {
    corners
        .as_flattened()
        .iter()
        .flat_map(|&c| bytes(c))
        .collect()
}

/// Files with coordinates beyond single precision.
fn wide_files(corners: [[f64; 3]; 3]) -> Vec<(&'static str, Vec<u8>)> {
    let row = |[x, y, z]: [f64; 3]| format!("{x} {y} {z}\n");
    let vertex = |c: [f64; 3]| format!("vertex {}", row(c));
    let stl = corners.map(vertex).concat();
    let stl = format!("solid\nfacet normal 0 0 1\nouter loop\n{stl}endloop\nendfacet\nendsolid\n");
    vec![
        ("obj", obj(corners)),
        ("ply", ply("ascii", corners.map(row).concat().as_bytes())),
        ("ply", ply("double", &bytes_of(corners, f64::to_le_bytes))),
        ("stl", stl.into_bytes()),
    ]
}

#[test]
fn coordinates_are_taken_from_the_origin_before_they_are_rounded() {
    for (ending, bytes) in wide_files(FAR) {
        let loaded = super::read(ending, &bytes);
        assert_eq!(loaded.scene.origin, ORIGIN, "{ending}");
        assert_eq!(triangles(&loaded.scene), moved(FAR, ORIGIN), "{ending}");
        let note = &loaded.notes[0];
        assert!(
            note.contains("moved to a local origin: 500000.5, 0, -4012344"),
            "{note}"
        );
    }
}

#[test]
fn the_file_keeps_its_origin_where_that_is_asked_for_or_near() {
    for (ending, bytes) in wide_files(FAR) {
        let scene = read_at(ending, &bytes, Origin::File).scene;
        assert_eq!(scene.origin, [0.0; 3]);
        let rounded = moved(FAR, [0.0; 3]);
        assert_eq!(triangles(&scene), rounded, "{ending}");
    }
    let near = [[9.9, 0.1, 0.0], [10.3, 0.1, 0.0], [9.9, 1.7, 0.0]];
    for (ending, bytes) in wide_files(near) {
        let loaded = super::read(ending, &bytes);
        assert_eq!(loaded.scene.origin, [0.0; 3]);
        assert_eq!(triangles(&loaded.scene), moved(near, [0.0; 3]), "{ending}");
    }
}

#[test]
fn an_origin_that_is_asked_for_is_taken() {
    let position = [499_990.1, 7.0, -4e6];
    for (ending, bytes) in wide_files(FAR) {
        let scene = read_at(ending, &bytes, Origin::At(position)).scene;
        assert_eq!(scene.origin, position);
        assert_eq!(triangles(&scene), moved(FAR, position), "{ending}");
    }
}

/// 32-bit integers exceed single precision, too.
#[test]
fn whole_numbers_are_taken_from_the_origin_before_they_are_rounded() {
    let corners = [
        [100_000_001.0, 1.0, 0.0],
        [100_000_011.0, 1.0, 0.0],
        [100_000_001.0, 9.0, 3.0],
    ];
    let scene = super::read(
        "ply",
        &ply("int", &bytes_of(corners, |c| (c as i32).to_le_bytes())),
    )
    .scene;
    assert_eq!(triangles(&scene), moved(corners, scene.origin));
    assert!(scene.origin[0] > 99_999_000.0, "{:?}", scene.origin);
}

fn single_files(corners: [[f64; 3]; 3]) -> [(&'static str, Vec<u8>); 2] {
    let float = |c: f64| (c as f32).to_le_bytes();
    [
        ("ply", ply("float", &bytes_of(corners, float))),
        ("stl", binary_stl(corners)),
    ]
}

#[test]
fn single_precision_moves_where_no_difference_is_rounded() {
    let corners = FAR.map(|corner| corner.map(|c| f64::from(c as f32)));
    for (ending, bytes) in single_files(corners) {
        let scene = super::read(ending, &bytes).scene;
        assert!(scene.is_moved());
        assert_eq!(triangles(&scene), moved(corners, scene.origin), "{ending}");
        for (corner, file) in triangles(&scene)[0].into_iter().zip(corners) {
            assert_eq!(
                scene.file_position(corner.into()).to_array(),
                file,
                "every bit"
            );
        }
    }
}

#[test]
fn single_precision_stays_where_a_difference_would_be_rounded() {
    let corners = FAR.map(|corner| corner.map(|c| f64::from(c as f32)));
    for (ending, bytes) in single_files(corners) {
        let loaded = read_at(ending, &bytes, Origin::At([499_990.1, 0.0, 0.0]));
        assert_eq!(loaded.scene.origin, [0.0; 3]);
        assert_eq!(
            triangles(&loaded.scene),
            moved(corners, [0.0; 3]),
            "{ending}"
        );
        let note = &loaded.notes[0];
        assert!(note.contains("moving them would round them"), "{note}");
        let exact = read_at(ending, &bytes, Origin::At([499_990.0, 0.0, 0.0])).scene;
        assert_eq!(triangles(&exact), moved(corners, exact.origin), "{ending}");
        assert!(exact.is_moved());
    }
}

/// In single precision alone it would collapse.
#[test]
fn a_small_thing_very_far_away_is_found_in_steps() {
    let corners = [
        [1e12 + 0.125, 0.0, 0.0],
        [1e12 + 1.125, 0.5, 0.0],
        [1e12 + 0.125, 1.0, 0.25],
    ];
    let scene = super::read("obj", &obj(corners)).scene;
    assert_eq!(triangles(&scene), moved(corners, scene.origin));
    let far = triangles(&scene)[0]
        .as_flattened()
        .iter()
        .fold(0.0f32, |most, c| most.max(c.abs()));
    assert!(far < 16.0, "{far} with the origin at {:?}", scene.origin);
}

#[test]
fn vertices_that_no_face_uses_do_not_count() {
    let text = [&obj(FAR)[..], b"v 0.1 0 0\nv 9e9 0 0\n"].concat();
    let scene = super::read("obj", &text).scene;
    assert_eq!((scene.origin, scene.triangles.vertices.len()), (ORIGIN, 5));
    let mut corners = FAR.map(|corner| corner.map(|c| f64::from(c as f32)));
    corners[0][0] = 500_000.0;
    let single = single_files(corners)[0].1.clone();
    let text = String::from_utf8_lossy(&single).replace("vertex 3", "vertex 4");
    let header = text.find("end_header\n").unwrap() + 11;
    let mut file = text.as_bytes()[..header].to_vec();
    file.extend_from_slice(&single[header..single.len() - 4]);
    file.extend([0.1f32, 0.0, 0.0].iter().flat_map(|c| c.to_le_bytes()));
    file.extend([3, 0, 1, 2]);
    let scene = super::read("ply", &file).scene;
    assert!(
        scene.is_moved(),
        "0.1 cannot be moved exactly, but need not be"
    );
}

#[test]
fn what_is_given_is_in_the_files_coordinates() {
    let options = Options {
        look: Overrides {
            view: Some(FileView {
                eye: DVec3::new(500_001.6, 8.25, -4_012_340.0),
                center: DVec3::new(500_000.6, 8.25, -4_012_344.0),
                up: Vec3::Y,
                fovy: 40.0,
                ortho: None,
            }),
            lights: vec![AddedLight::Point {
                position: DVec3::new(500_003.7, 12.0, -4_012_344.0),
                color: Vec3::ONE,
            }],
            ..Overrides::default()
        },
        ..Options::default()
    };
    let scene = read_bytes("obj", &obj(FAR), &options)
        .unwrap()
        .unwrap()
        .scene;
    assert_eq!(scene.origin, ORIGIN);
    let x = |c: f64| (c - ORIGIN[0]) as f32;
    assert_eq!(scene.view.eye, Vec3::new(x(500_001.6), 8.25, 4.0));
    assert_eq!(scene.view.center, Vec3::new(x(500_000.6), 8.25, 0.0));
    assert_eq!(
        scene.lights.position.get(0),
        Vec3::new(x(500_003.7), 12.0, 0.0)
    );
}

#[test]
fn neither_threads_nor_the_order_of_faces_move_the_origin_elsewhere() {
    let mut lines: Vec<String> = Vec::new();
    let mut faces: Vec<String> = Vec::new();
    for k in 0..900 {
        let (x, z) = (f64::from(k % 30) * 1.1, f64::from(k / 30) * 0.9);
        lines.push(format!("v {} {} {}", 40_000.3 + x, 2.0, z - 70_000.7));
        if k > 1 {
            faces.push(format!("f {} {} {}", k - 1, k, k + 1));
        }
    }
    let read = |faces: &[String], threads: usize| {
        let text = format!("{}\n{}\n", lines.join("\n"), faces.join("\n"));
        let options = Options {
            read: ReadOptions {
                threads,
                ..ReadOptions::default()
            },
            ..Options::default()
        };
        read_bytes("obj", text.as_bytes(), &options)
            .unwrap()
            .unwrap()
            .scene
    };
    let one = read(&faces, 1);
    assert!(one.is_moved());
    assert_eq!(read(&faces, 3).origin, one.origin);
    faces.reverse();
    assert_eq!(read(&faces, 2).origin, one.origin);
}
