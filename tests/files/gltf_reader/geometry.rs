//! Positions of triangles.

use super::{File, messages};
use glam::Vec3;
use phalanx::formats::{Options, read_bytes};
use phalanx::scene::Scene;
use serde_json::json;

/// The vertices of every stored triangle. In the file's coordinates.
fn triangles(scene: &Scene) -> Vec<[Vec3; 3]> {
    let there = |corner| scene.file_position(corner).as_vec3();
    (0..scene.triangles.len())
        .map(|i| scene.triangles.corners(i).map(there))
        .collect()
}

const UNIT: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

#[test]
fn a_triangle_without_indices() {
    let loaded = File::triangle().loaded();
    assert_eq!(triangles(&loaded.scene), [UNIT]);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(loaded.notes.len(), 2, "a camera and a light were made up");
}

/// Five points in a fan around the first, which are a strip as well.
fn five(mode: u32, indices: Option<&[u16]>) -> Vec<[f32; 3]> {
    let mut file = File::empty();
    let x: Vec<f32> = (0..5)
        .flat_map(|k| [k as f32, (k * k) as f32, 0.0])
        .collect();
    let positions = file.floats(3, &x);
    let mut primitive = json!({"attributes": {"POSITION": positions}, "mode": mode});
    if let Some(indices) = indices {
        primitive["indices"] = json!(file.indices(indices));
    }
    file.mesh(primitive);
    file.node(json!({"mesh": 0}));
    let scene = file.loaded().scene;
    triangles(&scene)
        .into_iter()
        .map(|t| t.map(|corner| corner.x))
        .collect()
}

#[test]
fn triangles_strips_and_fans() {
    assert_eq!(
        five(4, None),
        [[0., 1., 2.]],
        "the last two are no triangle"
    );
    assert_eq!(
        five(4, Some(&[4, 3, 2, 1, 0, 3])),
        [[4., 3., 2.], [1., 0., 3.]]
    );
    assert_eq!(five(5, None), [[0., 1., 2.], [1., 3., 2.], [2., 3., 4.]]);
    assert_eq!(five(6, None), [[1., 2., 0.], [2., 3., 0.], [3., 4., 0.]]);
    assert_eq!(five(6, Some(&[2, 0, 1])), [[0., 1., 2.]]);
}

#[test]
fn points_and_lines_are_left_out_with_a_warning() {
    let mut file = File::triangle();
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(1);
    let loaded = file.loaded();
    assert_eq!(loaded.scene.prim_count(), 0);
    let warnings = messages(&loaded.warnings);
    assert!(warnings[0].contains("no triangles"), "{warnings:?}");
    assert!(warnings[1].contains("points or lines"), "{warnings:?}");
}

/// A cloud is drawn or refused, and no empty picture.
#[test]
fn points_alone_are_refused() {
    let mut file = File::triangle();
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(0);
    let refused = read_bytes("gltf", file.text().as_bytes(), &Options::default());
    let diagnostics = refused.expect("a format").expect_err("no points");
    assert!(
        diagnostics[0].message.contains("only points"),
        "{diagnostics:?}"
    );
}

/// The x coordinates of a triangle with positions stored as these bytes.
fn stored(bytes: &[u8], kind: u32, normalized: bool, stride: Option<usize>) -> Vec<f32> {
    let mut file = File::empty();
    let positions = file.accessor(bytes, kind, 3, 3);
    file.json["accessors"][positions]["normalized"] = json!(normalized);
    if let Some(stride) = stride {
        file.json["bufferViews"][0]["byteStride"] = json!(stride);
    }
    file.mesh(json!({"attributes": {"POSITION": positions}}));
    file.node(json!({"mesh": 0}));
    let corners = triangles(&file.loaded().scene)[0];
    corners
        .into_iter()
        .flat_map(|corner| corner.to_array())
        .collect()
}

