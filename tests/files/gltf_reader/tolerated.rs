//! Nonconforming files with a clear meaning, and messages about those that are refused.

use super::{File, messages, read};
use phalanx::formats::Loaded;
use serde_json::{Value, json};

/// A triangle with a document in another program's style.
fn rewritten(change: impl Fn(&str) -> String) -> Result<Loaded, Vec<String>> {
    let text = change(&File::triangle().text());
    let read = read("gltf", text.as_bytes());
    read.map_err(|errors| errors.into_iter().map(|error| error.message).collect())
}

fn triangle_with(change: impl FnOnce(&mut Value)) -> File {
    let mut file = File::triangle();
    change(&mut file.json);
    file
}

fn refusal(text: &str) -> (usize, usize, String) {
    let error = match read("gltf", text.as_bytes()) {
        Ok(_) => panic!("read: {text}"),
        Err(mut errors) => errors.remove(0),
    };
    (error.line, error.column, error.message)
}

#[test]
fn whole_numbers_may_have_a_fraction_of_zero_or_an_exponent() {
    for (plain, written) in [
        ("\"mesh\":0", "\"mesh\":0.0"),
        ("\"mesh\":0", "\"mesh\":0e3"),
        ("\"mesh\":0", "\"mesh\":-0.0"),
        ("\"componentType\":5126", "\"componentType\":5126.0"),
        ("\"componentType\":5126", "\"componentType\":5.126E+3"),
        ("\"count\":3", "\"count\":30e-1"),
        ("\"POSITION\":0", "\"POSITION\":0.00"),
        ("\"byteLength\":36", "\"byteLength\":36.0"),
        ("\"version\":\"2.0\"", "\"version\":2.0"),
    ] {
        let change = |text: &str| {
            assert!(text.contains(plain), "{plain} in {text}");
            text.replace(plain, written)
        };
        let loaded = rewritten(change).unwrap_or_else(|errors| panic!("{written}: {errors:?}"));
        assert_eq!(loaded.scene.triangles.len(), 1, "{written}");
        assert!(loaded.warnings.is_empty(), "{written}");
    }
    // Doubt is an error, and so is a number that the field has no room for.
    for (written, want) in [
        (
            "0.5",
            "nodes[0].mesh: expected a whole number from 0 on, not `0.5`",
        ),
        (
            "-2",
            "nodes[0].mesh: expected a whole number from 0 on, not `-2`",
        ),
        (
            "1e300",
            "nodes[0].mesh: expected a whole number from 0 on, not `1e300`",
        ),
        (
            "\"0\"",
            "nodes[0].mesh: expected a whole number from 0 on, not `\"0\"`",
        ),
    ] {
        let change = |text: &str| text.replace("\"mesh\":0", &format!("\"mesh\":{written}"));
        let error = rewritten(change).map(|_| "a scene").expect_err(written);
        assert_eq!(error, [want]);
    }
}

#[test]
fn null_stands_for_a_member_that_is_not_there() {
    let mut file = triangle_with(|json| {
        json["scene"] = json!(null);
        json["animations"] = json!(null);
        json["materials"] = json!([{"emissiveFactor": null, "pbrMetallicRoughness":
            {"metallicFactor": null, "baseColorFactor": [0.5, 0, 0, 1], "roughnessFactor": 1.0}}]);
        let node = json!({"mesh": 0, "children": null, "matrix": null, "extensions": null,
            "translation": null, "weights": null});
        json["nodes"] = json!([node]);
        json["meshes"][0]["primitives"][0]["mode"] = json!(null);
        json["meshes"][0]["primitives"][0]["material"] = json!(0);
        json["accessors"][0]["byteOffset"] = json!(null);
    });
    let loaded = file.loaded();
    assert_eq!(loaded.scene.triangles.len(), 1);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    // A member that must be there is missed.
    file.json["accessors"][0]["count"] = json!(null);
    assert_eq!(file.refused(), ["accessors[0]: missing field `count`"]);
}

#[test]
fn an_index_of_minus_one_stands_for_none_and_is_told_once() {
    let file = triangle_with(|json| {
        json["scene"] = json!(-1);
        let light = json!({"KHR_lights_punctual": {"light": -1}});
        json["nodes"] = json!([{"mesh": 0, "camera": -1, "skin": -1.0, "extensions": light}]);
        json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": -1}}}]);
        let primitive = &mut json["meshes"][0]["primitives"][0];
        primitive["indices"] = json!(-1);
        primitive["material"] = json!(0);
        primitive["attributes"]["NORMAL"] = json!(-1);
    });
    let loaded = file.loaded();
    assert_eq!(loaded.scene.triangles.len(), 1);
    let warnings = messages(&loaded.warnings);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0].ends_with(" is -1, which is read as none"),
        "{warnings:?}"
    );
    // A list has no places for rows that are not there.
    let file = triangle_with(|json| json["nodes"][0]["children"] = json!([-1]));
    let want = "nodes[0].children[0]: expected a whole number from 0 on, not `-1`";
    assert_eq!(file.refused(), [want]);
}

