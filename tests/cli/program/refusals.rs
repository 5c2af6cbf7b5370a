//! Refused inputs, with their messages and exit codes; nothing is left behind.

use super::{SCENE, TestFolder, ran};
use std::fs;

#[test]
fn version_names_the_compiled_level() {
    let expected = format!(
        "phalanx {} ({})\n",
        env!("CARGO_PKG_VERSION"),
        phalanx::isa::compiled_level()
    );
    assert_eq!(TestFolder::new().ok("--version"), expected);
}

#[test]
fn no_subcommand_gives_short_help_and_a_usage_error() {
    let parts = ["Usage: phalanx", "render", "verify", "compare", "info"];
    TestFolder::new().refused("", 2, &parts);
}

#[test]
fn every_command_has_help_with_an_example() {
    let room = TestFolder::new();
    for command in ["render", "verify", "compare", "info", "build"] {
        let help = room.ok(&format!("{command} --help"));
        let example = help.split("Example").nth(1).expect("an example");
        assert!(example.contains(&format!("phalanx {command} ")), "{help}");
    }
    let help = room.ok("render --help");
    // Wrapped to the terminal's width.
    let help: Vec<_> = help.split_whitespace().collect();
    let help = help.join(" ");
    assert!(
        help.contains("so that the kinds add up to the total"),
        "{help}"
    );
}

#[test]
fn usage_errors_are_2() {
    let room = TestFolder::new();
    for (line, part) in [
        ("rendr a.test", "render"),
        ("render", "<SCENE>"),
        ("render a.test --colour", "--colour"),
        ("render a.test --samples 4", "--spp N"),
        ("plan a.test --samples 4", "--spp N"),
        ("render a.test --width 40", "--size WxH"),
        ("render a.test --env sky.hdr", "--environment ENV"),
        ("render a.test --background white", "expected R,G,B"),
        ("render a.test --light white", "expected X,Y,Z"),
        ("render a.test --camera 0 0 5 45", "FROM, as in 0,1,5"),
        ("render a.test --camera-name 7", "no camera is called"),
        (
            "render a.test --aov albdo -o a.exr",
            "Z, position, P, ng, Ng, ns, N,",
        ),
        ("render a.test --size 10", "640x480"),
        ("render a.test --size 0x10", "out of range"),
        ("render a.test --size 1000000x1000000", "out of range"),
        ("render a.test --threads 0", "number of threads"),
        ("render a.test --threads two", "number of threads"),
        ("render a.test --tile 7", "8..=1024"),
        ("render a.test --tile 1025", "8..=1024"),
        ("render a.test --max-depth 1001", "0..=1000"),
        ("render a.test --engine gpu", "scalar"),
        ("render a.test --kernel fast", "packet"),
        ("render a.test --transfer gamma", "srgb"),
        ("render a.test --pin all", "cores"),
        (
            "render a.test -o a.bmp",
            ".png, .jpg, .jpeg, .exr, .hdr, .pfm",
        ),
        ("render a.test -o a", ".png"),
        (
            "render a.test -o a.exr --exposure 1",
            "a.exr stores linear radiance",
        ),
        (
            "render a.test -o a.exr --exposure auto",
            "a.exr stores linear radiance",
        ),
        (
            "plan a.test -o a.hdr --shards 2 --plan p.json --exposure auto",
            "a.hdr stores linear radiance",
        ),
        (
            "render a.test -o a.pfm --tone linear",
            "--tone is for PNG and JPEG",
        ),
        (
            "render a.test -o a.pfm --transfer srgb",
            "--transfer is for PNG and JPEG",
        ),
        (
            "render a.test -o a.jpg --bits 16",
            "--bits is for PNG and OpenEXR: a.jpg is neither",
        ),
        (
            "render a.test -o a.exr --bits 8",
            "--bits 8: a.exr can have 32 or 16 bits per sample",
        ),
        ("render a.test --bits 32", "a.png can have 8 or 16 bits"),
        (
            "plan a.test -o a.hdr --shards 2 --plan p.json --bits 16",
            "--bits is for PNG and OpenEXR",
        ),
        (
            "render a.test -o a.jpg --aov alpha",
            "--aov alpha needs a PNG or OpenEXR file (.png, .exr), not a.jpg",
        ),
        (
            "render a.test --aov ns,alpha",
            "--aov ns needs an OpenEXR file (.exr), not a.png",
        ),
        (
            "plan a.test -o a.png --shards 2 --plan p.json --aov all",
            "--aov depth needs an OpenEXR file",
        ),
        (
            "render a.test -o a.jpg --size 65536x1",
            "at most 65535 pixels",
        ),
        ("render a.test --bits 12", "8, 16 or 32"),
        ("render a.test --exposure bright", "auto, or stops"),
        ("render a.test --exposure 101", "stops from -100 to 100"),
        ("render a.test --tone filmic", "neutral"),
        ("render a.test --spp 0", "1..=65536"),
        ("render a.test --filter gauss", "mitchell"),
        ("render a.test --aperture 0.1", "--focus <DISTANCE>"),
        ("render a.test --focus 3", "--aperture <DIAMETER>"),
        ("render a.test --aperture=-1 --focus 3", "a diameter"),
        ("render a.test --aperture inf --focus 3", "a diameter"),
        ("render a.test --aperture 1 --focus 0", "a distance"),
        ("verify a.test --aperture 1 --focus nan", "a distance"),
        (
            "render a.test --aperture 2 --focus .001",
            "a thousand times the distance of focus",
        ),
        (
            "verify a.test --aperture 1e30 --focus 1e30",
            "no wider than the largest scene",
        ),
        ("render a.test --integrator path", "ao"),
        ("render a.test --ao-distance 2", "--integrator ao"),
        ("verify a.test --ao-distance 2", "--integrator ao"),
        (
            "verify a.test --integrator ao --ao-distance 0",
            "a distance",
        ),
        ("verify", "<SCENE>"),
        ("verify a.test --threads 1,0", "number of threads"),
        ("compare a.png", "<B>"),
        ("compare a.png b.png --heat a.txt", ".png"),
        ("compare a.png b.png --side-by-side a.txt", ".png"),
        ("compare a.png b.png --tolerance=-1", "0 or more"),
        ("compare a.png b.png --max-differing 101%", "0% to 100%"),
    ] {
        room.refused(line, 2, &["error: ", part]);
    }
}

