//! Texts in picture files: the scene, the program, and a command that makes the picture again.

use super::TestFolder;
use exr::prelude::{ReadChannels, ReadLayers};
use std::fs;

/// The texts of a PNG by keyword, and its gamma.
fn texts(bytes: &[u8]) -> (Vec<(String, String)>, Option<u32>) {
    let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info();
    let reader = reader.unwrap();
    let info = reader.info();
    let latin = &info.uncompressed_latin1_text;
    let latin = latin
        .iter()
        .map(|chunk| (chunk.keyword.clone(), chunk.text.clone()));
    let utf8 = info.utf8_text.iter();
    let utf8 = utf8.map(|chunk| (chunk.keyword.clone(), chunk.get_text().unwrap()));
    let gamma = info.gama_chunk.map(|gamma| gamma.into_scaled());
    (latin.chain(utf8).collect(), gamma)
}

pub fn text(bytes: &[u8], keyword: &str) -> String {
    let (texts, _) = texts(bytes);
    let entry = texts.into_iter().find(|(other, _)| other == keyword);
    entry.unwrap_or_else(|| panic!("no {keyword}")).1
}

/// Runs the command stored in a picture, as a shell would, with another output name.
pub fn again(room: &TestFolder, command: &str, output: &str) {
    let program = env!("CARGO_BIN_EXE_phalanx");
    let line = command.replacen("phalanx", program, 1);
    let mut shell = std::process::Command::new("sh");
    shell.current_dir(room.path());
    let ran = super::ran(shell.args(["-c", &format!("{line} -o {output}")]));
    assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
}

