//! Files next to a scene, scene caches in its place, and limits on its memory.

use super::{SCENE, TestFolder};
use std::fs;

/// The pixels of the picture made by a command line. Its file also names the scene.
fn picture(room: &TestFolder, line: &str) -> Vec<[u16; 4]> {
    room.ok(&format!("render {line} -o out.png"));
    let picture = phalanx::image::load(&room.path().join("out.png")).unwrap();
    assert!(picture.width > 0 && picture.height > 0);
    picture.pixels
}

#[test]
fn a_cache_stands_for_its_scene_in_every_command() {
    let room = TestFolder::new();
    let built = room.json("build a.test -o a.phx --json");
    assert_eq!(built["primitives"]["triangles"], 1);
    let length = fs::metadata(room.path().join("a.phx")).unwrap().len();
    assert_eq!(built["file_bytes"], length);
    assert!(
        room.ok("build a.test -o b.phx --quality best")
            .contains("b.phx")
    );
    assert_eq!(room.names(), ["a.phx", "b.phx"]);
    assert_eq!(picture(&room, "a.phx"), picture(&room, "a.test"));
    let scalar = picture(&room, "a.phx --engine scalar");
    assert_eq!(scalar, picture(&room, "a.test"));
    let verified = room.ok("verify a.phx --threads 1,2 --kernel all");
    assert!(verified.contains("identical"), "{verified}");
    let (ours, theirs) = (
        room.json("info a.phx --json"),
        room.json("info a.test --json"),
    );
    for key in [
        "image",
        "primitives",
        "lights",
        "materials",
        "bounds",
        "bvh",
    ] {
        assert_eq!(ours[key], theirs[key], "{key}");
    }
    assert_eq!(ours["memory"]["mapped_bytes"], length);
    assert_eq!(theirs["memory"]["mapped_bytes"], 0);
    // A cache can be made from a cache, and is the same.
    room.ok("build a.phx -o c.phx");
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    assert_eq!(bytes("c.phx"), bytes("a.phx"));
}

