//! No result replaces a file that the command reads.

use super::TestFolder;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;

const OBJ: &str =
    "mtllib q.mtl\nusemtl m\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n";

const GLTF: &str = r#"{
  "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
  "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
  "textures": [{"source": 0}], "images": [{"uri": "truck.png"}, {"uri": "%73pare.png"}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
    {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
  "buffers": [{"uri": "g.png", "byteLength": 60}]
}"#;

/// A folder with an input of every kind.
fn furnished() -> TestFolder {
    let room = TestFolder::new();
    let small = "--size 8x6";
    room.write("truck.obj", OBJ);
    let mtl = "newmtl m\nKd 1 1 1\nmap_Kd truck.png\nnewmtl n\nmap_Bump -bm 2 C:\\x\\bump.png\n";
    room.write("q.mtl", mtl);
    let ply = "ply\nformat ascii 1.0\ncomment TextureFile left.png\nelement vertex 3\nproperty float x\n\
               property float y\nproperty float z\nelement face 1\n\
               property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    room.write("left.ply", ply);
    room.write("truck.gltf", GLTF);
    // Extensions are only names: buffers, too, may have any.
    let corners = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1].map(|n| n as f32);
    let bytes: Vec<u8> = corners.iter().flat_map(|n| n.to_le_bytes()).collect();
    fs::write(room.path().join("g.png"), bytes).unwrap();
    for name in ["truck.png", "a.png", "b.png"] {
        room.ok(&format!("render a.test {small} -o {name}"));
    }
    room.write("keys", "0 0 0 5 0 0 0 0 1 0 45\n9 0 0 6 0 0 0 0 1 0 45\n");
    room.ok(&format!(
        "plan a.test {small} --shards 1 -o p.png --plan p.json"
    ));
    room.ok("render --plan p.json --shard 0");
    room.ok(&format!(
        "verify a.test {small} --threads 1 --record h.json"
    ));
    let bench = "bench truck.obj --size 16x16 --rays primary --threads 1 --repeat 1";
    room.ok(&format!("{bench} --json r.json"));
    room.ok("build truck.obj -o c.phx");
    room.ok("render a.test --size 4x2 -o sky.pfm");
    // Named, but not shown: by an unused material, an image without a texture, a comment.
    for name in ["bump.png", "spare.png", "left.png"] {
        fs::copy(room.path().join("a.png"), room.path().join(name)).unwrap();
    }
    room
}

/// The bytes of every file, following links.
fn files(room: &TestFolder) -> BTreeMap<String, Vec<u8>> {
    let bytes = |name: String| {
        (
            name.clone(),
            fs::read(room.path().join(name)).unwrap_or_default(),
        )
    };
    room.names()
        .into_iter()
        .chain(["a.test".to_owned()])
        .map(bytes)
        .collect()
}

/// Command lines with `OUT` for a result, the option that names it, and all inputs.
const LINES: [(&str, &str, &str); 26] = [
    (
        "render left.ply -o OUT.png",
        "--output",
        "left.ply left.png",
    ),
    (
        "render truck.obj -o OUT.png",
        "--output",
        "truck.obj q.mtl truck.png bump.png",
    ),
    (
        "render truck.gltf -o OUT.exr",
        "--output",
        "truck.gltf g.png truck.png spare.png",
    ),
    ("render c.phx -o OUT.png", "--output", "c.phx"),
    (
        "render a.test --environment sky.pfm -o OUT.png",
        "--output",
        "a.test sky.pfm",
    ),
    (
        "render truck.obj --heat nodes OUT.png",
        "--heat",
        "truck.obj q.mtl truck.png",
    ),
    (
        "render truck.obj --snapshot OUT.png",
        "--snapshot",
        "truck.png",
    ),
    (
        "render truck.obj --checkpoint OUT",
        "--checkpoint",
        "truck.obj q.mtl truck.png",
    ),
    (
        "render truck.obj -o OUT.#.png --frames 3..9 --keyframes keys",
        "--output",
        "keys truck.png",
    ),
    (
        "render a.test --checkpoint OUT.# --frames 1..9 --keyframes keys",
        "--checkpoint",
        "keys a.test",
    ),
    (
        "compare a.png b.png --heat OUT.png",
        "--heat",
        "a.png b.png",
    ),
    (
        "compare a.png b.png --side-by-side OUT.png",
        "--side-by-side",
        "a.png b.png",
    ),
    (
        "build truck.gltf -o OUT.phx",
        "--output",
        "truck.gltf g.png truck.png",
    ),
    ("build c.phx -o OUT.phx", "--output", "c.phx"),
    (
        "plan truck.obj --shards 2 -o x.png --plan OUT",
        "--plan",
        "truck.obj q.mtl truck.png",
    ),
    (
        "plan truck.obj --shards 2 -o OUT.png --plan y.json",
        "--output",
        "truck.obj truck.png",
    ),
    (
        "plan truck.obj --shards 2 -o OUT.#.png --plan y.json --frames 3..9 --turntable 9",
        "--output",
        "truck.png",
    ),
    (
        "merge p.json -o OUT.png",
        "--output",
        "p.json a.test p.shard-0.tiles",
    ),
    (
        "submit slurm p.json --dry-run -o OUT.png",
        "--output",
        "p.json a.test p.shard-0.tiles",
    ),
    (
        "verify a.test truck.obj --record OUT",
        "--record",
        "a.test truck.obj",
    ),
    ("verify truck.obj --record OUT", "--record", "truck.png"),
    (
        "verify a.test --against h.json --record OUT",
        "--record",
        "h.json",
    ),
    (
        "bench truck.obj --json OUT --baseline r.json",
        "--json",
        "truck.obj truck.png r.json",
    ),
    (
        "bench truck.obj --csv c.csv --html OUT",
        "--html",
        "truck.obj q.mtl",
    ),
    (
        "bench truck.obj --dump-rays OUT",
        "--dump-rays",
        "truck.obj truck.png",
    ),
    ("bench report r.json -o OUT", "--output", "r.json"),
];

