//! For any bytes, the reader returns, and every span it reports is within the file.

use super::{File, base64, glb, read};
use crate::mutated_text::check_answer;
use phalanx::formats::Loaded;
use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::json;
use std::path::Path;

/// A file with an example of every feature.
fn everything() -> File {
    let mut file = File::triangle();
    let positions = file.floats(3, &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    let normals = file.floats(3, &[0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let uvs = file.floats(2, &[0., 0., 1., 0., 1., 1., 0., 1.]);
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    let sparse = file.view(&[1, 2]);
    file.json["accessors"][positions]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": sparse, "componentType": 5121},
        "values": {"bufferView": 0}
    });
    file.json["meshes"] = json!([
        file.json["meshes"][0],
        {"primitives": [
            {"attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs}, "indices": indices, "material": 0},
            {"attributes": {"POSITION": positions}, "mode": 5, "material": 1},
        ]}
    ]);
    file.json["materials"] = json!([
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}}},
        {"alphaMode": "BLEND", "emissiveFactor": [1, 0, 0],
         "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.3}}},
    ]);
    file.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    file.json["samplers"] = json!([{"wrapS": 33071}]);
    let picture = format!(
        "data:image/png;base64,{}",
        base64(include_bytes!("two.png"))
    );
    file.json["images"] = json!([{"uri": picture}]);
    file.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    file.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point"}, {"type": "directional"}]}});
    file.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2]},
        {"mesh": 1, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, -1, 1]},
        {"mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 5, 5, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"camera": 0, "translation": [0, 0, 9], "extensions": {"KHR_lights_punctual": {"light": 1}}},
    ]);
    file.json["scenes"] = json!([{"nodes": [0, 3]}]);
    file
}

/// A file with poses, copies and colours.
fn posed() -> File {
    let mut file = File::triangle();
    let moved = file.floats(3, &[1., 0., 0., 1., 0., 0., 1., 0., 0.]);
    let numbers = file.accessor(&[0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], 5121, 4, 3);
    let weights = file.floats(4, &[0.5, 0.5, 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    let colors = file.accessor(&[255, 0, 0, 128, 0, 255, 0, 255, 0, 0, 255, 0], 5121, 4, 3);
    let bound = file.floats(4, &[1.; 32]);
    file.json["accessors"][bound]["type"] = json!("MAT4");
    file.json["accessors"][bound]["count"] = json!(2);
    let zeros = file.add(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 3}),
    );
    file.json["meshes"] = json!([{"weights": [0.5, 0.25], "primitives": [{
        "attributes": {"POSITION": 0, "COLOR_0": colors, "JOINTS_0": numbers, "WEIGHTS_0": weights},
        "targets": [{"POSITION": moved, "NORMAL": zeros}, {"COLOR_0": colors}], "material": 0
    }, {"attributes": {}}]}]);
    file.json["materials"] = json!([{"alphaMode": "MASK", "alphaCutoff": 0.5}]);
    file.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": bound}]);
    file.json["cameras"] = json!([{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0, "zfar": 9}}]);
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "intensity": 90, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}
    ]}});
    file.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "weights": [1, 1]},
        {"translation": [1, 0, 0], "children": [2]},
        {"scale": [2, 2, 2]},
        {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moved, "_ID": 0}}}},
        {"mesh": 0, "weights": [0, 1], "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"camera": 0, "translation": [0, 0, 4], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]);
    file
}

fn check(bytes: &[u8]) {
    check_answer(read("gltf", bytes), |d| {
        assert!(d.offset + d.length <= bytes.len().max(d.length), "{d:?}");
        assert_eq!(d.line == 0, bytes.starts_with(b"glTF"), "{d:?}");
    });
}

/// Sets bytes, and truncates the rest.
fn mutate(bytes: &mut Vec<u8>, changes: Vec<(Index, u8)>, cut: Option<Index>) {
    for (position, byte) in changes {
        let position = position.index(bytes.len());
        bytes[position] = byte;
    }
    if let Some(cut) = cut {
        bytes.truncate(cut.index(bytes.len() + 1));
    }
}

