//! Written files: they are read back as the same scene, as far as the format can represent it.

use super::{numbers, scene, spec};
use phalanx::formats::{Loaded, read_nff, read_test};
use phalanx::scene::{PrimKind, Scene};
use phalanx::standard::{CATALOGUE, FileFormat, SceneWriteError, write};
use std::io::{self, Write};
use std::path::Path;

/// Small scenes with every kind of shape between them.
const SMALL: [&str; 11] = [
    "balls:2",
    "gears:1",
    "jacks:2",
    "lattice:2",
    "mount:3",
    "rings:2",
    "shells:1",
    "sombrero:1",
    "teapot:3",
    "tetra:3",
    "tree:4",
];

fn written(name: &str, format: FileFormat, tessellate: Option<u32>) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(spec(name), format, tessellate, 0, &mut bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
    bytes
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).expect("text")
}

fn read_back(name: &str, loaded: Result<Loaded, Vec<phalanx::formats::Diagnostic>>) -> Scene {
    let loaded = loaded.unwrap_or_else(|errors| panic!("{name}: {errors:#?}"));
    assert!(loaded.warnings.is_empty(), "{name}: {:?}", loaded.warnings);
    assert!(loaded.notes.is_empty(), "{name}: {:?}", loaded.notes);
    loaded.scene
}

/// Every number of every primitive, by value (files write −0 as 0).
fn assert_same_shapes(name: &str, a: &Scene, b: &Scene) {
    assert_eq!(a.prim_count(), b.prim_count(), "{name}");
    for prim in 0..a.prim_count() {
        assert_eq!(
            numbers(a, prim),
            numbers(b, prim),
            "{name}, primitive {prim}"
        );
    }
}

/// As [`assert_same_shapes`], except for the last bits of normals, which `.test` normalises again.
pub fn assert_close_shapes(name: &str, a: &Scene, b: &Scene) {
    assert_eq!(a.prim_count(), b.prim_count(), "{name}");
    for prim in 0..a.prim_count() {
        let ((kind, coordinates, material), other) = (numbers(a, prim), numbers(b, prim));
        assert_eq!(
            (kind, &material),
            (other.0, &other.2),
            "{name}, primitive {prim}"
        );
        assert_eq!(coordinates.len(), other.1.len(), "{name}, primitive {prim}");
        for (k, (x, y)) in coordinates.iter().zip(&other.1).enumerate() {
            let same = if k < 9 { x == y } else { (x - y).abs() < 2e-7 };
            assert!(
                same,
                "{name}, primitive {prim}: {coordinates:?}, not {:?}",
                other.1
            );
        }
    }
}

pub fn assert_same_setting(name: &str, a: &Scene, b: &Scene) {
    assert_eq!((a.width, a.height), (b.width, b.height), "{name}");
    assert_eq!(a.view, b.view, "{name}");
    assert_eq!(a.encoding, b.encoding, "{name}");
    assert_eq!(a.max_depth, b.max_depth, "{name}");
    assert_eq!(a.lights.len(), b.lights.len(), "{name}");
    for i in 0..a.lights.len() {
        assert_eq!(a.lights.position.get(i), b.lights.position.get(i), "{name}");
        assert_eq!(a.lights.color.get(i), b.lights.color.get(i), "{name}");
    }
}

#[test]
fn nff_holds_the_databases_whole() {
    for name in SMALL {
        let file = text(written(name, FileFormat::Nff, None));
        let read = read_back(name, read_nff(&file));
        let ours = scene(name);
        assert_same_shapes(name, &ours, &read);
        assert_same_setting(name, &ours, &read);
        assert_eq!(ours.background, read.background, "{name}");
    }
}

#[test]
fn test_files_hold_spheres_triangles_and_surfaces() {
    for name in [
        "balls:2", "gears:1", "mount:3", "shells:1", "teapot:3", "tetra:3",
    ] {
        let file = text(written(name, FileFormat::Test, None));
        let read = read_back(name, read_test(&file));
        assert_close_shapes(name, &scene(name), &read);
        assert_same_setting(name, &scene(name), &read);
    }
}

#[test]
fn what_a_format_cannot_hold_is_refused_by_name() {
    let cases = [
        ("jacks", FileFormat::Test, "cones or cylinders"),
        ("jacks", FileFormat::Ply, "cones or cylinders"),
        ("balls:1", FileFormat::Ply, "spheres"),
    ];
    for (name, format, wanted) in cases {
        let mut bytes = Vec::new();
        let error = write(spec(name), format, None, 0, &mut bytes).unwrap_err();
        let SceneWriteError::CannotHold { shape, .. } = error else {
            panic!("{name}: {error}")
        };
        assert_eq!(shape, wanted);
        if format == FileFormat::Ply {
            assert!(bytes.is_empty(), "{name}: something was written");
        }
    }
}

