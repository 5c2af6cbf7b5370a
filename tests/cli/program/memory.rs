//! `--max-memory` is respected: a reader's peak memory, and its refusal before exceeding the limit.
//! Files that would take more are read in an address space that is too small for them.

use super::{Ran, SCENE, TestFolder};
use std::fmt::Write;
use std::fs;
use std::process::Command;

/// Runs a command that must be refused with this code and these parts of a message, in an address
/// space of 400 MB.
fn refused_in_400_mb(room: &TestFolder, line: &str, code: i32, parts: &[&str]) {
    let Ran {
        code: ended,
        stderr,
        ..
    } = room.run_in_400_mb(line);
    let head: String = stderr.chars().take(2000).collect();
    assert_eq!(ended, Some(code), "{line}: {head}");
    for part in parts {
        assert!(stderr.contains(part), "{line}: {part:?} in\n{head}");
    }
}

/// The peak of `info` with this memory limit, in millions of bytes.
fn peak(room: &TestFolder, scene: &str, allowed: u64) -> u64 {
    let report = room.json(&format!("info {scene} --max-memory {allowed}M --json"));
    report["memory"]["peak_rss_bytes"].as_u64().unwrap() / 1_000_000
}

/// A grid of 2·599² triangles, whose columns are freed and reallocated during reading and building.
fn grid() -> String {
    let mut text = String::new();
    for k in 0..600 * 600 {
        writeln!(text, "v {}.5 {} {}", k % 600, k % 7, k / 600).unwrap();
    }
    for k in (0..600 * 599).filter(|k| k % 600 != 599) {
        let (a, b) = (k + 1, k + 601);
        writeln!(text, "f {a} {} {b}\nf {} {} {b}", a + 1, a + 1, b + 1).unwrap();
    }
    text
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn what_is_freed_is_given_back() {
    let room = TestFolder::new();
    room.write("grid.obj", &grid());
    let peak = peak(&room, "grid.obj", 156);
    assert!(peak < 156, "{peak}");
}

/// A progressive JPEG of one scan that claims 4096×4096 pixels and is long enough to be plausible.
#[test]
fn coefficients_of_one_progressive_scan_count() {
    let room = TestFolder::new();
    let full = fs::read(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/pictures/progressive.jpg"
    ));
    let mut jpeg = full.unwrap();
    let scans: Vec<usize> = memchr::memmem::find_iter(&jpeg, b"\xff\xda").collect();
    jpeg.truncate(scans[1]);
    let frame = memchr::memmem::find(&jpeg, b"\xff\xc2").unwrap() + 5;
    jpeg[frame..frame + 4].copy_from_slice(&[0x10, 0, 0x10, 0]);
    jpeg.extend([0xff, 0xd9]);
    jpeg.resize(40_000, 0);
    fs::write(room.path().join("a.jpg"), jpeg).unwrap();
    room.write("a.mtl", "newmtl a\nmap_Kd a.jpg\n");
    let quad = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    room.write("a.obj", quad);
    // 48 MiB of pixels, and twice that of coefficients.
    let parts = ["to decode the texture `a.jpg`", "allows 95.4 MiB"];
    refused_in_400_mb(&room, "info a.obj --max-memory 100M", 1, &parts);
}

/// Writes a glTF of one mesh, in a sparse file of the given number of zeros.
fn write_gltf(room: &TestFolder, zeros: usize, accessors: &serde_json::Value, mode: u32) {
    let primitive = match mode {
        4 => serde_json::json!({"attributes": {"POSITION": 0}}),
        _ => serde_json::json!({"attributes": {"POSITION": 0}, "indices": 1, "mode": mode}),
    };
    let gltf = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": zeros, "uri": "a.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": zeros}],
        "accessors": accessors,
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}]
    });
    let bin = fs::File::create(room.path().join("a.bin")).unwrap();
    bin.set_len(zeros as u64).unwrap();
    room.write("a.gltf", &gltf.to_string());
}

