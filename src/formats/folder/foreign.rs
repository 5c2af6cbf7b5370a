//! Files that replace others: compressed, stored elsewhere, or never downloaded.

/// First bytes of compressed files, and the programs that made them. Those of gzip include its only
/// method: many buffers of numbers begin with the first two bytes.
const PACKED: [(&[u8], &str); 6] = [
    (b"\x1f\x8b\x08", "compressed with gzip"),
    (b"\x28\xb5\x2f\xfd", "compressed with zstd"),
    (b"\xfd7zXZ\0", "compressed with xz"),
    (b"BZh", "compressed with bzip2"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
];

/// First bytes of pictures and scenes, the ending of such files, and their names.
const OTHERS: [(&[u8], &str, &str); 5] = [
    (b"\x89PNG\r\n\x1a\n", "png", "a PNG picture, not a scene"),
    (b"\xff\xd8\xff", "jpg", "a JPEG picture, not a scene"),
    (b"glTF", "glb", "binary glTF: its name should end in .glb"),
    (b"ply\n", "ply", "a PLY file: its name should end in .ply"),
    (b"ply\r", "ply", "a PLY file: its name should end in .ply"),
];

/// Identifies a file of another kind than those with these endings. Texts of all formats, and the
/// headers of binary STL, begin in other ways.
pub(crate) fn other_kind(bytes: &[u8], endings: &[&str]) -> Option<String> {
    let mut others = (OTHERS.iter()).filter(|(_, ending, _)| !endings.contains(ending));
    let (_, _, what) = others.find(|(magic, ..)| bytes.starts_with(magic))?;
    Some(format!("it is {what}"))
}

/// Identifies bytes that are neither a scene nor a part of one.
pub fn refusal(bytes: &[u8]) -> Option<String> {
    let packed = PACKED.iter().find(|(magic, _)| bytes.starts_with(magic));
    if let Some((_, what)) = packed {
        return Some(format!("it is {what}: unpack it first"));
    }
    if bytes.starts_with(b"version https://git-lfs") {
        let words =
            "it stands for a file that is kept elsewhere (Git LFS): fetch it with `git lfs pull`";
        return Some(words.to_owned());
    }
    let text = bytes.trim_ascii_start();
    let is_tag = |tag: &[u8]| {
        let head = text.get(..tag.len());
        head.is_some_and(|head| head.eq_ignore_ascii_case(tag))
    };
    let is_page = is_tag(b"<!doctype html") || is_tag(b"<html");
    is_page.then(|| "it is a web page: download the file itself".to_owned())
}

#[cfg(test)]
mod tests {
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

    /// Numbers of a buffer: the first is 1f 8b 00 3f as bytes, which gzip does not begin with.
    #[test]
    fn numbers_that_begin_like_a_packed_file_are_numbers() {
        let numbers = f32::from_bits(0x3f00_8b1f).to_le_bytes();
        assert_eq!(super::refusal(&numbers), None);
        assert_eq!(super::refusal(b" \n\x1f\x8b\x08"), None);
        assert_eq!(super::refusal(b"bzh is a word of a comment"), None);
    }
}
