//! EXT_mesh_gpu_instancing: copies of a node's mesh.

use super::{File, messages};
use glam::{DVec3, Vec3};
use phalanx::formats::{Options, ReadOptions, read_bytes};
use phalanx::scene::Scene;
use serde_json::{Value, json};

fn copied(file: &mut File, attributes: Value) {
    file.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    file.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
}

/// The point (1, 0, 0) of the mesh, in each copy.
fn points(scene: &Scene) -> Vec<Vec3> {
    let columns = (0..scene.instances.len()).map(|k| scene.instances.world_columns(k));
    columns.map(|[x, _, _, t]| x + t).collect()
}

fn near(a: &[Vec3], b: &[Vec3]) {
    assert_eq!(a.len(), b.len(), "{a:?}");
    for (a, b) in a.iter().zip(b) {
        assert!((*a - *b).abs().max_element() < 1e-5, "{a} is not {b}");
    }
}

#[test]
fn copies_are_moved_turned_and_scaled_within_their_node() {
    let mut file = File::triangle();
    let turn = 0.5f32.sqrt();
    let moved = file.floats(3, &[0., 0., 0., 10., 0., 0., 20., 0., 0.]);
    let turned = file.floats(
        4,
        &[
            0.,
            0.,
            0.,
            1.,
            0.,
            0.,
            turn,
            turn,
            0.,
            0.,
            3. * turn,
            3. * turn,
        ],
    );
    let scaled = file.floats(3, &[1., 1., 1., 1., 1., 1., 2., 2., 2.]);
    copied(
        &mut file,
        json!({"TRANSLATION": moved, "ROTATION": turned, "SCALE": scaled, "_ID": 0}),
    );
    file.json["nodes"][0]["translation"] = json!([0, 0, 5]);
    let loaded = file.loaded();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    assert_eq!((scene.prim_count(), scene.visible_count()), (1, 3));
    let want = [[1., 0., 5.], [10., 1., 5.], [20., 2., 5.]].map(Vec3::from);
    near(&points(scene), &want);
}

#[test]
fn each_attribute_alone_and_quantized() {
    let mut file = File::triangle();
    let scaled = file.floats(3, &[2., 2., 2., 3., 3., 3.]);
    copied(&mut file, json!({"SCALE": scaled}));
    near(
        &points(&file.loaded().scene),
        &[Vec3::X * 2.0, Vec3::X * 3.0],
    );
    // A quarter turn about z in bytes, which are shares of 127 and of no unit length.
    for (normalized, kind) in [(true, 5120), (false, 5120)] {
        let mut file = File::triangle();
        let turns = file.accessor(&[0, 0, 90, 90, 0, 0, 0, 127], kind, 4, 2);
        file.json["accessors"][turns]["normalized"] = json!(normalized);
        copied(&mut file, json!({"ROTATION": turns}));
        near(&points(&file.loaded().scene), &[Vec3::Y, Vec3::X]);
    }
    // Attributes of other people alone: the mesh as it is.
    let mut file = File::triangle();
    copied(&mut file, json!({"_ID": 0}));
    assert_eq!(file.loaded().scene.visible_count(), 1);
}

#[test]
fn one_copy_none_and_unlike_counts() {
    let mut file = File::triangle();
    let one = file.floats(3, &[0., 3., 0.]);
    copied(&mut file, json!({"TRANSLATION": one}));
    let scene = file.loaded().scene;
    assert_eq!((scene.instances.len(), scene.visible_count()), (0, 1));
    assert_eq!(scene.triangles.corners(0)[0], Vec3::Y * 3.0);
    file.json["accessors"][one]["count"] = json!(0);
    let none = file.loaded();
    assert_eq!(none.scene.visible_count(), 0);
    assert!(messages(&none.warnings)[0].contains("no triangles"));
    let mut file = File::triangle();
    let (two, three) = (file.floats(3, &[0.; 6]), file.floats(3, &[1.; 9]));
    copied(&mut file, json!({"TRANSLATION": two, "SCALE": three}));
    assert_eq!(file.loaded().scene.visible_count(), 2);
    copied(&mut file, json!({"TRANSLATION": 99}));
    assert!(file.refused()[0].contains("there is no accessors[99]"));
}

#[test]
fn copies_of_several_nodes_join_and_take_the_origin() {
    let mut file = File::triangle();
    let moved = file.floats(3, &[0., 0., 0., 10., 0., 0.]);
    copied(&mut file, json!({"TRANSLATION": moved}));
    file.json["nodes"][0]["translation"] = json!([500_000.25, 0, 0]);
    file.node(json!({"mesh": 0, "translation": [500_001.25, 0, 0]}));
    let scene = file.loaded().scene;
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 3));
    let there = |k: usize| scene.file_position(scene.instances.world_columns(k)[3]);
    assert_eq!(there(1), DVec3::new(500_010.25, 0.0, 0.0));
    assert!(scene.is_moved());
}

#[test]
fn copies_that_show_more_than_can_be_numbered_are_refused_at_their_mesh() {
    let mut file = File::empty();
    let corners: Vec<f32> = (0..70_000)
        .flat_map(|k| [k as f32, (k % 2) as f32, 0.0])
        .collect();
    let positions = file.floats(3, &corners);
    file.mesh(json!({"attributes": {"POSITION": positions}, "mode": 5}));
    file.node(json!({"mesh": 0}));
    let moved: Vec<f32> = (0..70_000).flat_map(|k| [0.0, k as f32, 0.0]).collect();
    let moved = file.floats(3, &moved);
    copied(&mut file, json!({"TRANSLATION": moved}));
    let refused = file.refused();
    assert!(
        refused[0].starts_with("meshes[0]: ") && refused[0].contains("at most 2^32 - 2"),
        "{refused:?}"
    );
}

/// Copies of rows that the file lacks would cost nothing in the file.
#[test]
fn copies_are_bounded_by_the_file_and_by_memory() {
    let mut file = File::triangle();
    let zeros = file.add(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 60_000}),
    );
    copied(&mut file, json!({"TRANSLATION": zeros}));
    let node = file.json["nodes"][0].clone();
    let limited = Options {
        read: ReadOptions {
            max_memory: Some(10 << 20),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let refused = read_bytes("gltf", file.text().as_bytes(), &limited).expect("an ending");
    let refused = refused.map(|_| ()).expect_err("30 MB of copies");
    assert!(
        refused[0].message.contains("for 60000 copies of a mesh"),
        "{refused:?}"
    );
    file.json["nodes"] = json!(vec![node; 40]);
    let refused = file.refused();
    assert!(refused[0].contains("60000 more copies are too many for a file of this size"));
}