#[test]
fn what_is_of_the_wrong_kind_is_named_with_what_it_should_be() {
    let start = "{\"asset\": {\"version\": \"2.0\"},\n ";
    for (rest, column, want) in [
        ("\"nodes\": 3}", 11, "nodes: expected a list, not `3`"),
        (
            "\"nodes\": [{}], \"scene\": {}}",
            26,
            "scene: expected a whole number from 0 on, not `{}`",
        ),
        (
            "\"nodes\": [{\"scale\": [1, 2]}]}",
            22,
            "nodes[0].scale: expected a list of length 3, not `[1, 2]`",
        ),
        (
            "\"nodes\": [{\"scale\": [1, 2, 3, 4]}]}",
            22,
            "nodes[0].scale: expected a shorter list, not `[1, 2, 3, 4]`",
        ),
        (
            "\"nodes\": [{\"scale\": [1, 2, \"3\"]}]}",
            29,
            "nodes[0].scale[2]: expected a number, not `\"3\"`",
        ),
        (
            "\"nodes\": [{\"scale\": [1, 2, 1e999]}]}",
            29,
            "nodes[0].scale[2]: number out of range",
        ),
        (
            "\"nodes\": [7]}",
            12,
            "nodes[0]: expected an object, not `7`",
        ),
        (
            "\"images\": [{\"uri\": true}]}",
            21,
            "images[0].uri: expected a text, not `true`",
        ),
        (
            "\"cameras\": [{\"perspective\": {}}]}",
            30,
            "cameras[0].perspective: missing field `yfov`",
        ),
        ("\"scene\": 0, \"scene\": 0}", 0, "duplicate field `scene`"),
    ] {
        let (line, refused, message) = refusal(&format!("{start}{rest}"));
        assert_eq!(message, want);
        if column > 0 {
            assert_eq!((line, refused), (2, column), "{want}");
        }
    }
}

#[test]
fn broken_json_is_told_in_words_of_json() {
    let start = "{\"asset\": {\"version\": \"2.0\"},\n ";
    for (rest, want) in [
        ("\"nodes\": nul}", "expected a value"),
        ("\"nodes\": [1,]}", "expected a value"),
        ("\"nodes\": [1 2]}", "expected `,` or `]`"),
        ("\"nodes\" [1]}", "expected `:`"),
        ("nodes: [1]}", "expected a name in double quotes"),
        ("\"nodes\": [", "the document ends within a list"),
        ("\"nodes\": \"\\q\"}", "invalid escape"),
        ("\"nodes\": \"a\tb\"}", "control character"),
        ("\"nodes\": 01}", "invalid number"),
        ("\"nodes\": []} x", "there is more text after the end"),
    ] {
        let (line, column, message) = refusal(&format!("{start}{rest}"));
        assert!(message.starts_with(want), "{message:?} should say {want:?}");
        assert!(line == 2 && column > 1, "{line}:{column} of {want}");
    }
}

#[test]
fn the_first_version_is_named_before_anything_else() {
    for text in [
        r#"{"accessors": {"a": {}}, "asset": {"version": 1}}"#,
        r#"{"accessors": {"a": {}}, "asset": {"version": "1.0"}}"#,
        r#"{"accessors": 7, "asset": {"version": "1.0.1"}}"#,
        r#"{"meshes": {"a": {}}, "asset": {"generator": "x"}}"#,
        r#"{"nodes": {}, "scene": "defaultScene"}"#,
    ] {
        let (_, _, message) = refusal(text);
        assert!(
            message.starts_with("this is glTF 1.0, and only 2.0 is read"),
            "{message}"
        );
    }
    for (text, want) in [
        (
            r#"{"asset": {"version": "3.0"}}"#,
            "glTF `3.0` is not read here, only 2.0",
        ),
        (
            r#"{"asset": {"version": 10}}"#,
            "glTF `10` is not read here, only 2.0",
        ),
        (
            r#"{"asset": {"version": null}}"#,
            "not a glTF file: it has no `asset.version`",
        ),
        (
            r#"{"nodes": []}"#,
            "not a glTF file: it has no `asset.version`",
        ),
        ("[]", "the document: expected an object, not `[]`"),
        ("7", "the document: expected an object, not `7`"),
    ] {
        assert_eq!(refusal(text).2, want);
    }
}

