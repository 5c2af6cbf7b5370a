//! Meshes, coloured lights and the document's surfaces through every sink: the ingredients of the
//! modern scenes.

use super::files::{assert_close_shapes, assert_same_setting, ply_triangles};
use glam::{DVec3, Vec3, dvec3};
use phalanx::formats::{read_nff, read_test};
use phalanx::scene::Scene;
use phalanx::standard::{
    DocumentMaterial, MaterialDesc, MemoryBuilder, NffWriter, PlyWriter, SceneBuilder,
    ShapeCounter, StandardLight, StandardView, TestWriter,
};

fn square(z: f64) -> [DVec3; 4] {
    [
        dvec3(0.1, 0.0, z),
        dvec3(1.0, 0.0, z),
        dvec3(1.0, 1.0, z),
        dvec3(0.0, 1.0, z),
    ]
}

/// Two chunks of a mesh with a concave polygon between them.
fn pour(builder: &mut dyn SceneBuilder, patch: bool, material: &MaterialDesc) {
    builder.background(DVec3::ZERO);
    builder.view(&StandardView {
        from: dvec3(0.3, 0.1, 7.0),
        at: DVec3::ZERO,
        up: DVec3::Y,
        fovy: 37.123_456,
        width: 40,
        height: 30,
    });
    builder.light(&StandardLight::colored(
        dvec3(1.0, 2.0, 3.0),
        dvec3(0.9, 0.1, 0.5),
    ));
    builder.material(material);
    builder.mesh(&square(1.0), &[[0, 1, 2], [0, 2, 3]]);
    builder.polygon(&[
        DVec3::ZERO,
        DVec3::X * 4.0,
        dvec3(1.0, 1.0, 0.0),
        DVec3::Y * 4.0,
    ]);
    if patch {
        let normal = dvec3(0.0, 0.6, 0.8);
        builder.patch(&square(3.0).map(|point| (point, normal)));
    }
    builder.mesh(&square(2.0), &[[3, 2, 1], [1, 0, 3], [0, 1, 2]]);
}

fn grey() -> MaterialDesc {
    MaterialDesc::Document(DocumentMaterial {
        // NFF's ambient light is its level, one half here, of the diffuse.
        ka: dvec3(0.05, 0.15, 0.3),
        kd: dvec3(0.1, 0.3, 0.6),
        ks: DVec3::splat(0.25),
        kt: DVec3::splat(0.125),
        shininess: 12.0,
        ior: 1.25,
        ..DocumentMaterial::default()
    })
}

fn scene(patch: bool, material: &MaterialDesc) -> Scene {
    let mut builder = MemoryBuilder::default();
    pour(&mut builder, patch, material);
    let mut scene = builder.finish();
    // As NFF has it, and as the .test file below is told.
    scene.max_depth = 4;
    scene.validate().unwrap();
    scene
}

fn ply(patch: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut builder = PlyWriter::new(&mut bytes);
    for _ in 0..3 {
        pour(&mut builder, patch, &grey());
        builder.end_pass();
    }
    builder.finish().unwrap();
    bytes
}

#[test]
fn a_mesh_is_counted_by_its_triangles() {
    let mut builder = ShapeCounter::default();
    pour(&mut builder, true, &grey());
    let counts = builder.counts();
    assert_eq!((counts.triangles, counts.polygons), (2 + 2 + 2 + 3, 2));
}

#[test]
fn nff_and_test_files_read_back_the_same() {
    for patch in [false, true] {
        let ours = scene(patch, &grey());
        let (mut nff, mut test) = (Vec::new(), Vec::new());
        let mut builder = NffWriter::new(&mut nff);
        pour(&mut builder, patch, &grey());
        assert_eq!(builder.finish().unwrap().len(), 1, "surfaces are reduced");
        let mut builder = TestWriter::new(&mut test, 4);
        pour(&mut builder, patch, &grey());
        assert!(builder.finish().unwrap().is_empty());
        let read = read_nff(std::str::from_utf8(&nff).unwrap()).unwrap().scene;
        assert_close_shapes("nff", &ours, &read);
        assert_same_setting("nff", &ours, &read);
        let read = read_test(std::str::from_utf8(&test).unwrap())
            .unwrap()
            .scene;
        assert_close_shapes("test", &ours, &read);
        assert_same_setting("test", &ours, &read);
    }
}

#[test]
fn colours_that_nff_lacks_become_their_means() {
    let material = MaterialDesc::Document(DocumentMaterial {
        ks: dvec3(0.0, 0.3, 0.6),
        kt: dvec3(0.9, 0.0, 0.0),
        ..DocumentMaterial::default()
    });
    let mut nff = Vec::new();
    let mut builder = NffWriter::new(&mut nff);
    pour(&mut builder, false, &material);
    builder.finish().unwrap();
    let read = read_nff(std::str::from_utf8(&nff).unwrap()).unwrap().scene;
    let surface = read.materials.get(0);
    assert!(
        surface.ks.abs_diff_eq(Vec3::splat(0.3), 1e-6),
        "{surface:?}"
    );
    assert!(
        surface.kt.abs_diff_eq(Vec3::splat(0.3), 1e-6),
        "{surface:?}"
    );
}

#[test]
fn ply_shares_vertices_unless_there_are_normals() {
    for patch in [false, true] {
        let (vertices, polygons) = ply_triangles(&ply(patch));
        let parted = 2 * 3 + 4 + 4 + 3 * 3;
        assert_eq!(vertices, if patch { parted } else { 4 + 4 + 4 });
        let point = |p: &DVec3| p.as_vec3().to_array();
        let [low, high] = [1.0, 2.0].map(|z| square(z).map(|p| point(&p)));
        assert_eq!(polygons[0], [low[0], low[1], low[2]]);
        assert_eq!(polygons[1], [low[0], low[2], low[3]]);
        assert_eq!(polygons[2].len(), 4);
        let last = polygons.len() - 3;
        assert_eq!(polygons[last], [high[3], high[2], high[1]]);
        assert_eq!(polygons[last + 2], [high[0], high[1], high[2]]);
    }
}

/// Concave: judged by its first corner alone, it would face the other way.
#[test]
fn flat_faces_of_a_ply_with_normals_stand_upright() {
    let bytes = ply(true);
    let end = bytes
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    let float = |offset: usize| f32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap());
    let normal = |k: usize| [12, 16, 20].map(|part| float(end + k * 24 + part));
    for flat in 0..10 {
        assert_eq!(normal(flat), [0.0, 0.0, 1.0], "vertex {flat}");
    }
    assert_eq!(normal(10), [0.0, 0.6, 0.8]);
    assert_eq!(
        normal(14),
        [0.0, 0.0, -1.0],
        "the second mesh's first triangle faces down"
    );
}

#[test]
fn polygons_of_more_than_a_bytes_corners_are_counted_in_words() {
    let corner = |k: u32| dvec3(f64::from(k), f64::from(k * k), 0.0);
    let many: Vec<DVec3> = (0..300).map(corner).collect();
    let mut bytes = Vec::new();
    let mut builder = PlyWriter::new(&mut bytes);
    for _ in 0..3 {
        builder.polygon(&many);
        builder.end_pass();
    }
    builder.finish().unwrap();
    let header = b"property list uint int vertex_indices";
    assert!(bytes.windows(header.len()).any(|w| w == header));
    let list = &bytes[bytes.len() - 4 * 301..];
    assert_eq!(list[..4], 300u32.to_le_bytes());
    assert_eq!(list[4 * 300..], 299u32.to_le_bytes());
}
