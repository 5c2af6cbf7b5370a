//! Pictures rendered in parts, interrupted, and shared among machines: always the same bytes.

use super::TestFolder;
use super::signals::signal;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

fn bytes(room: &TestFolder, name: &str) -> Vec<u8> {
    fs::read(room.path().join(name)).unwrap()
}

/// Rows of a PFM's pixels, 12 bytes each, from the top.
fn rows(file: &[u8], width: usize) -> Vec<Vec<&[u8]>> {
    let head = file.windows(6).position(|w| w == b"\n-1.0\n").unwrap() + 6;
    let rows = file[head..].chunks(12 * width).rev();
    rows.map(|row| row.chunks(12).collect()).collect()
}

#[test]
fn a_region_is_a_part_of_the_picture() {
    let room = TestFolder::new();
    let adaptive = "--aa adaptive --spp 20 --threshold .01";
    for options in ["", "--spp 3 --filter mitchell", "--engine scalar", adaptive] {
        room.ok(&format!("render a.test -o whole.pfm {options}"));
        let full = bytes(&room, "whole.pfm");
        let full = rows(&full, 40);
        for [x, y, w, h] in [
            [0, 0, 40, 24],
            [3, 5, 20, 7],
            [39, 23, 1, 1],
            [8, 8, 16, 16],
        ] {
            room.ok(&format!(
                "render a.test -o part.pfm --region {x} {y} {w} {h} --tile 8 {options}"
            ));
            let part = bytes(&room, "part.pfm");
            let cut: Vec<Vec<&[u8]>> = full[y..y + h]
                .iter()
                .map(|r| r[x..x + w].to_vec())
                .collect();
            assert!(rows(&part, w) == cut, "{x} {y} {w} {h} {options}");
        }
    }
    room.ok("verify a.test --region 3 5 21 13 --kernel all --spp 2");
    let json = room.json("render a.test -o part.png --region 3 5 20 7 --json");
    assert_eq!(json["image"]["width"], 20);
    assert_eq!(json["image"]["region"], serde_json::json!([3, 5, 40, 24]));
    assert_eq!(json["rays"]["primary"], 140);
}

/// Adaptive sampling decides in blocks of the whole picture, whichever part is requested.
#[test]
fn adaptive_samples_of_a_region_look_beyond_its_borders() {
    let room = TestFolder::new();
    for engine in ["simd", "scalar"] {
        let options =
            format!("--size 160x96 --aa adaptive --spp 64 --threshold .004 --engine {engine}");
        room.ok(&format!("render a.test -o whole.pfm {options}"));
        let full = bytes(&room, "whole.pfm");
        let full = rows(&full, 160);
        for [x, y, w, h] in [[45, 27, 70, 50], [60, 40, 1, 1], [61, 37, 13, 3]] {
            room.ok(&format!(
                "render a.test -o part.pfm --region {x} {y} {w} {h} {options}"
            ));
            let part = bytes(&room, "part.pfm");
            let cut: Vec<Vec<&[u8]>> = full[y..y + h]
                .iter()
                .map(|r| r[x..x + w].to_vec())
                .collect();
            assert!(rows(&part, w) == cut, "{engine} {x} {y} {w} {h}");
        }
    }
}

#[test]
fn regions_that_do_not_lie_in_the_picture_are_refused() {
    let room = TestFolder::new();
    for region in [
        "40 0 1 1",
        "0 0 41 1",
        "1 1 0 1",
        "4294967295 0 4294967295 9",
    ] {
        for command in ["render", "verify"] {
            let line = format!("{command} a.test --region {region}");
            room.refused(&line, 2, &["--region", "40x24"]);
        }
    }
    room.refused("render a.test --region 1 2 3", 2, &["4 values", "--region"]);
    room.refused("render a.test --region -1 2 3 4", 2, &["-1"]);
}

/// A picture that takes a second or more, in many tiles.
const LONG: &str = "render a.test -o a.png --size 400x300 --tile 8 --threads 2 --spp 40";