#[test]
fn files_that_cannot_be_read_are_1() {
    let room = TestFolder::new();
    fs::create_dir(room.path().join("folder.test")).unwrap();
    fs::create_dir(room.path().join("folder.png")).unwrap();
    for command in ["render", "verify", "info"] {
        room.refused(
            &format!("{command} none.test"),
            1,
            &["error: cannot read none.test: "],
        );
        room.refused(
            &format!("{command} folder.test"),
            1,
            &["error: cannot read folder.test: "],
        );
    }
    room.refused(
        "compare none.png none.png",
        1,
        &["error: cannot read none.png: "],
    );
    room.refused(
        "compare folder.png none.png",
        1,
        &["error: cannot read folder.png: "],
    );
    room.refused(
        "compare a.test a.test",
        1,
        &["error: a.test: not a picture that can be read: it is none of PNG, JPEG"],
    );
    room.refused(
        "verify a.test --against none.json",
        1,
        &["error: cannot read none.json: "],
    );
    room.refused(
        "verify a.test --against a.test",
        1,
        &["error: a.test: not a record"],
    );
}

#[test]
fn an_unknown_ending_is_2() {
    let room = TestFolder::new();
    room.write("a.blend", "");
    for command in ["render", "verify", "info"] {
        room.refused(
            &format!("{command} a.blend"),
            2,
            &["error: a.blend: not a scene format", ".test"],
        );
    }
}