#[test]
fn tessellated_scenes_fit_every_format() {
    for name in ["jacks:1", "rings:1", "tree:2", "balls:1"] {
        let file = text(written(name, FileFormat::Nff, Some(3)));
        let as_nff = read_back(name, read_nff(&file));
        let file = text(written(name, FileFormat::Test, Some(3)));
        let as_test = read_back(name, read_test(&file));
        assert_close_shapes(name, &as_nff, &as_test);
        let triangles = as_nff.triangles.len();
        assert_eq!(as_nff.prim_count(), triangles, "{name}");
        let ply = written(name, FileFormat::Ply, Some(3));
        assert!(ply.starts_with(b"ply\nformat binary_little_endian 1.0\nelement vertex "));
    }
}

/// Vertices of a tessellated cone lie on its ends, and their normals point away from its axis.
#[test]
fn tessellated_cones_face_outward() {
    let file = text(written("tree:1", FileFormat::Nff, Some(2)));
    let read = read_back("tree", read_nff(&file));
    let ours = scene("tree:1");
    let cone = ours.cones.get(0);
    // The trunk's sides follow the field's two triangles.
    for i in 2..2 + 16 {
        let corners = read.triangles.corners(i);
        let normals = read.triangles.corner_normals(i).expect("smooth");
        let [a, b, c] = corners.map(|v| v.as_dvec3());
        let face = (b - a).cross(c - a).normalize();
        for (corner, normal) in corners.into_iter().zip(normals) {
            assert!(
                face.dot(normal.as_dvec3()) > 0.5,
                "triangle {i} faces inward"
            );
            let end = if corner.z < 0.5 { cone.base_radius } else { cone.apex_radius };
            assert!((corner.truncate().length() - end).abs() < 1e-6, "{corner}");
        }
    }
}

/// Reads our own PLY files: positions, optional normals, lists with one-byte counts.
pub fn ply_triangles(bytes: &[u8]) -> (usize, Vec<Vec<[f32; 3]>>) {
    let end = bytes
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|l| l.strip_prefix(element));
        line.unwrap().trim().parse().unwrap()
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let stride = if header.contains("property float nx") { 24 } else { 12 };
    let float = |offset: usize| f32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap());
    let vertex = |k: usize| [0, 4, 8].map(|part| float(end + k * stride + part));
    let mut offset = end + vertices * stride;
    let polygons = (0..faces).map(|_| {
        let corners = usize::from(bytes[offset]);
        let index = |k: usize| {
            let offset = offset + 1 + k * 4;
            u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap()) as usize
        };
        let polygon = (0..corners).map(|k| vertex(index(k))).collect();
        offset += 1 + corners * 4;
        polygon
    });
    let polygons = polygons.collect();
    assert_eq!(offset, bytes.len(), "the file ends with its last face");
    (vertices, polygons)
}

#[test]
fn ply_holds_the_polygons() {
    for name in ["gears:1", "sombrero:1", "teapot:3", "tetra:3"] {
        let (_, polygons) = ply_triangles(&written(name, FileFormat::Ply, None));
        let ours = scene(name);
        let mut next = 0;
        for polygon in &polygons {
            for _ in 2..polygon.len() {
                let corners = ours.triangles.corners(next);
                for corner in corners {
                    let is_corner = polygon.iter().any(|p| glam::Vec3::from_array(*p) == corner);
                    assert!(is_corner, "{name}, triangle {next}");
                }
                next += 1;
            }
        }
        assert_eq!(next, ours.triangles.len(), "{name}");
    }
}

/// A disk that is full for just one write: the error must be kept.
struct Full {
    failed: bool,
}

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if std::mem::replace(&mut self.failed, true) {
            return Ok(bytes.len());
        }
        Err(io::Error::new(io::ErrorKind::StorageFull, "no room"))
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_an_error() {
    for format in [FileFormat::Nff, FileFormat::Ply, FileFormat::Test] {
        let mut out = Full { failed: false };
        let error = write(spec("mount:6"), format, Some(2), 0, &mut out).unwrap_err();
        assert!(
            matches!(error, SceneWriteError::Io(_)),
            "{format:?}: {error}"
        );
    }
}

#[test]
fn an_ending_names_a_format() {
    for (name, format) in [
        ("a.nff", Some(FileFormat::Nff)),
        ("a.PLY", Some(FileFormat::Ply)),
        ("b/a.test", Some(FileFormat::Test)),
        ("a.obj", None),
        ("nff", None),
    ] {
        assert_eq!(FileFormat::of(Path::new(name)), format, "{name}");
    }
}

#[test]
fn every_scene_can_be_written_tessellated_or_not() {
    for entry in CATALOGUE {
        let name = format!("{}:{}", entry.name, entry.sizes.start());
        for format in [FileFormat::Nff, FileFormat::Ply, FileFormat::Test] {
            assert!(!written(&name, format, Some(1)).is_empty(), "{name}");
        }
    }
}

/// A scene with mixed kinds keeps its order.
#[test]
fn kinds_stay_in_the_order_of_the_databases() {
    let tree = scene("tree:2");
    let kinds: Vec<PrimKind> = tree.prims.iter().map(|p| p.kind()).collect();
    assert_eq!(kinds[..2], [PrimKind::Triangle; 2]);
    for pair in kinds[2..].chunks(2) {
        assert_eq!(pair, [PrimKind::Cone, PrimKind::Sphere]);
    }
}
