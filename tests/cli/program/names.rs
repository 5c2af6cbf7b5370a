//! Names of files: in reports and pictures, and the camera that an option names.

use super::TestFolder;
use serde_json::json;
use std::fs;

/// A named triangle before two cameras of different shape.
fn room() -> TestFolder {
    let room = TestFolder::new();
    let data = "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let camera = |yfov: f64, aspect: f64| json!({"type": "perspective", "perspective": {"yfov": yfov, "aspectRatio": aspect, "znear": 1}});
    let parallel = json!({"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 1, "zfar": 9, "znear": 1}});
    let file = json!({
        "asset": {"version": "2.0"},
        "nodes": [
            {"mesh": 0, "name": "c\u{fc}p\u{1b}"},
            {"camera": 0, "name": "wide one", "translation": [0, 0, 5]},
            {"camera": 1, "name": "-narrow", "translation": [0, 0, 5]},
            {"camera": 2, "translation": [0.25, 0, 5]}
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"name": "red"}],
        "cameras": [camera(0.8, 2.0), camera(0.4, 1.0), parallel],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": data}]
    });
    room.write("s.gltf", &file.to_string());
    room
}

#[test]
fn an_option_names_the_camera_of_a_file_or_a_cache() {
    let room = room();
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    room.ok("build s.gltf -o s.phx");
    room.ok("build s.gltf -o narrow.phx --camera-name=-narrow");
    let mut before = Vec::new();
    for camera in ["", "--camera-name=-narrow", "--camera-name 2"] {
        for size in ["", "--size 40x30"] {
            room.ok(&format!("render s.gltf -o a.pfm {camera} {size}"));
            let full = bytes("a.pfm");
            assert!(!before.contains(&full), "{camera} {size}");
            for cache in ["s.phx", "narrow.phx"] {
                let camera = match camera {
                    "" => "--camera-name 0",
                    camera => camera,
                };
                room.ok(&format!("render {cache} -o b.pfm {camera} {size}"));
                assert!(bytes("b.pfm") == full, "{cache} {camera} {size}");
            }
            before.push(full);
        }
    }
    room.ok("verify s.gltf --camera-name=-narrow --size 24x16 --threads 1");
    // The command in a picture has the option, too.
    room.ok("render s.gltf -o a.png --camera-name=-narrow --size 24x16");
    let png = bytes("a.png");
    assert!(memchr::memmem::find(&png, b"render s.gltf --camera-name=-narrow --size").is_some());
    let plan = "plan s.gltf --camera-name=-narrow --size 24x16 -o p.png --plan p.json --shards 1";
    room.ok(plan);
    room.ok("render --plan p.json --shard 0");
    room.ok("merge p.json");
    assert!(bytes("p.png") == png);
    let known = "`wide one` (0), `-narrow` (1), 2";
    for scene in ["s.gltf", "s.phx"] {
        let ran = room.run(&format!("info {scene}"));
        let note = "the file has 3 cameras: `wide one` (0) is used, not `-narrow` (1), 2";
        assert!(ran.stderr.contains(note), "{}", ran.stderr);
        let row = "cameras      0 `wide one` (used), 1 `-narrow`, 2\n";
        assert!(ran.stdout.contains(row), "{}", ran.stdout);
        let line = format!("info {scene} --camera-name 3");
        room.refused(&line, 2, &["`3`", known]);
    }
    let both = "render s.gltf -o a.png --camera-name 1 --camera 0,0,4 0,0,0 0,1,0 40";
    room.refused(both, 2, &["--camera-name", "cannot be used with"]);
}

#[test]
fn names_are_in_reports_and_manifests() {
    let room = room();
    let report = room.ok("info s.gltf");
    assert!(
        report.contains("objects      1 name: `cüp\\u{1b}` 1\n"),
        "{report}"
    );
    assert!(
        report.contains("materials    1, 1 name: `red` 1\n"),
        "{report}"
    );
    let info = room.json("info s.gltf --json");
    assert_eq!(
        info["named_objects"],
        json!({"count": 1, "largest": [["cüp\u{1b}", 1]]})
    );
    assert_eq!(info["cameras"][2], json!({"name": null, "used": false}));
    room.ok("build s.gltf -o s.phx");
    for scene in ["s.gltf", "s.phx"] {
        room.ok(&format!(
            "render {scene} -o a.exr --aov crypto_object,crypto_material"
        ));
        let bytes = fs::read(room.path().join("a.exr")).unwrap();
        let [object, material] = ["cüp\u{1b}", "red"].map(phalanx::scene::matte_id);
        for part in [
            format!("{{\"cüp\\u001b\":\"{object:08x}\"}}"),
            format!("{{\"red\":\"{material:08x}\"}}"),
        ] {
            let position = memchr::memmem::find(&bytes, part.as_bytes());
            assert!(position.is_some(), "{scene}: {part}");
        }
    }
}