#[test]
fn a_buffer_is_held_once() {
    let room = TestFolder::new();
    let corners = serde_json::json!(
        [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}]
    );
    write_gltf(&room, 60_000_000, &corners, 4);
    let peak = peak(&room, "a.gltf", 90);
    assert!(peak < 90, "{peak}");
}

/// The text exists in the file and in the document, in addition to its parsed content.
#[test]
fn data_in_the_text_counts_with_its_text() {
    let room = TestFolder::new();
    let data = "A".repeat(60_000_000);
    let gltf = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36, "uri": format!("data:;base64,{data}")}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}]
    });
    room.write("a.gltf", &gltf.to_string());
    let parts = ["for the buffers in the text", "allows 152.6 MiB"];
    room.refused("info a.gltf --max-memory 160M", 1, &parts);
    let peak = peak(&room, "a.gltf", 210);
    assert!(peak < 210, "{peak}");
}

/// A strip has about one triangle per one-byte index.
#[test]
fn triangles_of_strips_count_before_they_are_collected() {
    let room = TestFolder::new();
    let strip = serde_json::json!([
        {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
        {"bufferView": 0, "componentType": 5121, "type": "SCALAR", "count": 40_000_000}
    ]);
    write_gltf(&room, 40_000_000, &strip, 5);
    let parts = ["for 39999998 more triangles", "allows 95.4 MiB"];
    refused_in_400_mb(&room, "info a.gltf --max-memory 100M", 1, &parts);
}

/// Three bytes of the file become twelve.
#[test]
fn vertices_of_a_ply_count_before_their_columns_are_made() {
    let room = TestFolder::new();
    let properties = "property char x\nproperty char y\nproperty char z";
    let face = "element face 1\nproperty list uchar uchar vertex_indices";
    let header = format!(
        "ply\nformat binary_little_endian 1.0\n{face}\nelement vertex 30000000\n{properties}\nend_header\n"
    );
    let mut ply = fs::File::create(room.path().join("a.ply")).unwrap();
    std::io::Write::write_all(&mut ply, &[header.as_bytes(), &[3]].concat()).unwrap();
    ply.set_len(header.len() as u64 + 90_000_004).unwrap();
    let parts = ["for the file's vertices", "allows 286.1 MiB"];
    refused_in_400_mb(&room, "info a.ply --max-memory 300M", 1, &parts);
    let peak = peak(&room, "a.ply", 490);
    assert!(peak < 490, "{peak}");
}

#[test]
fn open_transforms_are_bounded() {
    let room = TestFolder::new();
    let deep = |pushes: usize| {
        let pushed = "pushTransform\n".repeat(pushes);
        format!("{SCENE}{pushed}{}", "popTransform\n".repeat(pushes))
    };
    room.write("b.test", &deep(65_536));
    room.ok("info b.test");
    room.write("c.test", &deep(70_000));
    let parts = ["c.test:65552:1: ", "more than 65536 `pushTransform`"];
    let ran = room.run("info c.test");
    assert_eq!(ran.code, Some(3), "{}", ran.stderr);
    for part in parts {
        assert!(ran.stderr.contains(part), "{}", ran.stderr);
    }
    assert_eq!(ran.stderr.matches("error: ").count(), 1, "{}", ran.stderr);
}

/// A device has no length, and no end.
#[test]
fn what_has_no_size_is_read_as_far_as_is_allowed() {
    let room = TestFolder::new();
    for kind in ["test", "obj", "ply"] {
        let line = format!("info /dev/zero --format {kind} --max-memory 60M");
        let parts = ["to read a file of", "--max-memory allows 57.2 MiB"];
        refused_in_400_mb(&room, &line, 1, &parts);
    }
    let stdin = "ulimit -v 400000; exec \"$0\" info - --format test --max-memory 60M </dev/zero";
    let output = Command::new("sh")
        .args(["-c", stdin, env!("CARGO_BIN_EXE_phalanx")])
        .output()
        .unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    // Reading stops as soon as it is too much: a third of the memory that the program leaves.
    assert!(stderr.contains("to read a file of 11.1 MiB"), "{stderr}");
    // A pipe that ends is an ordinary scene.
    let pipe = room.path().join("pipe.test");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let writer = std::thread::spawn(move || fs::write(pipe, SCENE).unwrap());
    room.ok("info pipe.test --max-memory 60M");
    writer.join().unwrap();
}

#[test]
fn devices_are_neither_pictures_nor_records_nor_keyframes() {
    let room = TestFolder::new();
    room.ok("render a.test -o b.png");
    for (line, code, part) in [
        (
            "compare /dev/zero b.png",
            1,
            "not a picture that can be read",
        ),
        ("verify a.test --against /dev/zero", 1, "not a record"),
        (
            "bench report /dev/zero -o r.html",
            1,
            "longer than any record",
        ),
        (
            "render a.test -o c.png --frames 0..1 --keyframes /dev/zero",
            2,
            "not a key frame file: larger than 16.0 MiB",
        ),
    ] {
        refused_in_400_mb(&room, line, code, &[part]);
    }
}

/// Refusal of columns that do not fit, or of the tree in addition to them.
#[test]
fn standard_scenes_beyond_memory_are_errors() {
    let room = TestFolder::new();
    for (line, what) in [
        (
            "info standard:terrain:100M",
            "for the columns and the BVH of 99,",
        ),
        (
            "render standard:hair:100M -o x.png",
            "for the columns and the BVH of 99,",
        ),
        (
            "build standard:menger:40M -o x.phx",
            "for the columns and the BVH of ",
        ),
        (
            "bench standard:atrium:100M",
            "for the columns and the BVH of ",
        ),
        (
            "info standard:teapot:300",
            "for the columns and the BVH of ",
        ),
        ("info standard:cornell:2500k", "to build the BVH of 2,5"),
        (
            "bench standard:cornell:2500k --rays primary",
            "to build the BVH of 2,5",
        ),
    ] {
        refused_in_400_mb(
            &room,
            line,
            1,
            &["error: about ", what, "that much memory is not available"],
        );
    }
    assert!(room.names().is_empty());
}

/// A PLY of one vertex and of faces with byte-sized indices, by the header's type of count.
fn ply(faces: usize, count: &str, body: &[u8]) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list {count} uchar vertex_indices\nend_header\n"
    );
    [header.as_bytes(), &[0; 12], body].concat()
}

