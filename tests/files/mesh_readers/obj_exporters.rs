//! OBJ and MTL files from programs that deviate from the format's definition, and UTF-16 text.

use super::{FLAT, errors, messages, triangles};
use glam::Vec3;
use phalanx::formats::{LoadError, Loaded, Options, ReadOptions, load, read_bytes};
use phalanx::scene::{Material, Scene};
use std::path::Path;

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";

fn write(folder: &Path, files: &[(&str, &[u8])]) {
    for (name, bytes) in files {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

/// Reads the first of these files, with the others in the same folder.
fn first_of(files: &[(&str, &[u8])]) -> Loaded {
    let scratch = tempfile::tempdir().unwrap();
    write(scratch.path(), files);
    let path = scratch.path().join(files[0].0);
    load(&path, &Options::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn material_of(scene: &Scene, triangle: usize) -> Material {
    scene
        .materials
        .get(scene.triangles.material[triangle] as usize)
}

/// A picture of one green pixel.
fn green() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[0, 255, 0]).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Text with a byte order mark, in UTF-16 of both orders.
fn utf16(text: &str) -> [Vec<u8>; 2] {
    let marked = format!("\u{feff}{text}");
    let units = || marked.encode_utf16();
    [
        units().flat_map(u16::to_le_bytes).collect(),
        units().flat_map(u16::to_be_bytes).collect(),
    ]
}

#[test]
fn doubtful_materials_are_read_as_they_are_meant() {
    let mtl = "newmtl scan\nKa 1 1 1\nTr 1.000000\nillum 1\nmap_Kd a.png\n\
               newmtl maya\nillum 4\nKd 0.00 0.00 0.00\nTr 1\nmap_Kd a.png\n\
               newmtl clear\nd 0\nTr 1\n";
    let obj = format!(
        "mtllib m.mtl\n{CORNERS}usemtl scan\nf 1/1 2/1 3/1\nusemtl maya\nf 1/1 2/1 3/1\nusemtl clear\nf 1 2 3\n"
    );
    let files = [
        ("m.obj", obj.as_bytes()),
        ("m.mtl", mtl.as_bytes()),
        ("a.png", &green()),
    ];
    let loaded = first_of(&files);
    let warnings = messages(&loaded.warnings);
    assert_eq!(warnings.len(), 2, "{warnings:#?}");
    assert!(warnings[0].starts_with("m.mtl:3:1: `Tr 1` without a `d` is taken as opaque"));
    assert!(warnings[1].starts_with("m.mtl:8:1: a black `Kd` with a `map_Kd` is taken as 1"));
    let [scan, maya, clear] = [0, 1, 2].map(|k| material_of(&loaded.scene, k));
    assert_eq!((scan.opacity, maya.opacity, clear.opacity), (1.0, 1.0, 0.0));
    assert_eq!((maya.kd, maya.kt), (Vec3::ONE, Vec3::ZERO));
}

#[test]
fn lists_of_material_files_may_hold_blanks() {
    let files: [(&str, &[u8]); 4] = [
        ("stone wall one.lib", b"newmtl r\nKd 1 0 0\n"),
        ("stone wall.lib", b"newmtl r\nKd 0 0 1\n"),
        ("two.mtl", b"newmtl g\nKd 0 1 0\n"),
        ("My Grass.mtl", b"newmtl g\nKd 0 1 0\n"),
    ];
    for list in [
        "stone wall one.lib two.mtl",
        "two.mtl stone wall one.lib # both",
        "./stone\\ wall\\ one.lib ./two.mtl",
        "\"stone wall one.lib\" \"two.mtl\"",
        "stone wall one.lib my grass.mtl",
        ".\\stone wall one.lib .\\two.mtl",
    ] {
        let obj = format!("mtllib {list}\n{CORNERS}usemtl r\nf 1 2 3\nusemtl g\nf 1 2 3\n");
        let files = [&[("m.obj", obj.as_bytes())], &files[..]].concat();
        let loaded = first_of(&files);
        let renamed = messages(&loaded.warnings);
        let expected = usize::from(list.contains("my grass"));
        assert_eq!(renamed.len(), expected, "{list}: {renamed:?}");
        let [r, g] = [0, 1].map(|k| material_of(&loaded.scene, k).kd);
        assert_eq!((r, g), (Vec3::X, Vec3::Y), "{list}");
    }
}

#[test]
fn a_missing_material_file_is_one_warning() {
    let name = format!("{} the model.mtl", "a long name of".repeat(5));
    let obj = format!("mtllib {name}\n{CORNERS}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n");
    let loaded = first_of(&[("m.obj", obj.as_bytes())]);
    let warnings = messages(&loaded.warnings);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with(&format!("the material file `{name}` is left out: ")));
    let loaded = first_of(&[
        ("m.obj", obj.replace(&name, "m.mtl").as_bytes()),
        ("m.mtl", b""),
    ]);
    let warnings = messages(&loaded.warnings);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[1].starts_with("there is no material `b`"));
}

#[test]
fn an_object_file_is_one_error() {
    let mut object = b"\x4c\x01\x03\0\xde\xad\n v 1\n".to_vec();
    object.extend(b"f x\nv a\nvn b\n\0\0".repeat(50));
    let faults = errors("obj", &object);
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(
        faults[0].message,
        "this is not text: a Windows object file?"
    );
    assert_eq!((faults[0].line, faults[0].offset), (0, 3));
    // A NUL harms no file that is right otherwise.
    let padded = format!("# by\0x\n{CORNERS}f 1 2 3\n\0\0\0");
    assert_eq!(
        triangles(&super::read("obj", padded.as_bytes()).scene),
        FLAT
    );
    let padded = format!("{CORNERS}f 1 2 9\n\0\0\0");
    assert_eq!(errors("obj", padded.as_bytes())[0].line, 5);
}

#[test]
fn what_is_up_is_said_where_the_format_does_not() {
    let obj = format!("{CORNERS}f 1 2 3\n");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{}]}"#;
    let note = |ending, text: &str| {
        let read = read_bytes(ending, text.as_bytes(), &Options::default()).unwrap();
        let notes = read.map(|loaded| loaded.notes).unwrap_or_default();
        notes.into_iter().find(|note| note.contains("no camera"))
    };
    let common = "the file has no camera: one that frames everything is used";
    let expected = format!("{common}, y up (see --camera, --up)");
    assert_eq!(note("obj", &obj), Some(expected.clone()));
    assert_eq!(note("ply", ply), Some(expected));
    assert_ne!(
        note("gltf", gltf),
        Some(format!("{common}, y up (see --camera, --up)"))
    );
}