/// A square of glTF, seen from behind.
#[test]
fn backs_of_single_sided_materials_are_passed_and_counted() {
    let room = TestFolder::new();
    room.write("back.gltf", BACK);
    room.write("both.gltf", &BACK.replace("{}", r#"{"doubleSided": true}"#));
    let camera = "--camera 0,0,4 0,0,0 0,1,0 40 --light dir:0,0,1 --size 16x16";
    let [back, both] =
        ["back", "both"].map(|name| picture(&room, &format!("{name}.gltf {camera}")));
    assert!(back.iter().all(|pixel| *pixel == back[0]));
    assert_ne!(back, both);
    let line = format!("back.gltf {camera} --two-sided");
    assert_eq!(picture(&room, &line), both);
    let report = room.ok(&format!("render back.gltf {camera} -o out.png"));
    assert!(
        report.contains("hidden, of single-sided materials (see --two-sided)"),
        "{report}"
    );
    let json = room.json(&format!("render back.gltf {camera} -o out.png --json"));
    assert!(json["unseen_backs"].as_u64().unwrap() > 20, "{json}");
    let report = room.ok(&format!("render both.gltf {camera} -o out.png"));
    assert!(!report.contains("backs"), "{report}");
    // A cache has the sides of its file, and the header of a picture the option.
    room.ok("build back.gltf -o back.phx");
    assert_eq!(picture(&room, &format!("back.phx {camera}")), back);
    assert_eq!(
        picture(&room, &format!("back.phx {camera} --two-sided")),
        both
    );
    let written =
        String::from_utf8_lossy(&fs::read(room.path().join("out.png")).unwrap()).into_owned();
    assert!(written.contains("--two-sided"), "{written}");
    room.ok(&format!("verify back.gltf {camera} --kernel all"));
    // Tiles of one do not belong to the other.
    room.ok(&format!(
        "render back.gltf {camera} --checkpoint c.tiles -o out.png"
    ));
    let other = format!("render back.gltf {camera} --two-sided --checkpoint c.tiles -o out.png");
    room.refused(&other, 2, &["the scene's fingerprint is "]);
}

/// An octahedron whose normals are those of a sphere.
#[test]
fn meshes_with_normals_have_smooth_terminators() {
    let room = TestFolder::new();
    let points = ["1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1", "0 0 -1"];
    let lines = |word: &str| points.map(|p| format!("{word} {p}\n")).concat();
    let faces = (0..8).map(|k| {
        let [x, y, z] = [1 + (k & 1), 3 + (k >> 1 & 1), 5 + (k >> 2)];
        format!("f {x}//{x} {y}//{y} {z}//{z}\n")
    });
    let faces: String = faces.collect();
    room.write("a.obj", &format!("{}{}{faces}", lines("v"), lines("vn")));
    let options = "--camera 0,0,6 0,0,0 0,1,0 30 --light dir:1,.4,-.3 --size 64x64";
    let smooth = picture(&room, &format!("a.obj {options}"));
    let faceted = format!("a.obj {options} --terminator faceted");
    assert!(smooth != picture(&room, &faceted));
    assert!(smooth == picture(&room, &format!("a.obj {options} --terminator smooth")));
    room.ok(&format!("render {faceted} -o out.png"));
    let written =
        String::from_utf8_lossy(&fs::read(room.path().join("out.png")).unwrap()).into_owned();
    assert!(written.contains("--terminator faceted"), "{written}");
    room.refused(
        &format!("render a.obj {options} --terminator round -o out.png"),
        2,
        &["round", "smooth", "faceted"],
    );
    for terminator in ["smooth", "faceted"] {
        room.ok(&format!(
            "verify a.obj {options} --terminator {terminator} --kernel all"
        ));
        // A cache has the terminator that it was built with.
        room.ok(&format!("build a.obj --terminator {terminator} -o a.phx"));
        let own = picture(&room, &format!("a.phx {options}"));
        assert!(own == picture(&room, &format!("a.obj {options} --terminator {terminator}")));
        assert!(smooth == picture(&room, &format!("a.phx {options} --terminator smooth")));
    }
    // Tiles of one do not belong to the other.
    room.ok(&format!(
        "render a.obj {options} --checkpoint c.tiles -o out.png"
    ));
    let other = format!("render {faceted} --checkpoint c.tiles -o out.png");
    room.refused(&other, 2, &["the scene's fingerprint is "]);
}

/// A square whose back points to +z.
const BACK: &str = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0, "rotation": [0, 1, 0, 0]}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
"materials": [{}],
"buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAACAPwAAgD8AAAAAAACAvwAAgD8AAAAAAAABAAIAAAACAAMA"}],
"bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
{"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]}"#;

#[test]
fn what_stands_beside_a_cache_changes_it_like_a_file() {
    let room = TestFolder::new();
    room.ok("build a.test -o a.phx");
    let plain = picture(&room, "a.test");
    for options in [
        "--camera 0,1,6 0,0,0 0,1,0 30",
        "--light 0,5,5 --light dir:1,1,1,.5,.5,.6",
        "--background .2,.3,.4",
    ] {
        let (file, cache) = (
            picture(&room, &format!("{options} a.test")),
            picture(&room, &format!("a.phx {options}")),
        );
        assert_eq!(file, cache, "{options}");
        assert_ne!(file, plain, "{options}");
    }
    let ran = room.run("info a.phx --material kd=1 --quality fast");
    assert!(
        ran.stderr.contains("--material has no effect"),
        "{}",
        ran.stderr
    );
    assert!(
        ran.stderr
            .contains("--quality has no effect on a scene cache"),
        "{}",
        ran.stderr
    );
}

/// A scene beyond f32's comfortable range is stored scaled; positions are still in the file's
/// units.
#[test]
fn places_beside_a_scaled_cache_are_those_of_the_file() {
    let room = TestFolder::new();
    room.write(
        "huge.test",
        "size 24 16\ncamera 0 0 5e12 0 0 0 0 1 0 45\npoint 3e12 3e12 3e12 1 1 1\ndiffuse 1 1 1\nsphere 0 0 0 1e12\n",
    );
    room.ok("build huge.test -o huge.phx");
    let options = "--camera 1e12,0,6e12 0,0,0 0,1,0 40 --light 5e12,1e12,5e12";
    let file = picture(&room, &format!("huge.test {options}"));
    assert_eq!(file, picture(&room, &format!("huge.phx {options}")));
    assert_ne!(file, picture(&room, "huge.phx"));
    // Beyond the range of the stored scene.
    let far = "--camera 0,0,1e22 0,0,0 0,1,0 .00000001";
    let file = picture(&room, &format!("huge.test {far}"));
    assert_eq!(file, picture(&room, &format!("huge.phx {far}")));
    assert!(file.iter().any(|byte| *byte != file[file.len() - 1]));
    room.ok("info standard:balls:1 --light 1e9,0,0");
}

#[test]
fn nonsense_beside_a_scene_is_2() {
    let room = TestFolder::new();
    for command in ["render", "verify", "info", "build -o a.phx"] {
        for (options, part) in [
            ("--camera 0,0,5 0,0,0 0,1,0", "--camera"),
            ("--camera 0,0,5 0,0,0 0,1,0 x", "`x` is not a number"),
            ("--camera 0,5 0,0,0 0,1,0 45", "three numbers for FROM"),
            ("--camera 0,0,5 0,0,0 0,1,0 200", "field of view"),
            ("--light 1,2", "X,Y,Z"),
            ("--light dir:0,0,0", "direction"),
            ("--background red", "expected R,G,B"),
            ("--background -1,0,0", ""),
            ("--material kd", "KEY=VALUE"),
            ("--material glow=1", "unknown material key `glow`"),
            ("--max-memory lots", "500M"),
            ("--allow-path none", "--allow-path"),
            ("--allow-path a.test", "not a folder"),
            ("--quality good", "medium"),
        ] {
            room.refused(
                &format!("{command} a.test {options}"),
                2,
                &["error: ", part],
            );
        }
    }
}

#[test]
fn a_further_folder_is_opened_for_every_command() {
    let room = TestFolder::new();
    fs::create_dir_all(room.path().join("scene")).unwrap();
    fs::create_dir_all(room.path().join("textures")).unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    room.write(
        "scene/a.obj",
        &format!("mtllib ../textures/a.mtl\n{triangle}"),
    );
    room.write("textures/a.mtl", "newmtl m\nmap_Kd a.png\n");
    fs::write(room.path().join("textures/a.png"), white_png(8)).unwrap();
    for command in [
        "render -o a.png --size 8x8",
        "verify --size 8x8",
        "info",
        "build -o a.phx",
    ] {
        let closed = room.run(&format!("{command} scene/a.obj"));
        let reason = "not in the scene file's folder (--allow-path";
        assert!(closed.stderr.contains(reason), "{}", closed.stderr);
        let opened = room.run(&format!("{command} scene/a.obj --allow-path textures"));
        assert_eq!(opened.code, Some(0), "{}", opened.stderr);
        assert!(!opened.stderr.contains("left out"), "{}", opened.stderr);
    }
}

#[test]
fn caches_that_cannot_be_used_are_3_and_say_what_to_do() {
    let room = TestFolder::new();
    room.ok("build a.test -o a.phx");
    let good = fs::read(room.path().join("a.phx")).unwrap();
    let write = |bytes: &[u8]| {
        // Replaced, not written into.
        fs::remove_file(room.path().join("a.phx")).unwrap();
        fs::write(room.path().join("a.phx"), bytes).unwrap();
    };
    let help = "phalanx build SCENE -o a.phx";
    for command in ["render", "verify", "info"] {
        let line = format!("{command} a.phx");
        let mut bad = good.clone();
        // Bytes other than zero are not in a gap.
        let last = bad.iter().rposition(|&b| b != 0).unwrap();
        bad[last] ^= 4;
        write(&bad);
        room.refused(&line, 3, &["error: a.phx: ", "checksum", help]);
        write(&[&good[..], b"more"].concat());
        room.refused(&line, 3, &["error: a.phx: ", "surplus bytes after", help]);
        write(&good[..good.len() - 7]);
        room.refused(&line, 3, &["error: a.phx: ", "cut off", help]);
        let mut bad = good.clone();
        bad[12] = 77;
        write(&bad);
        room.refused(&line, 3, &["error: a.phx: ", "version 77", help]);
        write(SCENE.as_bytes());
        room.refused(&line, 3, &["error: a.phx: not a scene cache", help]);
        write(b"");
        room.refused(&line, 3, &["error: a.phx: not a scene cache", help]);
        room.refused(&format!("{command} none.phx"), 1, &["cannot read none.phx"]);
    }
}

#[test]
fn a_cache_goes_where_it_can_or_nowhere() {
    let room = TestFolder::new();
    room.refused("build a.test -o a.cache", 2, &["must end in .phx"]);
    room.refused("build a.test", 2, &["--output"]);
    room.refused("build none.test -o a.phx", 1, &["cannot read none.test"]);
    room.refused(
        "build a.test -o none/a.phx",
        1,
        &["there is no folder none"],
    );
    room.write("bad.test", "size 4");
    room.refused("build bad.test -o a.phx", 3, &["bad.test"]);
    // An existing file stays if there is nothing to replace it.
    room.write("old.phx", "old");
    room.refused("build bad.test -o old.phx", 3, &["bad.test"]);
    assert_eq!(fs::read(room.path().join("old.phx")).unwrap(), b"old");
    room.ok("build a.test -o old.phx");
    room.ok("info old.phx");
}

#[test]
fn memory_is_told_part_by_part() {
    let room = TestFolder::new();
    let info = room.json("info a.test --json");
    let memory = &info["memory"];
    let number = |key: &str| memory[key].as_u64().unwrap_or_else(|| panic!("{key}"));
    let parts = memory["scene_parts"].as_object().unwrap();
    let sum: u64 = parts.values().map(|v| v.as_u64().unwrap()).sum();
    assert_eq!(sum, number("scene_bytes"));
    let rest = number("scene_bytes") + number("bvh_node_bytes") + number("bvh_primitive_bytes");
    assert_eq!(number("total_bytes"), rest);
    let each = memory["bytes_per_primitive"].as_f64().unwrap();
    assert!((each - rest as f64 / 3.0).abs() < 1e-9, "{each}");
    let render = room.json("render a.test -o a.png --json");
    assert_eq!(render["memory"]["film_bytes"], 40 * 24 * (12 + 12));
    assert_eq!(render["memory"]["scene_bytes"], memory["scene_bytes"]);
    for line in ["render a.test -o a.png -v", "info a.test"] {
        let table = room.ok(line);
        for part in ["tree nodes", "vertices", "bytes each"] {
            assert!(table.contains(part), "{line}: {part} in\n{table}");
        }
    }
}

/// Refusal before any allocation of that size, in an address space that is too small for it.
#[test]
fn memory_beyond_what_is_allowed_is_refused_with_both_numbers() {
    let room = TestFolder::new();
    // One holds whole films, the other some bands of one.
    for (command, unit, allowed) in [("verify", "GiB", 300), ("render -o b.png", "MiB", 100)] {
        let line = format!("{command} a.test --size 16384x16384 --max-memory {allowed}MiB");
        let ran = room.run_in_400_mb(&line);
        assert_eq!(ran.code, Some(1), "{line}: {}", ran.stderr);
        let needed = format!("{unit} needed");
        let allowed = format!("{allowed}.0 MiB");
        for part in ["error: about ", &needed, "16384x16384", &allowed] {
            assert!(ran.stderr.contains(part), "{line}: {}", ran.stderr);
        }
    }
    // A sparse file: it takes no space on disk, but 30 GB once read.
    let sparse = |name: &str| {
        let file = fs::File::create(room.path().join(name)).unwrap();
        file.set_len(10_000_000_000).unwrap();
    };
    sparse("large.test");
    sparse("large.phx");
    for command in ["render", "verify", "info", "build -o c.phx"] {
        let parts = ["to read a file of 9.3 GiB", "--max-memory allows 1.9 GiB"];
        room.refused(&format!("{command} large.test --max-memory 2G"), 1, &parts);
        room.refused(&format!("{command} large.phx --max-memory 2G"), 1, &parts);
    }
    room.ok("render a.test -o b.png --max-memory 1GiB");
    let spheres = "sphere 0 0 0 1\n".repeat(200_000);
    room.write(
        "many.test",
        &format!("size 8 8\ncamera 0 0 5 0 0 0 0 1 0 45\n{spheres}"),
    );
    let parts = ["to build the BVH of 200,000 primitives", "48.0 MiB"];
    room.refused("info many.test --max-memory 48MiB", 1, &parts);
    room.refused("build many.test -o c.phx --max-memory 48MiB", 1, &parts);
}

/// A PNG of white pixels with one bit each.
fn white_png(side: u32) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let mut writer = encoder.write_header().unwrap();
    let bytes = side as usize / 8 * side as usize;
    writer.write_image_data(&vec![0xff; bytes]).unwrap();
    drop(writer);
    out
}