#[test]
fn all_component_types() {
    let bytes = [0u8, 1, 2, 127, 128, 255, 3, 4, 5];
    let signed = bytes.map(|b| f32::from(b as i8));
    assert_eq!(stored(&bytes, 5121, false, None), bytes.map(f32::from));
    assert_eq!(stored(&bytes, 5120, false, None), signed);
    assert_eq!(
        stored(&bytes, 5121, true, None),
        bytes.map(|b| f32::from(b) / 255.0)
    );
    assert_eq!(
        stored(&bytes, 5120, true, None),
        signed.map(|b| (b / 127.0).max(-1.0))
    );
    let words = [0u16, 1, 2, 32_767, 32_768, 65_535, 3, 4, 5];
    let two: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    assert_eq!(stored(&two, 5123, false, None), words.map(f32::from));
    assert_eq!(
        stored(&two, 5122, false, None),
        words.map(|w| f32::from(w as i16))
    );
    let four: Vec<u8> = words
        .iter()
        .flat_map(|&w| u32::from(w).to_le_bytes())
        .collect();
    assert_eq!(stored(&four, 5125, false, None), words.map(f32::from));
    // Rows of three bytes, four apart; the last one ends with the buffer.
    let apart = [1u8, 2, 3, 99, 4, 5, 6, 99, 7, 8, 9];
    let close = [1, 2, 3, 4, 5, 6, 7, 8, 9u8];
    assert_eq!(stored(&apart, 5121, false, Some(4)), close.map(f32::from));
}

#[test]
fn sparse_rows_replace_others_or_zeros() {
    for base in [true, false] {
        let mut file = File::empty();
        let positions = file.floats(3, &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        let indices = file.view(&[1, 2]);
        let values: Vec<u8> = [5f32, 6., 7., 8., 9., 10.]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let values = file.view(&values);
        let accessor = &mut file.json["accessors"][positions];
        accessor["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": 5121},
            "values": {"bufferView": values}
        });
        if !base {
            accessor.as_object_mut().unwrap().remove("bufferView");
        }
        file.mesh(json!({"attributes": {"POSITION": positions}}));
        file.node(json!({"mesh": 0}));
        let want = [Vec3::ZERO, Vec3::new(5., 6., 7.), Vec3::new(8., 9., 10.)];
        assert_eq!(triangles(&file.loaded().scene), [want], "base {base}");
    }
}

#[test]
fn transforms_are_taken_down_the_hierarchy() {
    let mut file = File::triangle();
    file.json["nodes"] = json!([
        {"mesh": 0, "translation": [0, 0, 1]},
        {"children": [0], "scale": [2, 3, 4]},
        // A quarter turn about z.
        {"children": [1], "rotation": [0, 0, 0.5f64.sqrt(), 0.5f64.sqrt()]},
        {"children": [2], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1]},
    ]);
    let got = triangles(&file.loaded().scene)[0];
    let want = [
        Vec3::new(10., 20., 34.),
        Vec3::new(10., 22., 34.),
        Vec3::new(7., 20., 34.),
    ];
    for (got, want) in got.into_iter().zip(want) {
        assert!((got - want).abs().max_element() < 1e-5, "{got} {want}");
    }
}

