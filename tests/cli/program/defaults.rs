//! Defaults of pictures where neither the file nor an option says anything, option by option; and
//! the camera that is told.

use super::TestFolder;
use serde_json::{Value, json};
use std::fs;

/// A step in front of a wall, with corners on all sides of the middle.
const STEP: &str = "\
v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 1.5 -1\nv 1 1.5 -1\nv .3 .4 .2\nv -.2 .7 .1\nv .1 .1 .9
f 1 2 3 4\nf 1 2 6 5\nf 7 8 9\n";

/// A triangle, seen by a camera of parallel rays; with `light`, in the light of a lamp of its own.
fn gltf(light: bool) -> String {
    let mut nodes = vec![
        json!({"mesh": 0}),
        json!({"camera": 0, "translation": [0.3, 0.4, 3]}),
    ];
    if light {
        nodes.push(json!({"extensions": {"KHR_lights_punctual": {"light": 0}}}));
    }
    let lamps = json!([{"type": "directional", "intensity": 1}]);
    json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": Vec::from_iter(0..nodes.len())}], "nodes": nodes,
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": 1.3, "ymag": 1.1, "znear": 0, "zfar": 9}}],
        "extensions": {"KHR_lights_punctual": {"lights": lamps}},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "t.bin"}],
    })
    .to_string()
}

fn room() -> TestFolder {
    let room = TestFolder::new();
    room.write("s.obj", STEP);
    room.write("n.nff", "s 0 0 0 1\ns .8 .8 .3 .7\n");
    let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes = corners.map(f32::to_le_bytes).concat();
    fs::write(room.path().join("t.bin"), bytes).unwrap();
    room.write("c.gltf", &gltf(false));
    room.write("l.gltf", &gltf(true));
    room
}

/// The report of a picture, and its pixels.
struct Rendering {
    report: Value,
    lights: Value,
    bytes: Vec<u8>,
}

impl Rendering {
    fn of(room: &TestFolder, scene: &str, options: &str) -> Rendering {
        let size = if options.contains("--size") { "" } else { "--size 40x30" };
        let report = room.json(&format!(
            "render {scene} -o out.pfm {size} {options} --json"
        ));
        let scene_options = options.split("--size").next().unwrap();
        let scene_options = scene_options.split("--spp").next().unwrap();
        let described = room.json(&format!("info {scene} {scene_options} --json"));
        Rendering {
            report,
            lights: described["lights"].clone(),
            bytes: fs::read(room.path().join("out.pfm")).unwrap(),
        }
    }

    fn camera(&self) -> &str {
        self.report["camera"]["options"].as_str().unwrap()
    }
}

#[test]
fn each_option_changes_what_it_says_and_nothing_else() {
    let room = room();
    let lamps = |point, directional| json!({"point": point, "directional": directional, "sphere": 0, "rectangle": 0});
    for (scene, spp, lights) in [
        ("s.obj", 4, lamps(1, 1)),
        ("c.gltf", 4, lamps(1, 1)),
        ("l.gltf", 4, lamps(0, 1)),
        ("n.nff", 1, lamps(1, 1)),
        ("a.test", 1, lamps(1, 1)),
        ("standard:tetra:2", 1, lamps(1, 0)),
    ] {
        let plain = Rendering::of(&room, scene, "");
        assert_eq!(
            (&plain.report["spp"], &plain.lights),
            (&json!(spp), &lights),
            "{scene}"
        );
        // The camera that is told is the camera that was used.
        let again = Rendering::of(&room, scene, plain.camera());
        assert_eq!(again.camera(), plain.camera(), "{scene}");
        assert!(again.bytes == plain.bytes, "{scene}: {}", plain.camera());
        let camera = "--camera 2,3,4 0,.5,0 0,1,0 50";
        for (option, has_lights, has_spp) in [
            (camera, lights.clone(), spp),
            ("--light 3,3,3", lamps(1, 0), spp),
            ("--headlight", lamps(1, 1), spp),
            ("--background .2,.3,.4", lights.clone(), spp),
            ("--spp 9", lights.clone(), 9),
        ] {
            let other = Rendering::of(&room, scene, option);
            assert_eq!(other.report["spp"], has_spp, "{scene} {option}");
            assert_eq!(other.lights, has_lights, "{scene} {option}");
            let same_camera = other.camera() == plain.camera();
            assert_eq!(same_camera, option != camera, "{scene} {option}");
            let both = format!("{option} {camera}");
            if option != camera {
                assert_eq!(
                    Rendering::of(&room, scene, &both).lights,
                    has_lights,
                    "{scene}"
                );
            }
        }
    }
}