/// A few kilobytes of PNG decode to hundreds of megabytes of texels.
#[test]
fn textures_and_copies_count_before_they_are_made() {
    let room = TestFolder::new();
    let quad = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
    let mtl = |k: u32| format!("newmtl m{k}\nmap_Kd t{k}.png\n");
    let face = |k: u32| format!("usemtl m{k}\nf 1/1 2/2 3/3\n");
    let joined =
        |count: u32, part: &dyn Fn(u32) -> String| (0..count).map(part).collect::<String>();
    room.write("a.mtl", &joined(9, &mtl));
    room.write("one.obj", &format!("{quad}{}", face(0)));
    room.write("nine.obj", &format!("{quad}{}", joined(9, &face)));
    for k in 0..9 {
        fs::write(room.path().join(format!("t{k}.png")), white_png(2048)).unwrap();
    }
    let small = "--size 8x8 --max-memory 50MiB";
    room.ok(&format!("render one.obj -o a.png {small}"));
    let parts = ["to decode the texture `t2.png`", "allows 50.0 MiB"];
    room.refused(&format!("render nine.obj -o a.png {small}"), 1, &parts);
    room.ok("render nine.obj -o a.png --size 8x8 --max-memory 250MiB");

    let huge = white_png(8192);
    fs::write(room.path().join("t0.png"), &huge).unwrap();
    let image = serde_json::json!({"bufferView": 1});
    let gltf = |image: &serde_json::Value| {
        serde_json::json!({
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": 60 + huge.len(), "uri": "a.bin"}],
            "bufferViews": [
                {"buffer": 0, "byteLength": 60},
                {"buffer": 0, "byteOffset": 60, "byteLength": huge.len()}
            ],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
                {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "type": "VEC2", "count": 3}
            ],
            "images": [image],
            "textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
            "nodes": [{"mesh": 0}]
        })
    };
    let corners = [
        0.0f32, 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1.,
    ];
    let mut buffer: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    buffer.extend(&huge);
    fs::write(room.path().join("a.bin"), buffer).unwrap();
    room.write("view.gltf", &gltf(&image).to_string());
    let named = serde_json::json!({"uri": "t0.png"});
    room.write("named.gltf", &gltf(&named).to_string());
    for scene in ["one.obj", "view.gltf", "named.gltf"] {
        let ran = room.run_in_400_mb(&format!("info {scene} --max-memory 100M"));
        assert_eq!(ran.code, Some(1), "{scene}: {}", ran.stderr);
        for part in ["to decode the texture", "8192×8192", "allows 95.4 MiB"] {
            assert!(ran.stderr.contains(part), "{scene}: {}", ran.stderr);
        }
    }
}