#[test]
fn the_command_in_a_picture_makes_it_again() {
    let room = TestFolder::new();
    fs::create_dir(room.path().join("ä b")).unwrap();
    fs::copy(room.path().join("a.test"), room.path().join("it\'s ä.test")).unwrap();
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    room.ok("render a.test -o sky.pfm --size 6x3 --background .1,.2,.3");
    for (options, words) in [
        (
            "",
            "--size 40x24 --max-depth 5 --min-weight 0.0 --transfer none --quantize floor",
        ),
        (
            "--spp 4 --filter tent --aa adaptive --threshold .01 --region 3 4 20 11 --bits 16 --exposure=-.5",
            "--region 3 4 20 11",
        ),
        ("--aov alpha --bits 16 --transfer srgb", "--aov alpha"),
        (
            "--environment sky.pfm --environment-turn -30 --up z",
            "--up=z --environment=sky.pfm --environment-turn=-30",
        ),
        (
            "--exposure=-.5 --tone neutral",
            "--exposure=-0.5 --tone neutral",
        ),
        (
            "--exposure auto --tone neutral --transfer srgb",
            "--tone neutral",
        ),
        (
            "--camera 0.1,1,5 0,0,0 0,1,0 45 --light dir:1,2,3,.5,.25,1 --light 1,1,7 --background .1,.2,.3 \
             --integrator ao --ao-distance 3 --spp 2 --transfer srgb --origin 1,2,3 --ortho=5.5",
            "--light dir:1,2,3,0.5,0.25,1 --light 1,1,7,1,1,1 --background 0.1,0.2,0.3",
        ),
    ] {
        room.ok(&format!("render a.test -o one.png {options}"));
        let one = bytes("one.png");
        let command = text(&one, "Comment");
        assert!(command.contains(words), "{command}");
        again(&room, &command, "two.png");
        assert!(bytes("two.png") == one, "{command}");
        assert_eq!(text(&one, "Title"), "a.test");
        let version = concat!("phalanx ", env!("CARGO_PKG_VERSION"));
        assert_eq!(text(&one, "Software"), version);
        let gamma = if options.contains("srgb") { 45_455 } else { 100_000 };
        assert_eq!(texts(&one).1, Some(gamma));
    }
    // A name that a shell would split, and frames: each has its own camera.
    let mut render = room.command("render -o three.png");
    let ran = super::ran(render.arg("it\'s ä.test"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let three = bytes("three.png");
    assert_eq!(text(&three, "Title"), "it\'s ä.test");
    again(&room, &text(&three, "Comment"), "four.png");
    assert!(bytes("four.png") == three);
    room.ok("render a.test -o f#.exr --frames 1..2 --turntable 5 --aov depth --bits 16");
    let command = attribute(&bytes("f2.exr"), "phalanx.command");
    assert!(command.ends_with("--format exr --bits 16"), "{command}");
    again(&room, &command, "two.exr");
    assert!(bytes("two.exr") == bytes("f2.exr"), "{command}");
    assert!(bytes("f1.exr") != bytes("f2.exr"));
    // A mesh has four samples where nobody says otherwise.
    room.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 .2\nf 1 2 3\n");
    for (options, spp) in [
        ("--spp 1", "--spp 1"),
        ("", "--spp 4"),
        ("--spp 1 --light 1,2,3", "--spp 1"),
        ("--integrator ao", "--integrator ao --ao-distance 0.14 "),
        ("--integrator ao --ao-distance inf", "--ao-distance inf "),
        ("--headlight", " --headlight "),
        ("--smooth", "--smooth=30"),
    ] {
        room.ok(&format!("render m.obj -o m.png --size 40x30 {options}"));
        let command = text(&bytes("m.png"), "Comment");
        assert_eq!(command.contains("--spp"), !spp.is_empty(), "{command}");
        assert!(command.contains(spp), "{command}");
        again(&room, &command, "mesh.png");
        assert!(bytes("m.png") == bytes("mesh.png"), "{command}");
    }
}

/// A text of an OpenEXR file's header.
fn attribute(bytes: &[u8], name: &str) -> String {
    let read = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .unwrap();
    let others = &read.layer_data.attributes.other;
    let entry = others.iter().find(|(other, _)| *other == name);
    let (_, value) = entry.unwrap_or_else(|| panic!("no {name}"));
    value.clone().into_text().unwrap().to_string()
}

#[test]
fn layers_have_the_names_and_attributes_that_programs_look_for() {
    let room = TestFolder::new();
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    room.ok("render a.test -o a.exr --aov N,Ng,P,Z,A,crypto_object,crypto_material");
    room.ok(
        "render a.test -o b.exr --aov ns,ng,position,depth,alpha,crypto_object,crypto_material",
    );
    assert!(bytes("a.exr") == bytes("b.exr"), "old names of layers");
    let a = bytes("a.exr");
    // Keys of the layers are seven digits of the hashes of their names.
    for (key, layer, name, id) in [
        ("3ae39a5", "CryptoObject", "sphere1", "c6d20800"),
        ("be359d6", "CryptoMaterial", "material0", "66933a1b"),
    ] {
        let attribute = |end: &str| attribute(&a, &format!("cryptomatte/{key}/{end}"));
        assert_eq!(attribute("name"), layer);
        assert_eq!(attribute("hash"), "MurmurHash3_32");
        assert_eq!(attribute("conversion"), "uint32_to_float32");
        let manifest: serde_json::Value = serde_json::from_str(&attribute("manifest")).unwrap();
        assert_eq!(manifest[name], id, "{manifest}");
    }
    // Many objects: identifiers without names.
    room.ok("render standard:balls:5 -o c.exr --size 8x8 --aov crypto_object");
    assert!(memchr::memmem::find(&bytes("c.exr"), b"/conversion").is_some());
    assert!(memchr::memmem::find(&bytes("c.exr"), b"/manifest").is_none());
}

#[test]
fn a_region_lies_in_the_display_window_of_the_whole_picture() {
    let room = TestFolder::new();
    room.ok("render a.test -o r.exr --region 8 6 16 12 --aov Z");
    let read = exr::meta::MetaData::read_from_file(room.path().join("r.exr"), false).unwrap();
    let header = &read.headers[0];
    let data = (header.own_attributes.layer_position, header.layer_size);
    assert_eq!(data, (exr::math::Vec2(8, 6), exr::math::Vec2(16, 12)));
    let display = header.shared_attributes.display_window;
    assert_eq!((display.position.0, display.position.1), (0, 0));
    assert_eq!((display.size.0, display.size.1), (40, 24));
    // The whole picture's camera, and the same bytes from shards.
    room.ok("render a.test -o whole.exr --aov Z");
    let ndc = |name: &str| {
        let path = room.path().join(name);
        let read = exr::meta::MetaData::read_from_file(path, false).unwrap();
        read.headers[0]
            .own_attributes
            .world_to_normalized_device
            .unwrap()
    };
    assert_eq!(ndc("r.exr"), ndc("whole.exr"));
    room.ok("plan a.test --shards 2 -o m.exr --plan p.json --region 8 6 16 12 --aov Z");
    room.ok("render --plan p.json --shard 0");
    room.ok("render --plan p.json --shard 1");
    room.ok("merge p.json");
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    assert!(bytes("m.exr") == bytes("r.exr"));
    // Elsewhere it is a different picture, although its own pixels are the same there.
    room.ok("render a.test -o moved.exr --region 9 6 16 12 --aov Z");
    assert_eq!(room.run("compare r.exr moved.exr").code, Some(4));
}
