//! Normals that `--smooth` makes, for meshes of all formats: the same in each.

use super::File;
use glam::Vec3;
use phalanx::formats::{Options, ReadOptions, read_bytes};
use phalanx::scene::Scene;
use serde_json::json;

/// Two triangles on either side of the edge from the origin to (0, 1, 0), bent by `atan(rise)`.
const LEFT: [f32; 9] = [0., 0., 0., 0., 1., 0., -1., 0., 0.];
const RIGHT: [f32; 9] = [0., 1., 0., 0., 0., 0., 1., 0., 0.25];

fn smoothed(ending: &str, bytes: &[u8]) -> Scene {
    let options = Options {
        read: ReadOptions {
            smooth: Some(30.0),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let read = read_bytes(ending, bytes, &options).expect("a format");
    read.unwrap_or_else(|errors| panic!("{errors:#?}")).scene
}

/// The normals of a bend, by symmetry: those of the facets where only one is, their mean between.
fn assert_bent(scene: &Scene, what: &str) {
    let right = Vec3::new(-0.25, 0.0, 1.0).normalize();
    let mean = (Vec3::Z + right).normalize();
    for (k, facet) in [(0, Vec3::Z), (1, right)] {
        let normals = scene.triangles.corner_normals(k).expect(what);
        let corners = scene.triangles.corners(k);
        for (corner, normal) in corners.iter().zip(normals) {
            let expected = if corner.x == 0.0 { mean } else { facet };
            // The two weigh what their edges weigh, nearly the same.
            assert!((normal - expected).length() < 0.01, "{what} {k}: {normal}");
        }
    }
}

#[test]
fn all_formats_make_the_same_normals() {
    let corners: Vec<&[f32]> = LEFT.chunks(3).chain(RIGHT.chunks(3)).collect();
    let rows = |prefix: &str| {
        let row = |c: &&[f32]| format!("{prefix}{} {} {}\n", c[0], c[1], c[2]);
        corners.iter().map(row).collect::<Vec<String>>()
    };
    let obj = rows("v ").concat() + "f 1 2 3\no other\nusemtl m\nf 4 5 6\n";
    let header = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n";
    let faces = "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    let ply = format!("{header}{faces}{}3 0 1 2\n3 3 4 5\n", rows("").concat());
    let facet = |rows: &[String]| {
        format!(
            "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
            rows.concat()
        )
    };
    let rows = rows("vertex ");
    let stl = format!(
        "solid a\n{}{}endsolid a\n",
        facet(&rows[..3]),
        facet(&rows[3..])
    );
    let mut file = two_primitives();
    file.node(json!({"mesh": 0}));
    let all = [
        ("obj", obj),
        ("ply", ply),
        ("stl", stl),
        ("gltf", file.text()),
    ];
    for (ending, text) in all {
        assert_bent(&smoothed(ending, text.as_bytes()), ending);
    }
}

/// A mesh of two primitives, one of each side of the bend.
fn two_primitives() -> File {
    let mut file = File::empty();
    let sides = [LEFT, RIGHT].map(|side| {
        let positions = file.floats(3, &side);
        let material = file.add("materials", json!({"doubleSided": true}));
        json!({"attributes": {"POSITION": positions}, "material": material})
    });
    file.add("meshes", json!({"primitives": sides}));
    file
}

#[test]
fn primitives_of_a_mesh_are_joined_and_nodes_are_apart() {
    let mut file = two_primitives();
    for offset in 0..3 {
        file.node(json!({"mesh": 0, "translation": [3 * offset, 0, 0]}));
    }
    let copies = smoothed("gltf", file.text().as_bytes());
    let made = copies.triangles.normals.len();
    assert!(made > 0 && made == copies.triangles.len());
    assert_bent(&copies, "copies");
    let mut file = File::empty();
    for side in [LEFT, RIGHT] {
        let positions = file.floats(3, &side);
        let mesh = file.mesh(json!({"attributes": {"POSITION": positions}}));
        file.node(json!({ "mesh": mesh }));
    }
    let apart = smoothed("gltf", file.text().as_bytes());
    assert!(apart.triangles.normals.is_empty());
}