#[test]
fn no_result_takes_the_place_of_an_input() {
    let room = furnished();
    let before = files(&room);
    for (line, option, inputs) in LINES {
        for input in inputs.split(' ') {
            let ending = line.split("OUT").nth(1).unwrap().split(' ').next().unwrap();
            let link = room.path().join(format!("out{}", ending.replace('#', "7")));
            let line = line.replace("OUT", "./out");
            fs::hard_link(room.path().join(input), &link).unwrap();
            room.refused(&line, 2, &[option, "would overwrite", input]);
            fs::remove_file(&link).unwrap();
            symlink(input, &link).unwrap();
            room.refused(&line, 2, &[option, "would overwrite", input]);
            fs::remove_file(&link).unwrap();
            assert_eq!(files(&room), before, "{line} {input}");
        }
    }
    for (line, parts) in [
        (
            "compare a.png b.png --heat a.png",
            "--heat a.png would overwrite the picture a.png",
        ),
        (
            "plan a.test --shards 2 -o x.png --plan a.test",
            "--plan a.test would overwrite the scene a.test",
        ),
        (
            "bench compare r.json r.json --html ./r.json",
            "--html ./r.json would overwrite the record r.json",
        ),
    ] {
        room.refused(line, 2, &[parts]);
    }
    assert_eq!(files(&room), before);
}

#[test]
fn a_default_name_that_an_input_has_is_left_to_it() {
    let room = furnished();
    let before = fs::read(room.path().join("truck.png")).unwrap();
    let output = room.run("render truck.obj --size 8x6");
    assert!(
        output
            .stderr
            .contains("truck.png: writing truck-render.png instead"),
        "{}",
        output.stderr
    );
    assert!(
        output.stdout.contains("truck-render.png: 8x6"),
        "{}",
        output.stdout
    );
    assert_eq!(fs::read(room.path().join("truck.png")).unwrap(), before);
    // The scene's own name for it, two inputs in the way, and frames.
    fs::copy(
        room.path().join("truck.png"),
        room.path().join("truck.0001.png"),
    )
    .unwrap();
    fs::hard_link(
        room.path().join("truck.obj"),
        room.path().join("truck-render.0002.png"),
    )
    .unwrap();
    room.write("q.mtl", "newmtl m\nmap_Kd truck.0001.png\n");
    let json = room.json("render truck.obj --size 8x6 --frames 0..2 --turntable 3 --json");
    assert_eq!(json["image"]["path"], "truck-render-render.0000.png");
    assert_eq!(
        fs::read(room.path().join("truck.0001.png")).unwrap(),
        before
    );
}

/// A cache does not store the names of its textures.
#[test]
fn a_default_name_that_another_programs_picture_has_is_left_to_it() {
    let room = TestFolder::new();
    room.write("truck.obj", OBJ);
    room.write("q.mtl", "newmtl m\nKd 1 1 1\nmap_Kd truck.png\n");
    let texture = include_bytes!("../../pictures/interlaced.png");
    fs::write(room.path().join("truck.png"), texture).unwrap();
    room.ok("build truck.obj -o truck.phx");
    // The second time, the first run's picture is there, which is our own.
    for _ in 0..2 {
        let output = room.run("render truck.phx --size 8x6");
        let note = "truck.png is a picture from another program: writing truck-render.png instead";
        assert!(output.stderr.contains(note), "{}", output.stderr);
        assert!(output.stdout.contains("truck-render.png: 8x6"));
    }
    assert_eq!(fs::read(room.path().join("truck.png")).unwrap(), texture);
}

#[test]
fn inputs_that_stand_for_others_are_named_by_every_command() {
    let room = TestFolder::new();
    room.write(
        "lfs",
        "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
    );
    fs::write(room.path().join("gz"), b"\x1f\x8b\x08\0\0").unwrap();
    room.ok("render a.test --size 8x6 -o a.png");
    for (name, words) in [("lfs", "git lfs pull"), ("gz", "compressed with gzip")] {
        for line in [
            format!("compare a.png {name}"),
            format!("render --plan {name} --shard 0"),
            format!("render a.test --size 8x6 --keyframes {name} -o f.png"),
            format!("verify a.test --size 8x6 --against {name}"),
            format!("bench a.test --size 8x6 --baseline {name}"),
            format!("bench compare {name} {name}"),
            format!("render {name} -o f.png"),
        ] {
            room.refused(&line, 1, &[&format!("cannot read {name}: "), words]);
        }
    }
}