#[test]
fn a_mirroring_node_turns_its_triangles_round_and_keeps_normals_outside() {
    let mut file = File::triangle();
    let normals = file.floats(3, &[0., 0., 1., 0., 0., 2., 0., 0., 0.5]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    file.json["nodes"] = json!([{"mesh": 0, "scale": [-2, 1, 1]}]);
    let scene = file.loaded().scene;
    assert_eq!(
        triangles(&scene),
        [[Vec3::ZERO, Vec3::Y, Vec3::new(-2., 0., 0.)]]
    );
    assert_eq!(scene.triangles.corner_normals(0), Some([Vec3::Z; 3]));
}

#[test]
fn normals_without_a_direction_leave_the_triangle_flat() {
    for bad in [0.0, f32::NAN, f32::INFINITY] {
        let mut file = File::triangle();
        let normals = file.floats(3, &[0., 0., 1., 0., 0., 1., 0., 0., bad]);
        file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
        for nodes in 1..3 {
            let loaded = file.loaded();
            assert_eq!(loaded.scene.triangles.corner_normals(0), None, "{bad}");
            let warnings = messages(&loaded.warnings);
            assert_eq!(warnings.len(), 1, "{bad}, {nodes} nodes: {warnings:?}");
            assert!(warnings[0].contains("one normal is zero or not finite"));
            file.node(json!({"mesh": 0}));
        }
    }
}

#[test]
fn a_mesh_shown_twice_is_stored_once() {
    let mut file = File::triangle();
    file.node(json!({"mesh": 0, "translation": [5, 0, 0]}));
    file.node(json!({"mesh": 0, "scale": [-1, 1, 1]}));
    let scene = file.loaded().scene;
    assert_eq!((scene.prim_count(), scene.visible_count()), (1, 3));
    assert_eq!(scene.instances.world_columns(1)[3], Vec3::new(5., 0., 0.));
    assert_eq!(scene.bounds().hi.x.round(), 6.0);
}

#[test]
fn what_cannot_be_instanced_is_baked() {
    // Made flat by its node: baked, with a warning; the other one stays an instance.
    let mut file = File::triangle();
    file.node(json!({"mesh": 0, "scale": [1, 0, 1]}));
    let loaded = file.loaded();
    assert_eq!(
        (loaded.scene.prim_count(), loaded.scene.visible_count()),
        (2, 2)
    );
    assert!(messages(&loaded.warnings)[0].contains("flat"));
    // Too small for single precision where it is stored.
    let mut file = File::empty();
    let positions = file.floats(3, &[0., 0., 0., 1e-12, 0., 0., 0., 1e-12, 0.]);
    file.mesh(json!({"attributes": {"POSITION": positions}}));
    for _ in 0..2 {
        file.node(json!({"mesh": 0, "scale": [1e12, 1e12, 1e12]}));
    }
    let scene = file.loaded().scene;
    assert_eq!((scene.prim_count(), scene.instances.len()), (2, 0));
}

#[test]
fn only_vertices_that_are_used_are_kept() {
    let mut file = File::empty();
    let mut many: Vec<f32> = (0..3000).map(|k| k as f32).collect();
    many[0] = f32::NAN;
    let positions = file.floats(3, &many);
    let indices = file.indices(&[900, 7, 30, 30, 7, 999]);
    file.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    file.node(json!({"mesh": 0}));
    let scene = file.loaded().scene;
    assert_eq!(scene.triangles.vertices.len(), 4);
    assert_eq!(triangles(&scene)[1][2], Vec3::new(2997., 2998., 2999.));
}

#[test]
fn a_hierarchy_of_20000_nodes_is_walked() {
    const DEEP: usize = 20_000;
    let mut file = File::triangle();
    let mut nodes = vec![json!({"mesh": 0, "translation": [0.5, 0, 0]})];
    nodes.extend((0..DEEP - 1).map(|k| json!({"children": [k], "translation": [0.5, 0, 0]})));
    file.json["nodes"] = json!(nodes);
    assert_eq!(
        triangles(&file.loaded().scene)[0][0],
        Vec3::new(10_000., 0., 0.)
    );
}

#[test]
fn the_default_scene_is_shown_else_the_first_else_all_roots() {
    let mut file = File::triangle();
    file.json["nodes"] = json!([
        {"mesh": 0},
        {"mesh": 0, "translation": [1, 0, 0]},
        {"mesh": 0, "translation": [2, 0, 0], "children": [0]},
    ]);
    let shown = |file: &File| file.loaded().scene.visible_count();
    assert_eq!(shown(&file), 3);
    file.json["scenes"] = json!([{"nodes": [1]}, {"nodes": [2]}]);
    assert_eq!(shown(&file), 1);
    file.json["scene"] = json!(1);
    assert_eq!(shown(&file), 2);
}

#[test]
fn normals_and_uvs_may_have_any_type() {
    let mut file = File::triangle();
    let normals = file.accessor(&[0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0], 5120, 3, 3);
    file.json["accessors"][normals]["normalized"] = json!(true);
    let view = file.json["accessors"][normals]["bufferView"]
        .as_u64()
        .unwrap() as usize;
    file.json["bufferViews"][view]["byteStride"] = json!(4);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["NORMAL"] = json!(normals);
    primitive["attributes"]["_OF_MINE"] = json!(normals);
    let scene = file.loaded().scene;
    assert_eq!(scene.triangles.corner_normals(0), Some([Vec3::Z; 3]));
}