#[test]
fn outputs_that_cannot_be_written_are_1_before_anything_is_rendered() {
    let room = TestFolder::new();
    fs::create_dir(room.path().join("folder.png")).unwrap();
    // The largest image: were it rendered, its film would not fit into the memory allowed here, and
    // the run would abort.
    let large = "--size 16384x16384";
    for command in ["render a.test -o", "verify a.test --record"] {
        for (path, message) in [
            (
                "none/b.png",
                "cannot write none/b.png: there is no folder none",
            ),
            ("folder.png", "cannot write folder.png: "),
            ("a.test/b.png", "cannot write a.test/b.png: "),
        ] {
            let before = room.names();
            let ran = room.run_in_400_mb(&format!("{command} {path} {large}"));
            assert_eq!(ran.code, Some(1), "{command} {path}: {}", ran.stderr);
            assert!(
                ran.stderr.contains(message),
                "{command} {path}: {}",
                ran.stderr
            );
            assert_eq!(room.names(), before, "{command} {path}");
        }
    }
}

#[test]
fn scene_errors_are_3_with_file_line_and_column() {
    let room = TestFolder::new();
    let bad = SCENE
        .replace("sphere -1", "spere -1")
        .replace("ior 1.5", "ior NaN");
    room.write("bad.test", &bad);
    room.write("empty.test", "");
    for command in ["render", "verify", "info"] {
        let parts = [
            "error: bad.test:7:1: ",
            "spere -1 0 0 1",
            "sphere",
            "error: bad.test:14:5: ",
        ];
        room.refused(&format!("{command} bad.test"), 3, &parts);
        room.refused(
            &format!("{command} empty.test"),
            3,
            &["error: empty.test:1:"],
        );
    }
    let stderr = room.run("render bad.test").stderr;
    assert!(
        !stderr.contains('\u{1b}'),
        "no colours into a pipe: {stderr:?}"
    );
}

#[test]
fn warnings_are_one_line_each_and_do_not_stop_a_render() {
    let room = TestFolder::new();
    room.write("open.test", &format!("{SCENE}pushTransform\n"));
    let ran = room.run("info open.test");
    assert_eq!(ran.code, Some(0));
    let warnings: Vec<_> = ran
        .stderr
        .lines()
        .filter(|l| l.starts_with("warning: "))
        .collect();
    assert_eq!(warnings.len(), 1, "{}", ran.stderr);
    assert!(
        warnings[0].starts_with("warning: open.test:16:1: "),
        "{warnings:?}"
    );
}

/// A PNG of one black pixel, which is an index into a palette of `palette` bytes.
fn png_with_palette(color: u8, palette: usize) -> Vec<u8> {
    let chunk = |name: &[u8], data: &[u8]| {
        let body = [name, data].concat();
        let length = (data.len() as u32).to_be_bytes();
        let sum = crc32fast::hash(&body).to_be_bytes();
        [&length[..], &body, &sum].concat()
    };
    let samples = vec![0; if color == 3 { 2 } else { 4 }];
    let length = samples.len() as u16;
    // A zlib stream of one stored block.
    let mut stream = vec![0x78, 0x01, 0x01];
    stream.extend(length.to_le_bytes());
    stream.extend((!length).to_le_bytes());
    stream.extend(&samples);
    stream.extend([0, length as u8, 0, 1]);
    [
        b"\x89PNG\r\n\x1a\n".to_vec(),
        chunk(b"IHDR", &[0, 0, 0, 1, 0, 0, 0, 1, 8, color, 0, 0, 0]),
        chunk(b"PLTE", &vec![0; palette]),
        chunk(b"IDAT", &stream),
        chunk(b"IEND", &[]),
    ]
    .concat()
}