#[test]
fn a_camera_that_is_told_gives_the_same_picture_to_the_bit() {
    let room = room();
    let moved = |text: &str, change: &dyn Fn(f64, usize) -> f64| {
        let lines = text.lines().map(|line| match line.strip_prefix("v ") {
            None => line.to_owned(),
            Some(place) => {
                let numbers = place.split(' ').map(|c| c.parse::<f64>().unwrap());
                let changed = numbers
                    .enumerate()
                    .map(|(axis, c)| change(c, axis).to_string());
                format!("v {}", Vec::from_iter(changed).join(" "))
            }
        });
        Vec::from_iter(lines).join("\n") + "\n"
    };
    room.write("huge.obj", &moved(STEP, &|c, _| c * 1e12));
    room.write("tiny.obj", &moved(STEP, &|c, _| c * 1e-14));
    room.write(
        "far.obj",
        &moved(STEP, &|c, axis| c / 3.0 + [4e6, 0.0, -5e5][axis]),
    );
    room.write(
        "off.obj",
        &moved(STEP, &|c, axis| c * 1e-3 + [4e6, 1e6, -5e5][axis]),
    );
    room.write("flat.stl", "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 3 0 .1\nvertex 0 2 .7\nendloop\nendfacet\nendsolid\n");
    room.ok("build far.obj -o far.phx");
    room.ok("build huge.obj -o huge.phx --up z");
    for (scene, options) in [
        ("s.obj", "--size 57x41"),
        ("s.obj", "--up=-z --ortho --size 30x50"),
        ("s.obj", "--ortho=3.3"),
        ("huge.obj", "--ortho"),
        ("huge.phx", ""),
        ("tiny.obj", "--size 30x80"),
        ("far.obj", ""),
        ("far.obj", "--ortho --up z"),
        ("far.phx", ""),
        ("off.obj", ""),
        ("off.obj", "--size 33x44 --origin none"),
        ("flat.stl", ""),
        ("c.gltf", "--size 80x20"),
        ("c.gltf", "--camera-name 0"),
        ("a.test", "--origin 1,2,3"),
    ] {
        let shown = Rendering::of(&room, scene, options);
        let left_out = ["--camera-name", "--up", "--size", "--ortho", "0", "z"];
        let rest = options
            .split(' ')
            .filter(|word| !left_out.iter().any(|option| word.starts_with(option)));
        let rest = Vec::from_iter(rest.filter(|word| !word.contains('x'))).join(" ");
        let line = format!("{rest} {}", shown.camera());
        let again = Rendering::of(&room, scene, &line);
        assert!(again.bytes == shown.bytes, "{scene} {options}: {line}");
        let first = &shown.bytes[shown.bytes.len() - 12..];
        assert!(
            shown.bytes.chunks(12).any(|pixel| pixel != first),
            "{scene} {options}"
        );
        // `info` tells that of the scene's own size.
        let described = room.json(&format!(
            "info {scene} {} --json",
            options.split("--size").next().unwrap()
        ));
        assert!(
            described["camera"]["options"]
                .as_str()
                .unwrap()
                .starts_with("--camera ")
        );
    }
    // A short report tells the camera that was made up; a long one, all but those of key frames.
    room.write("keys", "0 0 1 5 0 0 0 0 1 0 45\n1 1 1 5 0 0 0 0 1 0 45\n");
    let report = |line: &str| room.ok(&format!("render {line} -o out.png --size 40x30"));
    assert!(report("s.obj").contains("\ncamera       --camera "));
    assert!(!report("a.test").contains("--camera"));
    assert!(
        report("a.test -v").contains("\ncamera       --camera 0,0,5 0,0,0 0,1,0 45 --size 40x30\n")
    );
    assert!(!report("a.test -v --keyframes keys").contains("--camera"));
    assert!(
        room.ok("info a.test")
            .contains("\ncamera       --camera 0,0,5 ")
    );
}