fn start(room: &TestFolder, line: &str) -> Child {
    room.command(line)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits until the file has grown by `by` bytes, or the process has ended.
fn until_grown(child: &mut Child, path: &Path, bytes: u64) {
    let length = || fs::metadata(path).map_or(0, |m| m.len());
    let before = length();
    while length() < before + bytes && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_signal_ends_a_render_in_order_and_the_same_command_goes_on() {
    let room = TestFolder::new();
    room.ok(LONG);
    let full = bytes(&room, "a.png");
    let line = format!("{LONG} --checkpoint a.tiles");
    for (name, code) in [("INT", 130), ("TERM", 143)] {
        fs::remove_file(room.path().join("a.png")).unwrap();
        let _ = fs::remove_file(room.path().join("a.tiles"));
        let mut child = start(&room, &line);
        until_grown(&mut child, &room.path().join("a.tiles"), 50_000);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{stderr}");
        assert!(
            stderr.contains("a.tiles; run the same command to resume"),
            "{stderr}"
        );
        assert_eq!(room.names(), ["a.tiles"]);
        let ran = room.run(&line);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert!(
            ran.stderr.contains("resuming from a.tiles, "),
            "{}",
            ran.stderr
        );
        assert!(bytes(&room, "a.png") == full);
        // It is complete now: nothing is left to render, for any tile size.
        let json = room.json(&format!(
            "{} --checkpoint a.tiles --json",
            LONG.replace("--tile 8", "--tile 32 --kernel packet8")
        ));
        assert_eq!(json["rays"]["total"], 0);
        assert!(bytes(&room, "a.png") == full);
    }
}

#[test]
fn a_killed_render_goes_on_from_what_it_has() {
    let room = TestFolder::new();
    room.ok(LONG);
    let full = bytes(&room, "a.png");
    fs::remove_file(room.path().join("a.png")).unwrap();
    let tiles = room.path().join("a.tiles");
    let line = format!("{LONG} --checkpoint a.tiles");
    // Killed a little later in the writing of a tile each time, and once during start-up.
    for kill in 0..10 {
        let mut child = start(&room, &line);
        until_grown(&mut child, &tiles, kill * 9_001);
        let _ = child.kill();
        child.wait().unwrap();
    }
    // A byte of a tile is changed, too.
    let mut file = bytes(&room, "a.tiles");
    let middle = file.len() / 2;
    file[middle] ^= 1;
    fs::write(&tiles, file).unwrap();
    let ran = room.run(&line);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stderr.contains("1 damaged tiles"), "{}", ran.stderr);
    assert!(bytes(&room, "a.png") == full);
}

#[cfg(unix)]
#[test]
fn a_file_that_cannot_grow_ends_the_render_and_what_it_has_is_good() {
    let room = TestFolder::new();
    room.ok(LONG);
    let full = bytes(&room, "a.png");
    let line = format!("{LONG} --checkpoint a.tiles");
    // Blocks of 512 bytes or of 1024: less than the tiles of the picture take either way.
    let script = "trap '' XFSZ; ulimit -f 800; exec \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, "sh", env!("CARGO_BIN_EXE_phalanx")]);
    let limited = super::ran(command.current_dir(room.path()).args(line.split(' ')));
    assert_eq!(limited.code, Some(1), "{}", limited.stderr);
    assert!(
        limited.stderr.contains("cannot use a.tiles"),
        "{}",
        limited.stderr
    );
    assert!(
        bytes(&room, "a.png") == full,
        "the old picture is still there"
    );
    let ran = room.run(&line);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stderr.contains("resuming from "), "{}", ran.stderr);
    assert!(bytes(&room, "a.png") == full);
}