#[test]
fn lights_of_unknown_types_are_left_out() {
    let file = triangle_with(|json| {
        json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
            {"type": "ambient"}, {"type": "point", "intensity": 10}, {"intensity": 1}]}});
        for light in 0..3 {
            let node = json!({"extensions": {"KHR_lights_punctual": {"light": light}},
                "translation": [0, 0, 1]});
            json["nodes"].as_array_mut().unwrap().push(node);
        }
    });
    let loaded = file.loaded();
    assert_eq!(loaded.scene.lights.len(), 1);
    let warnings = messages(&loaded.warnings);
    assert_eq!(
        warnings,
        ["nodes[1]: a light of the unknown type `ambient` is left out"]
    );
}

#[test]
fn attributes_with_fewer_rows_than_positions_are_left_out() {
    for (name, width) in [("COLOR_0", 4), ("NORMAL", 3), ("TEXCOORD_0", 2)] {
        let mut file = File::triangle();
        let short = file.floats(width, &vec![0.5; 2 * width]);
        file.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(short);
        file.json["materials"] = json!([{"pbrMetallicRoughness":
            {"baseColorTexture": {"index": 0}}}]);
        file.json["textures"] = json!([{"source": 0}]);
        file.json["images"] = json!([{"uri": format!("data:;base64,{WEBP}")}]);
        file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let loaded = file.loaded();
        assert_eq!(loaded.scene.triangles.len(), 1);
        let want = format!(
            "meshes[0]: primitives[0]: `{name}` is left out: it has fewer rows than POSITION"
        );
        assert!(
            messages(&loaded.warnings).contains(&want.as_str()),
            "{:?}",
            loaded.warnings
        );
    }
}

/// A WebP picture of one texel.
const WEBP: &str = "UklGRhoAAABXRUJQVlA4TA0AAAAvAAAAEAcQERGIiP4HAA==";

/// A triangle with a texture of these members, in a file that requires an extension.
fn textured(texture: &Value, required: &str) -> File {
    let mut file = File::triangle();
    let uvs = file.floats(2, &[0., 0., 1., 0., 0., 1.]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    primitive["material"] = json!(0);
    file.json["materials"] = json!([
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}]);
    file.json["textures"] = json!([texture]);
    file.json["images"] = json!([{"uri": format!("data:;base64,{WEBP}")}]);
    file.json["extensionsRequired"] = json!([required]);
    file
}

#[test]
fn pictures_of_required_extensions_are_read_or_left_out() {
    let texture = json!({"extensions": {"EXT_texture_webp": {"source": 0}}});
    let loaded = textured(&texture, "EXT_texture_webp").loaded();
    assert_eq!(loaded.scene.textures.len(), 1);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    for (extension, kind) in [
        ("KHR_texture_basisu", "KTX2"),
        ("EXT_texture_avif", "AVIF"),
        ("MSFT_texture_dds", "DDS"),
    ] {
        let texture = json!({"extensions": {extension: {"source": 0}}});
        let loaded = textured(&texture, extension).loaded();
        assert_eq!(loaded.scene.textures.len(), 0);
        let warnings = messages(&loaded.warnings);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(
            warnings[0].contains(kind) && warnings[0].contains(extension),
            "{warnings:?}"
        );
    }
}

#[test]
fn compressed_files_are_refused_with_a_way_to_convert_them() {
    for (extension, want) in [
        ("KHR_draco_mesh_compression", "gltf-transform copy"),
        ("EXT_meshopt_compression", "gltfpack"),
        ("KHR_meshopt_compression", "gltfpack"),
        ("EXT_other", "without that extension"),
    ] {
        let file = triangle_with(|json| json["extensionsRequired"] = json!([extension]));
        let errors = file.read().map(|_| "a scene").expect_err("refused");
        let help = errors[0].help.as_deref().unwrap_or_default();
        assert!(help.contains(want), "{help}");
    }
}

#[test]
fn files_on_other_machines_are_not_fetched() {
    for uri in [
        "https://example.com/a.bin",
        "HTTP://x/a%20b.bin?c=1",
        "blob:http://x/1",
    ] {
        let mut file = File::triangle();
        file.json["buffers"] = json!([{"byteLength": 36, "uri": uri}]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        std::fs::write(&path, file.json.to_string()).unwrap();
        let refused = phalanx::formats::load(&path, &phalanx::formats::Options::default());
        let error = refused.map(|_| "a scene").expect_err(uri).to_string();
        assert!(
            error.contains("files are not fetched from the network"),
            "{error}"
        );
    }
}