#[test]
fn lights_that_are_made_up_turn_with_the_camera() {
    let room = room();
    let turn = "--size 40x30 --turntable 4 --tile 8";
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    let light = |name: &str| {
        let picture = phalanx::image::load(&room.path().join(name)).unwrap();
        picture.pixels.iter().map(|p| u64::from(p[0])).sum::<u64>()
    };
    // A ball looks the same from all sides, its light with it.
    room.ok(&format!("render n.nff -o n#.png {turn} --background .1"));
    room.ok(&format!("render a.test -o own#.png {turn}"));
    room.ok(&format!("render a.test -o head#.png {turn} --headlight"));
    for frame in 1..4 {
        let (first, now) = (light("n0.png"), light(&format!("n{frame}.png")));
        assert!(
            now > first * 3 / 4 && now < first * 4 / 3,
            "{frame}: {first} {now}"
        );
        assert!(light(&format!("head{frame}.png")) * 3 > light("head0.png"));
        // A scene's own lamps stay.
        let own = bytes(&format!("own{frame}.png"));
        assert!(bytes(&format!("head{frame}.png")) != own);
        let command = super::headers::text(&own, "Comment");
        super::headers::again(&room, &command, "again.png");
        assert!(bytes("again.png") == own, "{frame}: {command}");
    }
    // The same frames from shards, from a cache, resumed, and from the command in a frame.
    room.ok("build s.obj -o s.phx");
    room.ok(&format!("render s.obj -o s#.png {turn}"));
    room.ok(&format!(
        "render s.obj -o t#.png {turn} --checkpoint t#.tiles"
    ));
    room.ok(&format!(
        "render s.obj -o t#.png {turn} --checkpoint t#.tiles"
    ));
    for (by, name) in [("frame", "u"), ("tile", "v")] {
        room.ok(&format!(
            "plan s.obj --shards 2 --plan {by}.json --shard-by {by} -o {name}#.png {turn}"
        )
        .replace("--tile 8", ""));
        for shard in [1, 0] {
            room.ok(&format!("render --plan {by}.json --shard {shard}"));
        }
        room.ok(&format!("merge {by}.json"));
    }
    room.ok(&format!("render s.phx -o c#.pfm {turn}"));
    room.ok(&format!("render s.obj -o s#.pfm {turn} --engine scalar"));
    for frame in 0..4 {
        let first = bytes(&format!("s{frame}.png"));
        for name in ["t", "u", "v"] {
            assert!(
                bytes(&format!("{name}{frame}.png")) == first,
                "{name}{frame}"
            );
        }
        assert!(
            bytes(&format!("c{frame}.pfm")) == bytes(&format!("s{frame}.pfm")),
            "{frame}"
        );
        let command = super::headers::text(&first, "Comment");
        super::headers::again(&room, &command, "again.png");
        assert!(bytes("again.png") == first, "{frame}: {command}");
    }
    room.ok("verify s.obj --size 40x30 --turntable 3");
    room.refused(
        "render s.obj --headlight --light 1,2,3",
        2,
        &["--headlight", "--light"],
    );
}