#[test]
fn a_finished_checkpoint_stays_and_the_report_says_so() {
    let room = TestFolder::new();
    let line = "render a.test --checkpoint c.ckpt";
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    for more in ["-o a.png", "-o b.png", "-o b.png --verbose"] {
        let report = room.ok(&format!("{line} {more}"));
        let size = bytes("c.ckpt").len() as f64 / 1024.0;
        let line_about_tiles = format!(
            "\nkept         c.ckpt: {size:.1} KiB of tiles, to resume or rewrite the picture\n"
        );
        assert!(report.contains(&line_about_tiles), "{more}: {report}");
    }
    assert!(bytes("a.png") == bytes("b.png"));
    // Nothing is traced for another exposure or format, either.
    let json = room.json(&format!("{line} -o c.jpg --exposure 1 --json"));
    assert_eq!(json["rays"]["total"], 0);
    assert_eq!(json["checkpoint"]["bytes"], bytes("c.ckpt").len());
    room.ok("render a.test -o d.jpg --exposure 1");
    assert!(bytes("c.jpg") == bytes("d.jpg"));
    let line = "render a.test -o f.png --turntable 3 --checkpoint f.ckpt --json";
    let sizes = ["f.0000.ckpt", "f.0001.ckpt", "f.0002.ckpt"];
    let json = room.json(line);
    let all: usize = sizes.iter().map(|name| bytes(name).len()).sum();
    assert_eq!(json["checkpoint"]["bytes"], all);
    assert!(room.json("render a.test -o a.png --json")["checkpoint"].is_null());
}

#[test]
fn a_checkpoint_of_another_picture_is_refused() {
    let room = TestFolder::new();
    room.ok("render a.test -o a.png --checkpoint a.tiles");
    let refused = |options: &str, parts: &[&str]| {
        let line = format!("render a.test -o a.png --checkpoint a.tiles {options}");
        room.refused(&line, 2, parts);
    };
    refused(
        "--size 41x24",
        &[
            "another picture: --size is 40x24 there and 41x24 here; ",
            "choose another file",
        ],
    );
    refused(
        "--spp 2",
        &["another picture: --spp is 1 there and 2 here; "],
    );
    refused(
        "--aperture .1 --focus 2 --filter tent",
        &[
            "--filter is box there and tent here, --aperture is not given there and 0.1 here, \
             --focus is not given there and 2.0 here; ",
        ],
    );
    refused("--background .1,.2,.3", &["the scene's fingerprint is "]);
    room.write("notes", "my notes");
    room.refused(
        "render a.test --checkpoint notes",
        2,
        &["not a file of finished tiles"],
    );
    assert_eq!(bytes(&room, "notes"), b"my notes");
    room.refused("render a.test --checkpoint no/where", 1, &["no/where"]);
}

#[test]
fn merged_shards_are_the_picture_to_the_last_byte() {
    let room = TestFolder::new();
    let options = "--size 200x150 --spp 20 --aa adaptive --threshold .02 --transfer srgb --quantize round --bits 16 --exposure .5";
    room.ok(&format!("render a.test -o whole.png {options}"));
    let full = bytes(&room, "whole.png");
    for shards in [1u32, 2, 7, 64] {
        room.ok(&format!(
            "plan a.test --shards {shards} -o merged.png --plan p{shards}.json {options}"
        ));
        // In a different order, each with other settings that do not affect the bits.
        for k in 0..shards {
            let shard = (k * 37 + 5) % shards;
            let how = [
                "--threads 1",
                "--threads 2 --kernel packet8",
                "--engine scalar",
            ];
            let how = how[k as usize % 3];
            room.ok(&format!(
                "render --plan p{shards}.json --shard {shard} {how}"
            ));
        }
        room.ok(&format!("merge p{shards}.json"));
        assert!(bytes(&room, "merged.png") == full, "{shards} shards");
        fs::remove_file(room.path().join("merged.png")).unwrap();
    }
    // The picture of a region, in other formats, from another folder.
    for (k, (ending, options)) in (0..).zip([
        ("exr", "--aov all"),
        ("exr", "--aov all,alpha --bits 16"),
        ("png", "--aov alpha --bits 16"),
        ("png", "--aov alpha --transfer srgb"),
    ]) {
        let region = format!(
            "--size 200x150 --region 13 9 101 77 {options} --spp 20 --aa adaptive --threshold .02"
        );
        room.ok(&format!("render a.test -o whole.{ending} {region}"));
        room.ok(&format!(
            "plan a.test --shards 3 -o merged.{ending} --plan r{k}.json {region}"
        ));
        for shard in 0..3 {
            room.ok(&format!("render --plan r{k}.json --shard {shard}"));
        }
        room.ok(&format!("merge r{k}.json -o other.{ending}"));
        let same =
            bytes(&room, &format!("other.{ending}")) == bytes(&room, &format!("whole.{ending}"));
        assert!(same, "{ending} {options}");
    }
}

