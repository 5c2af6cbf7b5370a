//! Pictures to stdout, and scenes from stdin.

use super::TestFolder;
use super::places::{furnished, path_in};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::process::Stdio;

#[test]
fn a_picture_to_stdout_is_that_of_the_file() {
    let room = furnished();
    let bytes = |line: &str| {
        let mut command = room.command(line);
        let output = command.output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{line}: {stderr}");
        (output.stdout, stderr)
    };
    for (options, ending) in [
        ("", "png"),
        ("--format png --bits 16", "png"),
        ("--format jpg", "jpg"),
        ("--format exr", "exr"),
        ("--format png --aov alpha", "png"),
        ("--format exr --aov alpha --bits 16", "exr"),
        ("--format hdr", "hdr"),
        ("--format pfm", "pfm"),
    ] {
        let bits = options.trim_start_matches(&format!("--format {ending}"));
        room.ok(&format!("render a.test -o b.{ending} {bits}"));
        let (out, stderr) = bytes(&format!("render a.test -o - {options}"));
        assert!(
            out == fs::read(path_in(&room, &format!("b.{ending}"))).unwrap(),
            "{options}"
        );
        assert!(stderr.contains("Mrays/s"), "{stderr}");
    }
    let (_, stderr) = bytes("render a.test -o - --json");
    let report: serde_json::Value = serde_json::from_str(&stderr).unwrap();
    assert_eq!(report["image"]["path"], "-");
    let (out, _) = bytes("merge plan.json -o -");
    assert!(out == fs::read(path_in(&room, "one.png")).unwrap());
    // An option overrides an extension.
    room.ok("render a.test -o odd.name --format png");
    assert_eq!(
        fs::read(path_in(&room, "odd.name")).unwrap(),
        fs::read(path_in(&room, "one.png")).unwrap()
    );
    room.ok("render a.test --format exr");
    assert!(path_in(&room, "a.exr").is_file());
}

#[test]
fn pictures_to_stdout_are_refused_where_they_make_no_sense() {
    let room = furnished();
    let frames = "render a.test -o - --frames 0..1 --turntable 2";
    room.refused(frames, 2, &["cannot be written to stdout"]);
    let twice = "render a.test -o - --format png --format exr";
    room.refused(twice, 2, &["two formats for the picture"]);
    room.refused(
        "info a.test --format png",
        2,
        &["this command writes no picture"],
    );
    room.refused(
        "verify a.test --format exr",
        2,
        &["this command writes no picture"],
    );
    let plan = "plan a.test --shards 2 -o - --plan p.json";
    room.refused(plan, 2, &["give file names"]);
    room.refused(
        "merge plan.json -o - --format obj",
        2,
        &["possible values: png"],
    );
    // Its other end is a terminal.
    let Ok(terminal) = File::options().read(true).write(true).open("/dev/ptmx") else {
        return println!("skipped: there are no terminals here");
    };
    for name in ["-", "/dev/stdout"] {
        let mut command = room.command(&format!("render none.test -o {name}"));
        let mut child = command
            .stdout(terminal.try_clone().unwrap())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stderr = String::new();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut stderr)
            .unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(2), "{stderr}");
        assert!(
            stderr.contains("cannot be written to a terminal"),
            "{stderr}"
        );
    }
}

/// Runs a command with this on stdin.
fn fed(room: &TestFolder, line: &str, stdin: &[u8]) -> (Option<i32>, Vec<u8>, String) {
    let mut command = room.command(line);
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A command that refuses does not read it.
    child.stdin.take().unwrap().write_all(stdin).ok();
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), output.stdout, stderr)
}

#[test]
fn a_scene_from_stdin_is_that_of_the_file() {
    let room = TestFolder::new();
    let files = ["balls", "tetra"].map(|name| (name, if name == "balls" { "nff" } else { "ply" }));
    for (name, ending) in files {
        room.ok(&format!("generate {name} --size 2 -o {name}.{ending}"));
    }
    room.write("quad.mtl", "newmtl red\nKd 1 0 0\n");
    room.write(
        "quad.obj",
        "mtllib quad.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
    );
    for name in ["a.test", "balls.nff", "tetra.ply", "quad.obj"] {
        let ending = name.split('.').nth(1).unwrap();
        let scene = fs::read(path_in(&room, name)).unwrap();
        let size = "--size 40x30";
        room.ok(&format!("render {name} -o wanted.pfm {size}"));
        let wanted = fs::read(path_in(&room, "wanted.pfm")).unwrap();
        let line = format!("render - --format pfm -o - --format {ending} {size}");
        let (code, out, result) = fed(&room, &line, &scene);
        assert_eq!(code, Some(0), "{name}: {result}");
        assert!(out == wanted, "{name}");
        for line in [
            format!("verify - --format {ending} --threads 1 {size}"),
            format!("info - --format {ending} --json"),
            format!("build - --format {ending} -o b.phx"),
            format!(
                "bench - --format {ending} --rays primary --threads 1 --size 16x16 --repeat 1 --min-time 0"
            ),
        ] {
            let (code, _, result) = fed(&room, &line, &scene);
            assert_eq!(code, Some(0), "{line}: {result}");
        }
        room.ok(&format!("render b.phx -o again.pfm {size}"));
        assert!(
            fs::read(path_in(&room, "again.pfm")).unwrap() == wanted,
            "{name}"
        );
    }
    // A file without an extension.
    fs::copy(path_in(&room, "quad.obj"), path_in(&room, "quad.txt")).unwrap();
    room.ok("render quad.txt --format obj -o again.pfm --size 40x30");
    assert_eq!(
        fs::read(path_in(&room, "again.pfm")).unwrap(),
        fs::read(path_in(&room, "wanted.pfm")).unwrap()
    );
    let (code, _, result) = fed(&room, "render - --format test", super::SCENE.as_bytes());
    assert_eq!(code, Some(0), "{result}");
    assert!(path_in(&room, "picture.png").is_file());
}

#[test]
fn scenes_from_stdin_are_refused_where_they_make_no_sense() {
    let room = TestFolder::new();
    for (line, code, part) in [
        ("render -", 2, "--format test|nff|gltf|glb|obj|ply|stl"),
        (
            "info - --format obj --format ply",
            2,
            "two formats for the scene",
        ),
        ("render - --format bmp", 2, "possible values"),
        (
            "verify - - --format test --threads 1",
            2,
            "stdin can be read only once",
        ),
        (
            "plan - --format test --shards 2 -o x.png --plan p.json",
            2,
            "give file names",
        ),
        ("info - --format test --max-memory 1", 1, "--max-memory"),
        (
            "bench - --format test --baseline a.test --fail-above 3%",
            2,
            "stdin can be read only once",
        ),
        ("info - --format stl", 3, "error: -"),
    ] {
        let (got, _, result) = fed(&room, line, super::SCENE.as_bytes());
        assert_eq!(got, Some(code), "{line}: {result}");
        assert!(
            result.contains(part) && !result.contains("panicked"),
            "{line}: {result}"
        );
    }
}