#[test]
fn lights_that_are_made_up_enter_a_room_with_the_camera() {
    let room = TestFolder::new();
    room.write(
        "box.obj",
        "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 4\nv 4 0 4\nv 4 3 4\nv 0 3 4\n\
         f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 4 3 7 8\nf 1 4 8 5\nf 2 3 7 6\n",
    );
    room.write("keys", "0 3 1 1 0 2 4 0 1 0 60\n2 1 2 3 4 1 2 0 1 0 60\n");
    room.ok("render box.obj -o f#.png --keyframes keys --size 40x30");
    for frame in 0..3 {
        let picture = phalanx::image::load(&room.path().join(format!("f{frame}.png"))).unwrap();
        let sum: u32 = picture.pixels.iter().map(|pixel| u32::from(pixel[0])).sum();
        let mean = sum / picture.pixels.len() as u32;
        assert!(mean > u32::from(u16::MAX) / 2, "{frame}: {mean}");
    }
}

#[test]
fn frames_end_with_the_command_of_a_video() {
    let room = room();
    let line = "render s.obj --size 40x30 --turntable 6";
    let command = "video        ffmpeg -framerate 24 -start_number 2 -i './f.%04d.png' -pix_fmt yuv420p ./f.mp4\n\
                   rate         24 frames per second is a guess: change -framerate\n";
    let report = room.ok(&format!("{line} --frames 2..5 -o f.png"));
    assert!(report.ends_with(command), "{report}");
    assert!(
        !room
            .ok(&format!("{line} --frames 2..2 -o f.png"))
            .contains("ffmpeg")
    );
    assert_eq!(room.ok(&format!("{line} -q -o f.png")), "");
    room.json(&format!("{line} -o f.png --json"));
    let odd = room.ok("render s.obj --size 41x30 --turntable 2 -o f##.exr");
    assert!(odd.contains("-i './f%02d.exr' -vf 'format=rgb48,"), "{odd}");
    assert!(
        odd.contains("pad=ceil(iw/2)*2:ceil(ih/2)*2' -pix_fmt yuv420p ./f.mp4"),
        "{odd}"
    );
    room.ok("plan s.obj --shards 2 -o m.png --plan p.json --size 40x30 --turntable 4");
    for shard in 0..2 {
        let ran = room.ok(&format!("render --plan p.json --shard {shard}"));
        assert!(!ran.contains("ffmpeg"), "not all frames");
    }
    assert!(
        room.ok("merge p.json")
            .contains("ffmpeg -framerate 24 -start_number 0 -i './m.%04d.png'")
    );
}

#[test]
fn occlusion_reaches_a_tenth_of_the_scene() {
    let room = room();
    let reach = |scene: &str, options: &str| {
        let line =
            format!("render {scene} -o out.pfm --size 24x18 --integrator ao {options} --json");
        let report = room.json(&line);
        (
            report["ao_distance"].clone(),
            fs::read(room.path().join("out.pfm")).unwrap(),
        )
    };
    room.ok("build s.obj -o s.phx");
    let (distance, bytes) = reach("s.obj", "");
    // A tenth of √(2² + 1.5² + 2²), to two digits.
    let number = distance.as_f64().unwrap();
    assert!((number - 0.32).abs() < 1e-6, "{number}");
    for options in [
        "--ao-distance 0.32",
        "--engine scalar",
        "--camera 9,9,9 0,0,0 0,1,0 9",
    ] {
        let (again, same) = reach("s.obj", options);
        assert_eq!(again, distance, "{options}");
        assert_eq!(same == bytes, !options.contains("camera"), "{options}");
    }
    assert!(reach("s.phx", "").1 == bytes);
    let (unlimited, endless) = reach("s.obj", "--ao-distance inf");
    assert!(unlimited.is_null() && endless != bytes);
    // A closed room is not black.
    let mean = |options: &str| {
        let (_, bytes) = reach("standard:room:5k", options);
        let numbers = bytes[bytes.len() - 24 * 18 * 12..].chunks(4);
        let numbers = numbers.map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap())));
        numbers.sum::<f64>() / (24.0 * 18.0 * 3.0)
    };
    assert!(mean("--spp 16") > 0.6 && mean("--spp 16 --ao-distance inf") < 0.1);
    assert!(room.ok("render -h").contains("--ao-distance"));
    room.refused(
        "render s.obj --integrator ao --ao-distance nan",
        2,
        &["or inf"],
    );
}