#[test]
fn shards_that_are_missing_are_named() {
    let room = TestFolder::new();
    room.ok("plan a.test --shards 9 -o m.png --plan p.json");
    room.refused(
        "merge p.json",
        6,
        &["9 of 9 shards are missing", "--array=0-8"],
    );
    for (variable, shard) in [("SLURM_ARRAY_TASK_ID", 3), ("JOB_COMPLETION_INDEX", 4)] {
        let mut command = room.command("render --plan p.json --shard auto");
        let ran = super::ran(command.env(variable, shard.to_string()));
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert!(
            ran.stderr
                .contains(&format!("shard {shard} of 9, from {variable}"))
        );
    }
    for shard in [0, 1, 2, 5, 7] {
        room.ok(&format!("render --plan p.json --shard {shard}"));
    }
    room.refused(
        "merge p.json",
        6,
        &["2 of 9", "--array=6,8", "p.shard-6.tiles does not exist"],
    );
    for shard in [6, 8] {
        room.ok(&format!("render --plan p.json --shard {shard}"));
    }
    let name = "p.shard-3.tiles";
    let good = bytes(&room, name);
    let mut bad = good.clone();
    let last = bad.len() - 1;
    bad[last] ^= 1;
    fs::write(room.path().join(name), bad).unwrap();
    room.refused(
        "merge p.json",
        6,
        &["1 of 9", "--array=3", "1 of them damaged"],
    );
    // The same command repairs it.
    let json = room.json("render --plan p.json --shard 3 --json");
    let most = json["tiles"].as_u64().unwrap() - 1;
    assert_eq!(json["kept"], most);
    room.ok("merge p.json");
    room.ok("render a.test -o whole.png");
    assert!(bytes(&room, "m.png") == bytes(&room, "whole.png"));
}

#[test]
fn plans_that_do_not_fit_are_refused() {
    let room = TestFolder::new();
    room.ok("plan a.test --shards 2 -o m.png --plan p.json --spp 2");
    room.refused(
        "render --plan p.json --shard 2",
        2,
        &["there is no shard 2", "from 0 to 1"],
    );
    room.refused(
        "render --plan p.json --shard auto",
        2,
        &["SLURM_ARRAY_TASK_ID", "--shard 0"],
    );
    room.refused("render --plan p.json", 2, &["--shard"]);
    room.refused("render --shard 1", 2, &["--plan"]);
    room.refused("render a.test --plan p.json --shard 1", 2, &["--plan"]);
    room.refused("render --plan p.json --shard 1 --spp 3", 2, &["--spp"]);
    room.refused("render --plan p.json --shard x", 2, &["auto"]);
    room.refused("merge a.test", 1, &["not a plan"]);
    room.refused(
        "plan a.test --shards 0 -o m.png --plan q.json",
        2,
        &["--shards"],
    );
    room.refused(
        "plan a.test --shards 2 -o m.bmp --plan q.json",
        2,
        &[".bmp"],
    );
    // The scene has changed.
    let scene = fs::read_to_string(room.path().join("a.test")).unwrap();
    room.write("a.test", &format!("{scene}\nsphere 0 0 0 .1\n"));
    room.refused(
        "render --plan p.json --shard 0",
        2,
        &["another picture: the scene's fingerprint", "again"],
    );
}