/// A room of mirrors or glass, and a ball in it, of great depth.
fn deep_room(specular: &str, transmission: &str) -> String {
    format!(
        "size 64 64\ncamera 0 0 5 0 0 0 0 1 0 45\nmaxdepth 1000\nspecular {specular}\ntransmission {transmission}\n\
         ior 1.2\nsphere 0 0 0 9\nsphere 1 0 0 1\npoint 0 0 4 1 1 1\n"
    )
}

/// For any depth, tile size and engine.
#[test]
fn what_is_rendered_stays_below_what_is_allowed() {
    let room = TestFolder::new();
    room.write("mirrors.test", &deep_room("1 1 1", "0 0 0"));
    room.write("glass.test", &deep_room("0.8 0.7 0.9", "0.1 0.1 0.1"));
    let mut rendered = 0;
    for options in [
        "",
        "--tile 64",
        "--size 8x8 --engine scalar",
        "--spp 4 --size 32x32",
    ] {
        for scene in ["mirrors", "glass"] {
            for allowed in [40_000_000, 50_000_000, 80_000_000] {
                let line = format!(
                    "render {scene}.test -o b.png --threads 2 {options} --max-memory {allowed} --json"
                );
                let ran = room.run(&line);
                if ran.code == Some(1) {
                    assert!(ran.stderr.contains(" needed "), "{}", ran.stderr);
                    continue;
                }
                assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
                let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
                let peak = report["memory"]["peak_rss_bytes"].as_u64().unwrap();
                assert!(peak < allowed, "{line}: {peak}");
                rendered += 1;
            }
        }
    }
    assert!(
        rendered >= 16,
        "{rendered} were rendered, the others refused"
    );
}

