//! Files of another kind, which every reader refuses by their name.

use crate::{LoadError, ReadOptions, ReadScene, SceneFile, endings};
use std::fs;
use std::path::Path;

fn message(ending: &str, bytes: &[u8]) -> String {
    let file = SceneFile::from_bytes(Path::new(""), ending, bytes).unwrap();
    let mut faults = file.read_alone(&ReadOptions::default()).unwrap_err();
    faults.swap_remove(0).message
}

fn load(path: &Path) -> Result<ReadScene, LoadError> {
    SceneFile::open(path, None, 0)?.read(&ReadOptions::default())
}

const POINTER: &[u8] = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n";

#[test]
fn what_is_no_scene_is_named_in_every_format() {
    for ending in endings() {
        for (bytes, words) in [
            (POINTER, "git lfs pull"),
            (b"\x1f\x8b\x08\0\0", "gzip"),
            (b"PK\x03\x04\x14", "ZIP"),
            (b"\n<!DOCTYPE HTML>\n", "web page"),
        ] {
            let message = message(ending, bytes);
            assert!(message.contains(words), "{ending}: {message}");
        }
    }
}

#[test]
fn pictures_and_scenes_are_named_where_another_format_is_read() {
    for (bytes, readers, words) in [
        (&b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], "", "a PNG picture"),
        (b"\xff\xd8\xff\xe0\0\x10JFIF", "", "a JPEG picture"),
        (b"glTF\x02\0\0\0", "gltf glb", "end in .glb"),
        (
            b"ply\nformat binary_little_endian 1.0\n",
            "ply",
            "end in .ply",
        ),
        (b"ply\r\nformat ascii 1.0\r\n", "ply", "end in .ply"),
    ] {
        for ending in endings() {
            let message = message(ending, bytes);
            let named = message.contains(words);
            assert_eq!(named, !readers.contains(ending), "{ending}: {message}");
        }
    }
}

#[test]
fn so_is_what_belongs_to_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    file("a.mtl", POINTER);
    file("b.mtl", b"newmtl m\nmap_Kd t.png\n");
    file("t.png", POINTER);
    file("a.bin", POINTER);
    for mtl in ["a.mtl", "b.mtl"] {
        let text = format!("mtllib {mtl}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
        let obj = file("a.obj", text.as_bytes());
        let loaded = load(&obj).unwrap();
        let warning = loaded.warnings[0].message.clone();
        assert!(warning.contains("git lfs pull"), "{warning}");
    }
    let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":36}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#;
    let gltf = file("a.gltf", gltf.as_bytes());
    let refused = load(&gltf).unwrap_err().to_string();
    assert!(refused.contains("git lfs pull"), "{refused}");
}
