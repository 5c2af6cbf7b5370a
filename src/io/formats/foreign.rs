//! Files that stand in the place of others: compressed, kept elsewhere, or never downloaded.

/// First bytes of such files, and what they are.
const FOREIGN: [(&[u8], &str); 9] = [
    (
        b"version https://git-lfs",
        "it stands for a file that is kept elsewhere (Git LFS): fetch it with `git lfs pull`",
    ),
    (b"\x1f\x8b", "it is compressed with gzip: unpack it first"),
    (
        b"\x28\xb5\x2f\xfd",
        "it is compressed with zstd: unpack it first",
    ),
    (b"\xfd7zXZ\0", "it is compressed with xz: unpack it first"),
    (b"BZh", "it is compressed with bzip2: unpack it first"),
    (b"PK\x03\x04", "it is a ZIP archive: unpack it first"),
    (b"7z\xbc\xaf\x27\x1c", "it is a 7z archive: unpack it first"),
    (
        b"<!doctype html",
        "it is a web page: download the file itself",
    ),
    (b"<html", "it is a web page: download the file itself"),
];

/// Says of bytes what they are instead of a scene or of what belongs to one.
pub(super) fn refusal(bytes: &[u8]) -> Option<&'static str> {
    let is = |magic: &[u8]| {
        let head = bytes.trim_ascii_start().get(..magic.len());
        head.is_some_and(|head| head.eq_ignore_ascii_case(magic))
    };
    let found = FOREIGN.iter().find(|(magic, _)| is(magic));
    found.map(|(_, words)| *words)
}

#[cfg(test)]
mod tests {
    use crate::formats::{Options, endings, load, read_bytes};
    use std::fs;

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
                let read = read_bytes(ending, bytes, &Options::default()).unwrap();
                let message = read.unwrap_err()[0].message.clone();
                assert!(message.contains(words), "{ending}: {message}");
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
        file("a.bin", POINTER);
        let obj = file(
            "a.obj",
            b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        );
        let loaded = load(&obj, &Options::default()).unwrap();
        let warning = loaded.warnings[0].message.clone();
        assert!(warning.contains("git lfs pull"), "{warning}");
        let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":36}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#;
        let gltf = file("a.gltf", gltf.as_bytes());
        let refused = load(&gltf, &Options::default()).unwrap_err().to_string();
        assert!(refused.contains("git lfs pull"), "{refused}");
    }
}