#[test]
fn rays_of_little_weight_are_left_out_where_depth_does_not_bound_them() {
    let room = TestFolder::new();
    room.write("glass.test", &deep_room("0.5 0.5 0.5", "0.5 0.5 0.5"));
    let bounces = |options: &str| {
        let report = room.json(&format!(
            "render glass.test -o b.png --size 8x8 --json {options}"
        ));
        let kinds = ["reflection", "refraction"].map(|k| report["rays"][k].as_u64().unwrap());
        kinds[0] + kinds[1]
    };
    let all = bounces("--max-depth 10");
    assert_eq!(bounces("--max-depth 10 --min-weight 0"), all);
    assert!(bounces("--max-depth 10 --min-weight 0.1") < all / 4);
    assert_eq!(bounces(""), bounces("--min-weight 0.000244140625"));
    room.ok("verify glass.test --size 16x12 --min-weight 0.01 --threads 1,2 --aov all");
    for weight in ["1", "-0.5", "nan", "little"] {
        let line = format!("render a.test -o c.png --min-weight {weight}");
        room.refused(
            &line.replace("--min-weight -", "--min-weight=-"),
            2,
            &["0.001"],
        );
    }
}

#[test]
fn standard_scenes_are_opened_like_files() {
    let room = TestFolder::new();
    let small = "--size 40x40 --max-depth 1";
    let direct = picture(&room, &format!("standard:balls:2 {small}"));
    room.ok("build standard:balls:2 -o balls.phx");
    let cached = picture(&room, &format!("balls.phx {small}"));
    assert_eq!(cached, direct);
    let options = "--background 0,0,.5 --light dir:0,0,1";
    let other = picture(&room, &format!("standard:balls:2 {small} {options}"));
    assert_ne!(other, direct);
    assert_eq!(
        picture(&room, &format!("balls.phx {small} {options}")),
        other
    );
    for command in ["render", "verify", "info", "build -o c.phx"] {
        room.refused(&format!("{command} standard:bals"), 2, &["balls"]);
        room.refused(&format!("{command} standard:balls:x"), 2, &["size"]);
        // (9^7 - 1) / 8 balls: their memory is known before any is made.
        let parts = [
            "for the columns and the BVH of 597,87",
            "--max-memory allows 47.7 MiB",
        ];
        let line = format!("{command} standard:balls:6 --max-memory 50M");
        room.refused(&line, 1, &parts);
    }
}
