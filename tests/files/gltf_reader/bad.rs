//! Bad files, and messages about them.

use super::{File, glb, read};
use phalanx::formats::Diagnostic;
use serde_json::{Value, json};

/// The only message about a refused file.
fn message(file: &File) -> String {
    let messages = file.refused();
    assert_eq!(messages.len(), 1, "{messages:?}");
    messages.into_iter().next().unwrap_or_default()
}

fn changed(change: impl FnOnce(&mut Value)) -> String {
    let mut file = File::triangle();
    let indices = file.indices(&[0, 1, 2]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    change(&mut file.json);
    message(&file)
}

#[test]
fn every_bad_reference_and_size_gets_its_message() {
    let primitive =
        |change: fn(&mut Value)| changed(|json| change(&mut json["meshes"][0]["primitives"][0]));
    let accessor = |change: fn(&mut Value)| changed(|json| change(&mut json["accessors"][0]));
    let cases = [
        (
            changed(|j| j["nodes"][0]["mesh"] = json!(9)),
            "there is no meshes[9]",
        ),
        (
            changed(|j| j["nodes"][0]["children"] = json!([4])),
            "nodes[4]: named as a child or root, but not there",
        ),
        (
            changed(|j| j["scene"] = json!(2)),
            "the default scene, but not there",
        ),
        (
            changed(|j| j["scenes"] = json!([{"nodes": [3]}])),
            "nodes[3]: named as a child or root",
        ),
        (
            primitive(|p| p["material"] = json!(1)),
            "primitives[0]: there is no materials[1]",
        ),
        (
            primitive(|p| p["attributes"]["POSITION"] = json!(5)),
            "there is no accessors[5]",
        ),
        (
            primitive(|p| p["attributes"]["POSITION"] = json!(1)),
            "its type should be VEC3",
        ),
        (
            primitive(|p| p["indices"] = json!(0)),
            "its type should be SCALAR",
        ),
        (primitive(|p| p["mode"] = json!(7)), "there is no mode 7"),
        (
            accessor(|a| a["componentType"] = json!(5124)),
            "no component type 5124",
        ),
        (
            accessor(|a| a["count"] = json!(4)),
            "4 rows reach beyond bufferViews[0]",
        ),
        (accessor(|a| a["count"] = json!(u64::MAX)), "reach beyond"),
        (
            accessor(|a| a["byteOffset"] = json!(u64::MAX)),
            "reach beyond",
        ),
        (
            accessor(|a| a["bufferView"] = json!(9)),
            "there is no bufferViews[9]",
        ),
        (
            accessor(|a| a["count"] = json!(2)),
            "index 2 is not below its 2 vertices",
        ),
        (
            changed(|j| j["bufferViews"][0]["byteStride"] = json!(4)),
            "rows of 12 bytes overlap",
        ),
        (
            changed(|j| j["bufferViews"][0]["byteLength"] = json!(u64::MAX)),
            "beyond the",
        ),
        (
            changed(|j| j["bufferViews"][0]["buffer"] = json!(1)),
            "there is no buffers[1]",
        ),
        (
            changed(|j| j["accessors"][1]["componentType"] = json!(5120)),
            "its indices are not unsigned integers",
        ),
        (
            changed(|j| j["extensionsRequired"] = json!(["EXT_meshopt_compression"])),
            "`EXT_meshopt_compression`",
        ),
        (
            changed(|j| j["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
            "`KHR_draco_mesh_compression`",
        ),
        (
            changed(|j| j["asset"]["version"] = json!("1.0")),
            "this is glTF 1.0",
        ),
        (changed(|j| j["asset"] = json!({})), "no `asset.version`"),
        (
            changed(|j| j["nodes"][0]["mesh"] = json!(-2)),
            "nodes[0].mesh: expected a whole number from 0 on, not `-2`",
        ),
        (
            changed(|j| j["nodes"][0]["mesh"] = json!(1u64 << 32)),
            "there is no meshes[4294967296]",
        ),
        (
            changed(|j| j["asset"]["minVersion"] = json!("2.5")),
            "glTF `2.5` is needed (minVersion)",
        ),
    ];
    for (got, want) in cases {
        assert!(got.contains(want), "{got:?} should say {want:?}");
    }
}

#[test]
fn draco_without_data_beside_it_is_refused_by_name() {
    let mut file = File::triangle();
    file.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    file.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
    assert!(message(&file).contains("Draco"));
}

#[test]
fn cycles_and_shared_children() {
    let nodes = |nodes: Value, scenes: Value| {
        let mut file = File::triangle();
        file.json["nodes"] = nodes;
        file.json["scenes"] = scenes;
        message(&file)
    };
    let itself = json!([{"mesh": 0, "children": [0]}]);
    assert!(nodes(itself.clone(), json!([])).contains("the hierarchy has a cycle"));
    assert!(nodes(itself, json!([{"nodes": [0]}])).contains("nodes[0]: reached twice"));
    let ring = json!([{"children": [1]}, {"children": [2]}, {"children": [0]}]);
    assert!(nodes(ring, json!([{"nodes": [1]}])).contains("nodes[1]: reached twice"));
    let shared = json!([{"children": [2]}, {"children": [2]}, {"mesh": 0}]);
    assert!(nodes(shared, json!([])).contains("nodes[2]: reached twice"));
}

#[test]
fn vertices_that_are_no_numbers_leave_out_their_triangles() {
    for bad in [f32::INFINITY, f32::NAN, 1e30] {
        let mut file = File::empty();
        let corners = [0., 0., 0., 1., 0., 0., 0., 1., 0.];
        let positions = [&corners[..], &[0., 0., 0., 1., bad, 0., 0., 1., 0.]].concat();
        let positions = file.floats(3, &positions);
        file.mesh(json!({"attributes": {"POSITION": positions}}));
        file.node(json!({"mesh": 0}));
        let loaded = file.loaded();
        assert_eq!(loaded.scene.triangles.len(), 1, "{bad}");
        let warnings = &loaded.warnings[0].message;
        assert!(warnings.contains("one triangle is left out"), "{warnings}");
    }
}

#[test]
fn a_texture_without_its_places_is_named() {
    let mut file = File::triangle();
    file.json["images"] = json!([{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="}]);
    file.json["textures"] = json!([{"source": 0}]);
    let texture = json!({"index": 0, "texCoord": 1});
    file.add(
        "materials",
        json!({"pbrMetallicRoughness": {"baseColorTexture": texture}}),
    );
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let warnings = file.loaded().warnings;
    let warnings: Vec<&str> = warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(
        warnings[0].contains("its texture is not shown: it has no `TEXCOORD_1`"),
        "{warnings:?}"
    );
}

#[test]
fn sparse_rows_must_ascend_within_the_accessor() {
    let sparse = |indices: [u8; 2]| {
        let mut file = File::triangle();
        let view = file.view(&indices);
        file.json["accessors"][0]["sparse"] = json!({
            "count": 2, "indices": {"bufferView": view, "componentType": 5121}, "values": {"bufferView": 0}
        });
        message(&file)
    };
    assert!(sparse([1, 1]).contains("do not ascend"));
    assert!(sparse([1, 3]).contains("sparse index 3 is not below its count 3"));
}

#[test]
fn a_few_bytes_do_not_make_many_triangles() {
    let mut file = File::triangle();
    let accessor = &mut file.json["accessors"][0];
    accessor["count"] = json!(3_000_000_000u64);
    accessor.as_object_mut().unwrap().remove("bufferView");
    accessor["sparse"] = json!({
        "count": 0, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}
    });
    assert!(message(&file).contains("3000000000 rows are too many for a file of this size"));
}

fn only(errors: Result<phalanx::formats::Loaded, Vec<Diagnostic>>) -> Diagnostic {
    let errors = errors.map(|_| "a scene").expect_err("refused");
    assert_eq!(errors.len(), 1, "{errors:?}");
    errors.into_iter().next().expect("one")
}

#[test]
fn spans_are_lines_of_the_text_and_bytes_of_a_glb() {
    let text = "{\n  \"asset\": {\"version\": \"2.0\"},\n  \"nodes\": [\n    {},\n    {\"mesh\": 7}\n  ]\n}\n";
    let error = only(read("gltf", text.as_bytes()));
    assert_eq!((error.line, error.column), (5, 5));
    assert_eq!(error.message, "nodes[1]: there is no meshes[7]");
    let error = only(read("glb", &glb(text.as_bytes().to_vec(), &[])));
    assert_eq!(
        (error.line, error.offset),
        (0, 20 + text.find("{\"mesh").unwrap())
    );
    let error = only(read(
        "gltf",
        b"{\n\"asset\": {\"version\": \"2.0\"},\n  \"nodes\": 3}",
    ));
    assert_eq!(error.line, 3, "{error:?}");
    assert!(error.message.contains("expected a list"), "{error:?}");
    let error = only(read(
        "gltf",
        b"{\"asset\": {\"version\": \"2.0\"},\n\"nodes\": [\xff]}",
    ));
    assert_eq!((error.line, error.column), (2, 11));
    assert!(error.message.contains("not UTF-8"));
    assert!(only(read("gltf", b" \n")).message.contains("empty"));
}

#[test]
fn glb_chunks() {
    let good = File::triangle().glb();
    let cut = |length: usize| only(read("glb", &good[..length])).message;
    assert!(cut(7).contains("within its header"));
    assert!(cut(good.len() - 1).contains("cut off"));
    let with = |offset: usize, bytes: &[u8]| {
        let mut glb = good.clone();
        glb[offset..offset + bytes.len()].copy_from_slice(bytes);
        only(read("glb", &glb)).message
    };
    assert!(with(4, &[1]).contains("this is glTF 1.0"));
    assert!(with(4, &[3]).contains("GLB version 3"));
    assert!(with(8, &[0, 0, 0, 0]).contains("no `JSON` chunk"));
    assert!(with(12, &[0xff; 4]).contains("bytes are left"));
    assert!(with(16, b"NOSJ").contains("the first chunk is `NOSJ`"));
    // A view that reaches beyond a buffer which is shorter than the document says.
    let mut file = File::triangle();
    file.buffer.truncate(20);
    assert!(file.refused()[0].contains("beyond the 20 bytes"));
}