/// The decoder trusts the length of a palette.
#[test]
fn palettes_that_are_not_whole_colours_are_refused() {
    let room = TestFolder::new();
    room.write("a.mtl", "newmtl a\nmap_Kd a.png\n");
    let quad = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    room.write("a.obj", quad);
    let picture = |color, palette| {
        let bytes = png_with_palette(color, palette);
        fs::write(room.path().join("a.png"), bytes).unwrap();
    };
    // A palette is only a hint if pixels are colours themselves.
    for (color, palette) in [(3, 3), (3, 768), (2, 3), (2, 4)] {
        picture(color, palette);
        room.ok("info a.obj");
        room.ok("compare a.png a.png");
    }
    for palette in [0, 1, 4, 5, 767, 769, 771] {
        picture(3, palette);
        // With no colours, or more than 256, the decoder itself reports the error.
        let what = match palette {
            0 | 1 | 769 | 771 => "PLTE",
            _ => "its palette (PLTE) does not hold whole colours, 1 to 256",
        };
        // A scene omits a broken texture.
        let ran = room.run("info a.obj");
        assert_eq!(ran.code, Some(0), "{palette}: {}", ran.stderr);
        let left_out = "the texture `a.png` is left out: ";
        for part in [left_out, what] {
            assert!(ran.stderr.contains(part), "{palette}: {}", ran.stderr);
        }
        let named = ["a.png: not a PNG picture that can be read: ", what];
        room.refused("compare a.png a.png", 1, &named);
    }
}

/// In every source of messages: readers, writers, tables, the argument parser, and lists.
#[test]
fn names_on_the_command_line_do_not_steer_the_terminal() {
    let room = TestFolder::new();
    let name = "\u{1b}[2J\u{7}\u{9b}\u{202e}gnp\u{2066}\u{200b}\u{61c}\u{feff}\u{ad}\u{e0041}";
    fs::copy(
        room.path().join("a.test"),
        room.path().join(format!("{name}.test")),
    )
    .unwrap();
    for (line, code) in [
        (format!("render none{name}.test"), 1),
        (format!("render none{name}.phx"), 1),
        (format!("render a.{name}"), 1),
        (format!("render a.test -o none{name}/b.png"), 1),
        (format!("render a.test -o {name}"), 2),
        (format!("render a.test --size {name}"), 2),
        (format!("render standard:{name}"), 2),
        (format!("{name} a.test"), 2),
        (format!("merge {name}.json"), 1),
        (format!("compare {name}.png b.png"), 1),
        (format!("info {name}.test"), 0),
        (format!("render {name}.test -o {name}.png"), 0),
    ] {
        let ran = room.run(&line);
        assert_eq!(ran.code, Some(code), "{line:?}: {}", ran.stderr);
        let printed = ran.stdout + &ran.stderr;
        let steers = |c: char| phalanx::files::steers(c) && c != '\n';
        assert!(!printed.contains(steers), "{line:?}: {printed:?}");
        assert!(
            printed.contains("u{1b}[2J") || printed.contains("?[2J"),
            "{line:?}: {printed}"
        );
    }
}

#[test]
fn a_camera_in_one_word_is_told_the_form() {
    let room = TestFolder::new();
    for more in ["", "-o a.png", "-o a.png --size 40x30", "--size 40x30"] {
        let mut command = room.command("render a.test --camera");
        command.arg("0 0 5").args(more.split_whitespace());
        let ran = ran(&mut command);
        let names_the_form = ran.stderr.contains("FROM AT UP FOV, as in");
        assert!(
            ran.code == Some(2) && names_the_form,
            "{more}: {}",
            ran.stderr
        );
    }
    let far = "--camera 1e38,0,0 0,0,0 0,1,0 45 --size 8x8";
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/phalanx.test");
    room.refused(&format!("render {scene} {far}"), 2, &["too far away"]);
    // Only options that the command has are named.
    let ran = room.run("info a.test --samples 4");
    assert!(!ran.stderr.contains("--spp"), "{}", ran.stderr);
}

#[test]
fn scenes_of_other_programs_name_a_converter() {
    let room = TestFolder::new();
    for (name, how) in [
        ("a.fbx", "assimp export"),
        ("a.off", "assimp export"),
        ("a.USDZ", "in Blender"),
        ("a.stp", "in FreeCAD"),
    ] {
        room.write(name, "");
        room.refused(
            &format!("render {name}"),
            2,
            &["help: convert it to glTF", how],
        );
    }
    room.write("a.txt", "");
    assert!(!room.run("render a.txt").stderr.contains("convert"));
}