/// Two bytes of an OBJ polygon, or one of a PLY polygon, make a triangle.
#[test]
fn triangles_of_polygons_count_before_they_are_made() {
    let room = TestFolder::new();
    let face = format!("f{}\n", " 1".repeat(200));
    room.write("a.obj", &format!("v 0 0 0\n{}", face.repeat(150_000)));
    let mut row = vec![0; 255];
    row[0] = 254;
    fs::write(
        room.path().join("a.ply"),
        ply(120_000, "uchar", &row.repeat(120_000)),
    )
    .unwrap();
    // Without memory, no second pass looks for further errors.
    let full = fs::read_to_string(room.path().join("a.obj")).unwrap();
    room.write("b.obj", &format!("{full}f 1 1 x\n"));
    for scene in ["a.obj", "a.ply", "b.obj"] {
        let line = format!("info {scene} --max-memory 250M");
        let parts = ["for the triangles of the file's faces", "allows 238.4 MiB"];
        refused_in_400_mb(&room, &line, 1, &parts);
    }
}

#[test]
fn faces_of_too_many_corners_are_refused_before_they_are_collected() {
    let room = TestFolder::new();
    room.write("a.obj", &format!("v 0 0 0\nf{}\n", " 1".repeat(30_000_000)));
    let corners = 50_000_000u32;
    let mut body = corners.to_le_bytes().to_vec();
    body.resize(4 + corners as usize, 0);
    fs::write(room.path().join("a.ply"), ply(1, "uint", &body)).unwrap();
    for (scene, count) in [("a.obj", "30000000"), ("a.ply", "50000000")] {
        let part = format!("a face of {count} corners: at most 65536");
        refused_in_400_mb(&room, &format!("info {scene}"), 3, &[&part]);
    }
}
