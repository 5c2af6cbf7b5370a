//! Corner cases of the format: rows of zeros, primitives without positions, hidden nodes,
//! extensions.

use super::{File, messages};
use glam::{Vec2, Vec3};
use serde_json::json;

#[test]
fn an_accessor_without_a_view_is_zeros() {
    let mut file = File::triangle();
    file.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    file.json["textures"] = json!([{"source": 0}]);
    let picture = super::base64(include_bytes!("two.png"));
    file.json["images"] = json!([{"uri": format!("data:image/png;base64,{picture}")}]);
    let zeros = file.add(
        "accessors",
        json!({"componentType": 5126, "type": "VEC2", "count": 3}),
    );
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = json!(zeros);
    primitive["material"] = json!(0);
    let loaded = file.loaded();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(
        loaded.scene.triangles.corner_uvs(0, 0),
        Some([Vec2::ZERO; 3])
    );
    // Even in a file without any buffer.
    let mut file = File::empty();
    let positions = file.add(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 3}),
    );
    file.mesh(json!({"attributes": {"POSITION": positions}}));
    file.node(json!({"mesh": 0}));
    assert_eq!(file.loaded().scene.triangles.corners(0), [Vec3::ZERO; 3]);
}

#[test]
fn primitives_without_positions_are_left_out() {
    let mut file = File::triangle();
    let first = file.json["meshes"][0].clone();
    let mut mixed = first.clone();
    mixed["primitives"] = json!([{}, mixed["primitives"][0], {"mode": 0}, {"attributes": {}}]);
    file.json["meshes"] = json!([first, mixed, {"primitives": [{}], "weights": [1]}, {}]);
    for node in [
        json!({"mesh": 1}),
        json!({"mesh": 2}),
        json!({"mesh": 2, "weights": [2]}),
    ] {
        file.node(node);
    }
    let loaded = file.loaded();
    assert_eq!(loaded.scene.prim_count(), 2);
    let warnings = messages(&loaded.warnings);
    let want = [
        "one primitive of points or lines is left out",
        "3 primitives without positions are left out",
    ];
    assert_eq!(warnings, want, "once each, however often a mesh is shown");
}

#[test]
fn a_primitive_without_positions_is_left_out() {
    for bare in [
        json!({"attributes": {}}),
        json!({}),
        json!({"attributes": {"NORMAL": 0}, "indices": 99}),
    ] {
        let mut file = File::triangle();
        let first = file.json["meshes"][0]["primitives"][0].clone();
        file.json["meshes"][0]["primitives"] = json!([bare, first]);
        let loaded = file.loaded();
        assert_eq!(loaded.scene.prim_count(), 1);
        let warnings = messages(&loaded.warnings);
        assert_eq!(warnings, ["one primitive without positions is left out"]);
    }
}

#[test]
fn hidden_nodes_hide_all_below_them() {
    let mut file = File::triangle();
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    let light = |visible: bool| json!({"KHR_lights_punctual": {"light": 0}, "KHR_node_visibility": {"visible": visible}});
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    file.json["extensionsUsed"] = json!(["KHR_node_visibility", "KHR_lights_punctual"]);
    file.json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    file.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    file.json["nodes"] = json!([
        {"mesh": 0, "extensions": hidden, "children": [1, 2, 3, 4]},
        {"mesh": 0, "translation": [1, 0, 0]},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"extensions": light(true)},
        {"camera": 0, "translation": [0, 0, 7]},
        {"mesh": 0, "translation": [5, 0, 0], "extensions": {"KHR_node_visibility": {}}},
        {"translation": [0, 9, 0], "extensions": light(true)},
        {"translation": [0, 8, 0], "extensions": light(false)},
    ]);
    let loaded = file.loaded();
    let scene = &loaded.scene;
    assert_eq!(scene.visible_count(), 1);
    assert_eq!(scene.triangles.corners(0)[0], Vec3::X * 5.0);
    assert_eq!(scene.lights.len(), 1);
    assert_eq!(scene.lights.position.get(0), Vec3::Y * 9.0);
    assert_eq!(
        scene.view.eye,
        Vec3::Z * 7.0,
        "cameras are no visual features"
    );
    assert!(
        messages(&loaded.warnings)
            .iter()
            .all(|text| !text.contains("not shown"))
    );
}

#[test]
fn extensions_that_a_picture_may_lack_are_named_once() {
    let warnings_about = |used: &[&str]| {
        let mut file = File::triangle();
        file.json["extensionsUsed"] = json!(used);
        let loaded = file.loaded();
        messages(&loaded.warnings)
            .into_iter()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let harmless = [
        "KHR_xmp_json_ld",
        "EXT_structural_metadata",
        "KHR_materials_variants",
        "KHR_texture_transform",
        "MSFT_lod",
        "VRMC_springBone",
        "KHR_draco_mesh_compression",
    ];
    assert!(warnings_about(&harmless).is_empty());
    assert_eq!(
        warnings_about(&[
            "NEW_gaussian_splats",
            "EXT_lights_image_based",
            "NEW_gaussian_splats"
        ]),
        ["not shown: `EXT_lights_image_based`, `NEW_gaussian_splats`"]
    );
    let many: Vec<String> = (0..1000).map(|k| format!("NEW_{k}")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let warnings = warnings_about(&many);
    assert!(
        warnings.len() == 1 && warnings[0].contains("more extensions") && warnings[0].len() < 400,
        "{warnings:?}"
    );
    // Materials name theirs where they have them, not where the file lists them.
    assert!(warnings_about(&["KHR_materials_sheen"]).is_empty());
}

#[test]
fn a_stride_of_zero_is_no_gap() {
    let mut file = File::triangle();
    file.json["bufferViews"][0]["byteStride"] = json!(0);
    assert_eq!(
        file.loaded().scene.triangles.corners(0),
        [Vec3::ZERO, Vec3::X, Vec3::Y]
    );
}
