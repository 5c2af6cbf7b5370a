//! The command line: messages, exit codes, and the files that appear or do not.
#![cfg(unix)]

use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// A scene of two spheres and a mirroring, half transparent triangle, with both kinds of light.
const SCENE: &str = "\
size 40 24
camera 0 0 5 0 0 0 0 1 0 45
directional 1 1 1 0.5 0.5 0.5
point 3 3 3 0.5 0.4 0.3
diffuse 0.6 0.3 0.2
specular 0.3 0.3 0.3
sphere -1 0 0 1
sphere 1 0.5 0 0.7
maxverts 3
vertex -3 -1 -3
vertex 3 -1 -3
vertex 0 -1 3
transmission 0.5 0.5 0.5
ior 1.5
tri 0 2 1
";

/// A folder of its own to run in.
struct Room(TempDir);

/// What a run left behind.
struct Ran {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Room {
    /// A room with the scene in it, as `a.test`.
    fn new() -> Room {
        let room = Room(tempfile::tempdir().unwrap());
        room.write("a.test", SCENE);
        room
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path().join(name), text).unwrap();
    }

    /// Names of what is in the room, sorted, but for the scene.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.path()).unwrap();
        let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names.filter(|name| name != "a.test").collect();
        names.sort();
        names
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        command
            .current_dir(self.path())
            .args(line.split_whitespace());
        command
    }

    fn run(&self, line: &str) -> Ran {
        ran(&mut self.command(line))
    }

    /// Runs what must succeed, and gives its stdout.
    fn ok(&self, line: &str) -> String {
        let ran = self.run(line);
        assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
        ran.stdout
    }

    fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.ok(line)).unwrap()
    }

    /// Runs what must fail with `code`, say every part on stderr and nothing on stdout, and leave no new file.
    fn refused(&self, line: &str, code: i32, parts: &[&str]) {
        let before = self.names();
        let ran = self.run(line);
        assert_eq!(ran.code, Some(code), "{line}: {}", ran.stderr);
        for part in parts {
            assert!(
                ran.stderr.contains(part),
                "{line}: {part:?} in\n{}",
                ran.stderr
            );
        }
        assert!(!ran.stderr.contains("panicked"), "{line}: {}", ran.stderr);
        assert_eq!(ran.stdout, "", "{line}");
        assert_eq!(self.names(), before, "{line}");
    }
}