#[test]
fn utf16_is_read_in_every_format_of_text() {
    let obj = format!("# 模型 ü\n{CORNERS}f 1 2 3\n");
    let ply = "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\n\
               property float z\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\n\
               end_header\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n";
    let stl = "solid ä\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
               endloop\nendfacet\nendsolid\n";
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let gltf = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0],"name":"ü"}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "buffers":[{{"byteLength":36,"uri":"data:application/octet-stream;base64,{data}"}}]}}"#
    );
    for (ending, text) in [
        ("obj", &obj[..]),
        ("ply", ply),
        ("stl", stl),
        ("gltf", &gltf),
    ] {
        for bytes in utf16(text) {
            assert_eq!(
                triangles(&super::read(ending, &bytes).scene),
                FLAT,
                "{ending}"
            );
        }
    }
    for (ending, text) in [
        ("test", "size 4 4\nsphere 0 0 0 1\nbad ü\n"),
        ("nff", "# é\nb 1 0\n"),
        ("obj", "# ü\nv 0 0 0\nf 1 2 3\n"),
    ] {
        let plain = errors(ending, text.as_bytes());
        for bytes in utf16(text) {
            assert_eq!(errors(ending, &bytes), plain, "{ending}");
        }
    }
}

#[test]
fn utf16_is_counted_and_must_be_whole() {
    let scratch = tempfile::tempdir().unwrap();
    let obj = format!(
        "# {}\nmtllib m.mtl\n{CORNERS}usemtl ü\nf 1 2 3\n",
        "模".repeat(5000)
    );
    let [little, big] = utf16(&obj);
    let [_, mtl] = utf16("newmtl ü\r\nKd 0 1 0\r\n");
    write(scratch.path(), &[("m.obj", &little), ("m.mtl", &mtl)]);
    let path = scratch.path().join("m.obj");
    let loaded = load(&path, &Options::default()).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(material_of(&loaded.scene, 0).kd, Vec3::Y);
    let options = Options {
        read: ReadOptions {
            max_memory: Some(10_000),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let Err(LoadError::Memory { what, needed, .. }) = load(&path, &options) else {
        panic!("more than allowed");
    };
    assert_eq!(
        (&what[..], needed),
        ("for the file's text in UTF-8", obj.len() as u64)
    );

    let broken = errors("obj", &big[..big.len() - 1]);
    assert_eq!((broken.len(), broken[0].offset), (1, big.len() - 2));
    assert!(broken[0].message.contains("UTF-16") && broken[0].help.is_some());
    write(scratch.path(), &[("m.mtl", &mtl[..mtl.len() - 1])]);
    let loaded = load(&path, &Options::default()).unwrap();
    let warnings = messages(&loaded.warnings);
    assert!(
        warnings.len() == 1 && warnings[0].contains("UTF-16"),
        "{warnings:?}"
    );
}