#[test]
fn a_sequence_is_its_frames_one_by_one() {
    let room = TestFolder::new();
    room.ok("render a.test -o one.png");
    let report = room.ok("render a.test -o b.png --frames 0..3 --turntable 4 --checkpoint b.tiles");
    assert!(
        report.contains("frame 3: ")
            && report.contains("written      b.0000.png to b.0003.png: 40x24, 1 sample per pixel, linear (see --transfer)\n"),
        "{report}"
    );
    let frames: Vec<_> = (0..4)
        .map(|k| bytes(&room, &format!("b.000{k}.png")))
        .collect();
    // The first is the scene's own view; all are different.
    assert!(frames[0] == bytes(&room, "one.png"));
    assert!((1..4).all(|k| frames[k] != frames[k - 1]));
    // A frame on its own equals the one in a sequence, and finished frames are not rendered again.
    room.ok("render a.test -o c-##.png --frames 2..2 --turntable 4 --threads 1");
    assert!(bytes(&room, "c-02.png") == frames[2]);
    let json =
        room.json("render a.test -o b.png --frames 0..3 --turntable 4 --checkpoint b.tiles --json");
    assert_eq!(
        (&json["rays"]["total"], &json["image"]["frames"]),
        (&0.into(), &serde_json::json!([0, 3]))
    );
    room.ok("verify a.test --frames 1..2 --turntable 4 --threads 2");
    // Likewise for constant key frames.
    room.write(
        "way",
        "3 0 0 5 0 0 0 0 1 0 40\n# still\n9 0 0 5 0 0 0 0 1 0 40\n",
    );
    room.ok("render a.test -o k.png --frames 5..6 --keyframes way");
    assert!(bytes(&room, "k.0005.png") == bytes(&room, "k.0006.png"));
    room.write("bad", "0 1 2 3\n");
    room.refused(
        "render a.test -o k.png --frames 5..6 --keyframes bad",
        2,
        &["bad:1: expected 10 numbers"],
    );
    room.refused("render a.test -o k.png --frames 5..6", 2, &["--turntable"]);
    // Without --frames, all of them: once around, and from the first to the last key frame.
    for (options, first, last) in [("--turntable 3", 0, 2), ("--keyframes way", 3, 9)] {
        let room_of = format!("frames-{first}");
        fs::create_dir(room.path().join(&room_of)).unwrap();
        room.ok(&format!(
            "render a.test -o {room_of}/#.png --size 8x8 {options}"
        ));
        let made = fs::read_dir(room.path().join(&room_of)).unwrap().count();
        assert_eq!(made, last - first + 1, "{options}");
        for k in first..=last {
            bytes(&room, &format!("{room_of}/{k}.png"));
        }
    }
    room.refused(
        "render a.test -o k.png --frames 6..5 --turntable 6",
        2,
        &["0..119"],
    );
}

#[test]
fn adaptive_pictures_report_their_limit_as_one() {
    let room = TestFolder::new();
    let report = room.ok("render a.test -o a.exr --aa adaptive --spp 16");
    assert!(
        report.ends_with(": 40x24, up to 16 samples per pixel\n"),
        "{report}"
    );
}

#[test]
fn progress_is_told_in_lines_of_json_and_pictures_are_shown_before_they_are_done() {
    let room = TestFolder::new();
    let ran = room.run(&format!("{LONG} --progress json --snapshot s.png"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let lines: Vec<serde_json::Value> = ran
        .stderr
        .lines()
        .filter(|line| line.starts_with('{'))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let (first, last) = (&lines[0], &lines[lines.len() - 1]);
    assert_eq!(
        (&first["event"], &last["event"]),
        (&"progress".into(), &"end".into())
    );
    assert!(first["seconds_left"].is_null() || first["pixels"].as_u64() > Some(0));
    assert_eq!(
        (&last["pixels"], &last["of"]),
        (&120_000.into(), &120_000.into())
    );
    assert_eq!(
        (&last["fraction"], &last["seconds_left"]),
        (&1.0.into(), &0.0.into())
    );
    let pixels: Vec<_> = lines.iter().map(|line| line["pixels"].as_u64()).collect();
    assert!(pixels.is_sorted(), "{pixels:?}");
    // At the end the snapshot is the final picture.
    let load = |name: &str| {
        phalanx::image::load(&room.path().join(name))
            .unwrap()
            .pixels
    };
    assert!(load("s.png") == load("a.png"));
    assert_eq!(room.run("render a.test --progress none").stderr, "");
    room.refused("render a.test --preview", 2, &["--preview", "--snapshot"]);
    room.refused("render a.test --snapshot s.exr", 2, &["--snapshot", ".png"]);
}