fn ran(command: &mut Command) -> Ran {
    let output = command.output().unwrap();
    Ran {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

#[test]
fn version_names_the_compiled_level() {
    let expected = format!(
        "phalanx {} ({})\n",
        env!("CARGO_PKG_VERSION"),
        phalanx::isa::compiled_level()
    );
    assert_eq!(Room::new().ok("--version"), expected);
}

#[test]
fn no_subcommand_gives_short_help_and_a_usage_error() {
    let parts = ["Usage: phalanx", "render", "verify", "compare", "info"];
    Room::new().refused("", 2, &parts);
}

#[test]
fn every_command_has_help_with_an_example() {
    let room = Room::new();
    for command in ["render", "verify", "compare", "info"] {
        let help = room.ok(&format!("{command} --help"));
        assert!(
            help.contains(&format!("Example: phalanx {command} ")),
            "{help}"
        );
    }
    let help = room.ok("render --help");
    assert!(
        help.contains("so that the kinds add up to the total"),
        "{help}"
    );
}

#[test]
fn usage_errors_are_2() {
    let room = Room::new();
    for (line, part) in [
        ("rendr a.test", "render"),
        ("render", "<SCENE>"),
        ("render a.test --colour", "--colour"),
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
        ("render a.test -o a.jpg", ".png"),
        ("render a.test -o a", ".png"),
        ("verify", "<SCENE>"),
        ("verify a.test --threads 1,0", "number of threads"),
        ("compare a.png", "<B>"),
        ("compare a.png b.png --heat a.txt", ".png"),
    ] {
        room.refused(line, 2, &["error: ", part]);
    }
}

#[test]
fn files_that_cannot_be_read_are_1() {
    let room = Room::new();
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
        &["error: a.test: not a PNG picture"],
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
    let room = Room::new();
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
    let room = Room::new();
    fs::create_dir(room.path().join("folder.png")).unwrap();
    // Rendering this would take minutes.
    let large = "--size 4096x4096 --max-depth 1000";
    for line in [
        format!("render a.test {large} -o"),
        format!("verify a.test {large} --record"),
    ] {
        room.refused(
            &format!("{line} none/b.png"),
            1,
            &["cannot write none/b.png: there is no folder none"],
        );
        room.refused(
            &format!("{line} folder.png"),
            1,
            &["cannot write folder.png: "],
        );
        room.refused(
            &format!("{line} a.test/b.png"),
            1,
            &["cannot write a.test/b.png: "],
        );
    }
}

#[test]
fn scene_errors_are_3_with_file_line_and_column() {
    let room = Room::new();
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
    let room = Room::new();
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

#[test]
fn render_writes_a_picture_and_a_table() {
    let room = Room::new();
    let table = room.ok("render a.test");
    for part in [
        "40x24",
        "2 spheres, 1 triangle",
        "Mrays/s",
        "primary                   960",
        "written      a.png",
    ] {
        assert!(table.contains(part), "{part:?} in\n{table}");
    }
    assert_eq!(room.names(), ["a.png"]);
    let picture = phalanx::image::load(&room.path().join("a.png")).unwrap();
    assert_eq!((picture.width, picture.height), (40, 24));
    assert!(
        picture.pixels.iter().any(|p| p[0] > 10_000) && picture.pixels.iter().any(|p| p[0] == 0)
    );
}

#[test]
fn the_picture_is_named_by_the_user_or_the_scene_or_after_the_scene() {
    let room = Room::new();
    room.write("named.test", &format!("{SCENE}output own.png\n"));
    fs::create_dir(room.path().join("sub")).unwrap();
    room.ok("render named.test");
    room.ok("render named.test -o sub/other.PNG");
    assert_eq!(room.names(), ["named.test", "own.png", "sub"]);
    assert!(room.path().join("sub/other.PNG").is_file());
    room.write("jpeg.test", &format!("{SCENE}output own.jpg\n"));
    room.refused("render jpeg.test", 2, &["own.jpg", ".png", "-o"]);
}

#[test]
fn render_json_is_one_document_with_the_promised_keys() {
    let room = Room::new();
    let json = room.json("render a.test --json --size 33x17 --threads 2 --pin none");
    assert_eq!(json["schema_version"], 1);
    assert_eq!(
        (json["engine"].as_str(), json["threads"].as_u64()),
        (Some("simd"), Some(2))
    );
    assert_eq!(json["isa"], phalanx::isa::compiled_level());
    let image = serde_json::json!({"width": 33, "height": 17, "path": "a.png"});
    assert_eq!(json["image"], image);
    assert_eq!(json["scene"], "a.test");
    assert_eq!(json["rays"]["primary"], 33 * 17);
    let kinds = ["primary", "shadow", "reflection", "refraction"];
    let sum: u64 = kinds
        .iter()
        .map(|k| json["rays"][k].as_u64().unwrap())
        .sum();
    assert_eq!(json["rays"]["total"], sum);
    let speeds: f64 = kinds
        .iter()
        .map(|k| json["mrays_per_s"][k].as_f64().unwrap())
        .sum();
    assert!((speeds / json["mrays_per_s"]["total"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    for key in ["load", "build", "render"] {
        assert!(json["seconds"][key].as_f64().unwrap() >= 0.0);
    }
    let occupancy = json["occupancy"].as_f64().unwrap();
    assert!(occupancy > 0.0 && occupancy <= 1.0);
    assert!(json["memory"]["peak_rss_bytes"].as_u64().unwrap() > 100_000);
    let scalar = room.json("render a.test --json --engine scalar");
    assert_eq!(
        (&scalar["engine"], &scalar["occupancy"]),
        (&Value::from("scalar"), &Value::Null)
    );
}

#[test]
fn pictures_do_not_depend_on_engine_threads_or_tiles_but_on_tone() {
    let room = Room::new();
    let bytes = |options: &str| {
        room.ok(&format!("render a.test -o b.png {options}"));
        fs::read(room.path().join("b.png")).unwrap()
    };
    let plain = bytes("");
    for same in [
        "--engine scalar",
        "--threads 3 --tile 8",
        "--pin none --kernel packet",
        "--transfer none --quantize floor",
    ] {
        assert_eq!(bytes(same), plain, "{same}");
    }
    for other in [
        "--transfer srgb",
        "--quantize round",
        "--max-depth 0",
        "--size 41x24",
    ] {
        assert_ne!(bytes(other), plain, "{other}");
    }
}

#[test]
fn verify_holds_both_engines_together() {
    let room = Room::new();
    let lines = room.ok("verify a.test --threads 1,2 --kernel all --tile 16");
    let kernels = phalanx::frame::Kernel::ALL.len();
    assert_eq!(lines.lines().count(), 2 * kernels, "{lines}");
    assert!(
        lines
            .lines()
            .all(|l| l.starts_with("a.test: ") && l.ends_with(": identical")),
        "{lines}"
    );
    assert!(
        lines.contains("a.test: 2 threads, kernel packet: identical\n"),
        "{lines}"
    );
    let json = room.json("verify a.test --json --size 24x16");
    assert_eq!(
        (&json["schema_version"], &json["identical"]),
        (&Value::from(1), &Value::from(true))
    );
    assert_eq!(json["scenes"][0]["runs"].as_array().unwrap().len(), 3);
    assert_eq!(json["scenes"][0]["rays"]["primary"], 24 * 16);
}

#[test]
fn a_record_holds_later_runs_to_it() {
    let room = Room::new();
    room.ok("verify a.test --threads 1 --record r.json");
    let same = room.ok("verify a.test --threads 1 --against r.json");
    assert!(
        same.contains("a.test: against r.json: identical\n"),
        "{same}"
    );
    room.write("b.test", SCENE);
    for other in [
        "b.test",
        "a.test --size 41x24",
        "a.test --max-depth 1",
        "a.test --transfer srgb",
    ] {
        room.refused(
            &format!("verify {other} --against r.json"),
            2,
            &["error: the record "],
        );
    }
    // Black where the directional light shone, so the first lit pixel differs.
    room.write(
        "a.test",
        &SCENE.replace("0.5 0.5 0.5\npoint", "0 0 0\npoint"),
    );
    let changed = room.run("verify a.test --threads 1 --against r.json");
    assert_eq!(changed.code, Some(4), "{}", changed.stderr);
    assert!(
        changed
            .stdout
            .contains("against r.json: DIFFERENT, first at pixel ("),
        "{}",
        changed.stdout
    );
    let json = ran(&mut room.command("verify a.test --threads 1 --against r.json --json"));
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(json["identical"], false);
    assert_eq!(
        json["scenes"][0]["against"]["first_pixel"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
}

#[test]
fn compare_tells_equal_pictures_from_different_ones() {
    let room = Room::new();
    room.ok("render a.test -o a.png");
    room.ok("render a.test -o b.png --engine scalar");
    room.ok("render a.test -o c.png --quantize round");
    room.ok("render a.test -o d.png --size 41x24");
    assert_eq!(room.ok("compare a.png b.png"), "identical\n");
    let different = room.run("compare a.png c.png --heat heat.png");
    assert_eq!(different.code, Some(4));
    assert!(
        different
            .stdout
            .starts_with("different\nlargest difference 1 of 255\n"),
        "{}",
        different.stdout
    );
    let json = ran(&mut room.command("compare a.png c.png --json"));
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(
        (&json["exact"], json["largest_difference"].as_f64()),
        (&Value::from(false), Some(1.0))
    );
    let share = json["differing_pixels"].as_f64().unwrap() / 960.0;
    assert!(share > 0.0 && (json["share"].as_f64().unwrap() - share).abs() < 1e-12);
    let heat = phalanx::image::load(&room.path().join("heat.png")).unwrap();
    let lit = heat.pixels.iter().filter(|p| p[0] > 0).count();
    assert_eq!(lit as u64, json["differing_pixels"].as_u64().unwrap());
    room.refused(
        "compare a.png d.png --heat size.png",
        4,
        &["40x24", "41x24"],
    );
}

#[test]
fn info_tells_what_is_in_a_scene() {
    let room = Room::new();
    let json = room.json("info a.test --json");
    assert_eq!(
        json["primitives"],
        serde_json::json!({"spheres": 2, "triangles": 1, "cones": 0})
    );
    assert_eq!(
        json["lights"],
        serde_json::json!({"point": 1, "directional": 1})
    );
    assert_eq!(
        json["bounds"],
        serde_json::json!({"lo": [-3.0, -1.0, -3.0], "hi": [3.0, 1.2, 3.0]})
    );
    assert!(json["materials"].as_u64().unwrap() >= 1);
    for key in ["nodes", "depth", "sah"] {
        assert!(json["bvh"][key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(json["memory"]["total_bytes"].as_u64().unwrap() > 0);
    let table = room.ok("info a.test");
    assert!(
        table.contains("1 point, 1 directional") && table.contains("(-3, -1, -3) to (3, 1.2, 3)"),
        "{table}"
    );
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let room = Room::new();
    for line in [
        "info a.test",
        "render a.test",
        "verify a.test --json",
        "info a.test --json",
    ] {
        let mut child = room
            .command(line)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(
            output.status.code(),
            Some(0),
            "{line}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let full = fs::File::options().write(true).open("/dev/full");
    if let Ok(full) = full {
        let ran = ran(room.command("info a.test").stdout(full));
        assert_eq!(ran.code, Some(1), "{}", ran.stderr);
    }
}

/// Sends a signal with the system's `kill`, which needs no unsafe code here.
fn signal(child: &std::process::Child, name: &str) {
    let id = child.id().to_string();
    let sent = Command::new("kill")
        .args([OsStr::new("-s"), name.as_ref(), id.as_ref()])
        .status();
    assert!(sent.unwrap().success());
}

#[test]
fn an_interrupted_render_leaves_the_old_picture_or_none() {
    let room = Room::new();
    // Its warning tells that the signals are listened to.
    room.write("open.test", &format!("{SCENE}pushTransform\n"));
    for (name, old) in [("INT", None), ("TERM", Some("old"))] {
        let path = room.path().join("b.png");
        if let Some(old) = old {
            fs::write(&path, old).unwrap();
        }
        let before = room.names();
        let line =
            "render open.test -o b.png --size 4096x4096 --tile 8 --engine scalar --threads 1";
        let mut command = room.command(line);
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut said = String::new();
        while !said.contains("warning: ") {
            assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
        }
        std::thread::sleep(Duration::from_millis(200));
        signal(&child, name);
        stderr.read_to_string(&mut said).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{name}: {said}");
        assert!(
            output.stdout.is_empty() && said.contains("interrupted"),
            "{name}: {said}"
        );
        assert_eq!(room.names(), before, "{name}");
        assert_eq!(fs::read_to_string(&path).ok().as_deref(), old);
    }
}