/// The seeds of `tests/allocation/fuzz_readers`, rewritten by `PHALANX_BLESS=1 cargo test --test
/// files gltf_reader::mangled::`.
#[test]
fn the_fuzz_targets_seeds_are_these_files() {
    let mut picture = everything();
    let view = picture.view(PICTURES[2]);
    picture.json["images"] = json!([{"bufferView": view}]);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/allocation/fuzz_readers/corpus");
    for (name, bytes) in [
        ("gltf/everything.gltf", everything().text().into_bytes()),
        ("gltf/plain.gltf", File::triangle().text().into_bytes()),
        ("gltf/posed.gltf", posed().text().into_bytes()),
        ("glb/everything.glb", everything().glb()),
        ("glb/picture.glb", picture.glb()),
        ("glb/plain.glb", File::triangle().glb()),
        ("glb/posed.glb", posed().glb()),
    ] {
        let path = folder.join(name);
        if std::env::var_os("PHALANX_BLESS").is_some() {
            std::fs::create_dir_all(path.parent().expect("a folder")).unwrap();
            std::fs::write(&path, &bytes).unwrap();
        }
        assert!(
            std::fs::read(&path).is_ok_and(|seed| seed == bytes),
            "{name} is not what is made here"
        );
    }
}

#[test]
fn the_unchanged_file_is_valid() {
    let loaded = everything().loaded();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
    let counts = |loaded: &Loaded| (loaded.scene.prim_count(), loaded.scene.visible_count());
    assert_eq!(counts(&loaded), (5, 9));
    let posed = posed().loaded();
    assert!(posed.notes.is_empty(), "{:?}", posed.notes);
    assert_eq!(counts(&posed), (3, 5), "{:?}", posed.warnings);
    assert_eq!(posed.warnings.len(), 1, "a primitive without positions");
}

/// Replacements for numbers, names and brackets of the document.
const SPICE: [&str; 16] = [
    "-1",
    "0",
    "1",
    "2",
    "7",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "1e300",
    "-1e-300",
    "0.5",
    "null",
    "[]",
    "{}",
    "\"x\"",
    "5121",
];

/// The text with the token at `offset` (modulo their number) replaced.
fn spiced(text: &str, offset: usize, spice: &str) -> String {
    let tokens: Vec<usize> = text
        .char_indices()
        .filter(|(_, c)| ":,[".contains(*c))
        .map(|(i, _)| i + 1)
        .collect();
    let start = tokens[offset % tokens.len()];
    let length = text[start..].find([',', ']', '}', ':']).unwrap_or(0);
    format!("{}{spice}{}", &text[..start], &text[start + length..])
}

proptest! {
    #[test]
    fn changed_documents_never_panic(
        changes in prop::collection::vec((any::<usize>(), prop::sample::select(&SPICE[..])), 1..5),
        binary in any::<bool>(),
        still in any::<bool>(),
    ) {
        let file = if still { everything() } else { posed() };
        let mut json = file.json.clone();
        json["buffers"] = json!([{"byteLength": file.buffer.len()}]);
        let mut text = if binary { json.to_string() } else { file.text() };
        for (offset, spice) in changes {
            text = spiced(&text, offset, spice);
        }
        check(&if binary { glb(text.into_bytes(), &file.buffer) } else { text.into_bytes() });
    }

    #[test]
    fn changed_bytes_never_panic(
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 0..8),
        cut in prop::option::weighted(0.2, any::<Index>()),
        binary in any::<bool>(),
        still in any::<bool>(),
    ) {
        let file = if still { everything() } else { posed() };
        let mut bytes = if binary { file.glb() } else { file.text().into_bytes() };
        mutate(&mut bytes, changes, cut);
        check(&bytes);
    }

    #[test]
    fn changed_pictures_never_panic(
        which in 0usize..PICTURES.len(),
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 0..6),
        cut in prop::option::weighted(0.2, any::<Index>()),
    ) {
        let mut picture = PICTURES[which].to_vec();
        mutate(&mut picture, changes, cut);
        let mut file = everything();
        let view = file.view(&picture);
        file.json["images"] = json!([{"bufferView": view}]);
        check(&file.glb());
    }
}

/// Baseline with half the colour, progressive, grey, and a PNG.
const PICTURES: [&[u8]; 4] = [
    include_bytes!("../../pictures/halved.jpg"),
    include_bytes!("../../pictures/progressive.jpg"),
    include_bytes!("../../pictures/grey.jpg"),
    include_bytes!("two.png"),
];
