//! Sequences on many machines: the same bytes as on one machine, even if tasks are killed.

use super::TestFolder;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

fn bytes(room: &TestFolder, name: &str) -> Vec<u8> {
    fs::read(room.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Frames of a picture in the folder "whole", rendered by one machine.
fn rendered_whole(room: &TestFolder, name: &str, options: &str) {
    fs::create_dir_all(room.path().join("whole")).unwrap();
    room.ok(&format!("render a.test -o whole/{name} {options}"));
}

fn same_frames(room: &TestFolder, names: &[String]) {
    for name in names {
        assert!(
            bytes(room, name) == bytes(room, &format!("whole/{name}")),
            "{name}"
        );
    }
}

fn start(room: &TestFolder, line: &str) -> Child {
    let mut command = room.command(line);
    command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Lines of a list of finished frames; the first is not a frame.
fn lines_of(path: &Path) -> usize {
    let text = fs::read_to_string(path).unwrap_or_default();
    text.matches('\n').count()
}

/// Waits until a list has this number of lines, or the process has ended.
fn until_listed(child: &mut Child, path: &Path, lines: usize) {
    while lines_of(path) < lines && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn frames_of_two_nodes_are_those_of_one_machine_though_one_is_killed() {
    let room = TestFolder::new();
    let options = "--size 120x90 --tile 8 --spp 16 --frames 0..23 --turntable 24";
    rendered_whole(&room, "m.png", options);
    let plan = room.json(&format!(
        "plan a.test --shards 5 -o m.png --plan p.json {options} --json"
    ));
    assert_eq!(
        (&plan["frames"], &plan["shard_by"]),
        (&json!([0, 23]), &json!("frame"))
    );
    let node = |shard: u32| format!("render --plan p.json --shard {shard} --threads 1");
    // Both start a shard; the second dies after a frame, in the middle of another.
    let mut first = start(&room, &node(0));
    let mut second = start(&room, &node(1));
    let list = room.path().join("p.shard-1.frames");
    until_listed(&mut second, &list, 2);
    second.kill().unwrap();
    second.wait().unwrap();
    let listed = lines_of(&list) - 1;
    assert!((1..5).contains(&listed), "{listed}");
    assert!(first.wait().unwrap().success());
    room.refused(
        "merge p.json",
        6,
        &[
            " of 24 frames are missing",
            "frame 2, shard 2: p.shard-2.frames does not exist",
            "--array=1-4",
        ],
    );
    for shard in [2, 3, 4] {
        room.ok(&node(shard));
    }
    // The other one finishes its first shard from where it stopped.
    let last = "frame 21, shard 1: m.0021.png does not exist";
    room.refused(
        "merge p.json",
        6,
        &[&format!("{} of 24", 5 - listed), last, "--array=1\n"],
    );
    let before = fs::metadata(room.path().join("m.0001.png")).unwrap();
    let done = room.json(&format!("{} --json", node(1)));
    assert_eq!(
        (&done["frames"], &done["kept"]),
        (&json!(5), &json!(listed))
    );
    let after = fs::metadata(room.path().join("m.0001.png")).unwrap();
    assert_eq!(before.modified().unwrap(), after.modified().unwrap());
    let report = room.ok("merge p.json");
    assert!(
        report.contains("0 to 23, 120x90, from 5 shards, checked"),
        "{report}"
    );
    assert!(report.contains("m.0000.png to m.0023.png"), "{report}");
    let frames: Vec<String> = (0..24).map(|k| format!("m.{k:04}.png")).collect();
    same_frames(&room, &frames);
    // Nothing else is left: no tiles, no temporary files.
    let mut names: Vec<String> = frames;
    names.extend((0..5).map(|shard| format!("p.shard-{shard}.frames")));
    names.extend(["p.json".to_owned(), "whole".to_owned()]);
    names.sort();
    assert_eq!(room.names(), names);
    // It is complete: nothing is rendered again.
    let again = room.json(&format!("{} --json", node(3)));
    assert_eq!((&again["rays"], &again["kept"]), (&json!(0), &json!(5)));
}

#[test]
fn a_frame_goes_on_from_its_tiles_however_often_its_shard_is_killed() {
    let room = TestFolder::new();
    let options = "--size 200x150 --tile 8 --spp 40 --frames 7..8 --turntable 24";
    rendered_whole(&room, "m-##.png", options);
    room.ok(&format!(
        "plan a.test --shards 1 -o m-##.png --plan p.json {options}"
    ));
    let tiles = room.path().join("p.shard-0.frame-0007.tiles");
    let length = || fs::metadata(&tiles).map_or(0, |m| m.len());
    let mut longest = 0;
    for _ in 0..3 {
        let before = length();
        let mut child = start(&room, "render --plan p.json --shard 0 --threads 1");
        while length() < before + 9_001 && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let _ = child.kill();
        child.wait().unwrap();
        longest = longest.max(length());
    }
    assert!(longest > 9_001, "{longest}");
    let ran = room.run("render --plan p.json --shard 0");
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(
        ran.stderr
            .contains("resuming from p.shard-0.frame-0007.tiles"),
        "{}",
        ran.stderr
    );
    room.ok("merge p.json");
    same_frames(&room, &["m-07.png".to_owned(), "m-08.png".to_owned()]);
    assert!(!tiles.exists());
}

const WAY: &str = "3 0 0 5 0 0 0 0 1 0 45\n6 2 1 4 0 0 0 0 1 0 40\n9 3 0 3 0 0 0 0 1 0 50\n";

#[test]
fn tiles_of_each_frame_are_put_together() {
    let room = TestFolder::new();
    room.write("way", WAY);
    let options =
        "--size 100x80 --aov depth,ng --aa adaptive --spp 8 --frames 5..7 --keyframes way";
    rendered_whole(&room, "m.exr", options);
    room.ok(&format!(
        "plan a.test --shards 3 --shard-by tile -o m.exr --plan p.json {options}"
    ));
    for shard in [2, 0] {
        let done = room.json(&format!("render --plan p.json --shard {shard} --json"));
        assert_eq!(
            (&done["frames"], &done["shard_by"]),
            (&json!(3), &json!("tile"))
        );
    }
    let missing = "frame 5, shard 1: p.shard-1.frame-0005.tiles does not exist";
    room.refused(
        "merge p.json",
        6,
        &["3 of 9 parts of frames", missing, "--array=1"],
    );
    // The key frames are in the plan, so their file is not needed.
    fs::remove_file(room.path().join("way")).unwrap();
    room.ok("render --plan p.json --shard 1 --threads 1 --kernel packet8");
    let name = "p.shard-2.frame-0006.tiles";
    let good = bytes(&room, name);
    fs::write(room.path().join(name), &good[..good.len() - 5]).unwrap();
    room.refused(
        "merge p.json",
        6,
        &["1 of 9", "frame 6, shard 2: 1 of ", "--array=2"],
    );
    let done = room.json("render --plan p.json --shard 2 --json");
    assert_eq!(done["kept"], 2);
    let report = room.ok("merge p.json");
    assert!(
        report.contains("5 to 7, 100x80, from 3 shards, merged"),
        "{report}"
    );
    let frames: Vec<String> = (5..8).map(|k| format!("m.000{k}.exr")).collect();
    same_frames(&room, &frames);
    room.ok("merge p.json -o other-#.exr");
    assert!(bytes(&room, "other-7.exr") == bytes(&room, "m.0007.exr"));
    room.refused("merge p.json -o -", 2, &["cannot be written to stdout"]);
    // A plan by tile may put its frames elsewhere, if the merge is given the destination.
    let line = "plan a.test --shards 2 --shard-by tile --frames 0..1 --turntable 4";
    fs::create_dir(room.path().join("job")).unwrap();
    let ran = room.run(&format!("{line} -o m.png --plan job/p.json"));
    assert!(
        ran.stderr.contains("m.png lies outside the plan's folder"),
        "{}",
        ran.stderr
    );
    room.refused("merge job/p.json", 2, &["outside the plan's folder", "-o"]);
}

#[test]
fn pictures_are_taken_for_frames_only_as_they_were_written() {
    let room = TestFolder::new();
    let options = "--frames 0..3 --turntable 4";
    rendered_whole(&room, "m.png", options);
    room.ok(&format!(
        "plan a.test --shards 2 -o m.png --plan p.json {options}"
    ));
    // An earlier picture has the name of a frame, but is not one.
    room.write("m.0002.png", "of somebody else");
    let ran = room.run("render --plan p.json --shard 0");
    let note = "m.0002.png is not listed as a frame of this plan: rendering it again";
    assert!(
        ran.code == Some(0) && ran.stderr.contains(note),
        "{}",
        ran.stderr
    );
    room.ok("render --plan p.json --shard 1");
    room.ok("merge p.json");
    let good = bytes(&room, "m.0003.png");
    let mut bad = good.clone();
    let middle = bad.len() / 2;
    bad[middle] ^= 1;
    for changed in [
        bad,
        good[..good.len() - 1].to_vec(),
        bytes(&room, "m.0002.png"),
    ] {
        fs::write(room.path().join("m.0003.png"), changed).unwrap();
        let why = "frame 3, shard 1: m.0003.png has changed since it was written";
        room.refused(
            "merge p.json",
            6,
            &["1 of 4 frames are missing", why, "--array=1"],
        );
        let ran = room.run("render --plan p.json --shard 1 --json");
        assert!(
            ran.stderr
                .contains("has changed since it was written: rendering it again"),
            "{}",
            ran.stderr
        );
        let done: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(done["kept"], 1);
        assert!(bytes(&room, "m.0003.png") == good);
    }
    // A truncated list loses the frames that it no longer names.
    let list = bytes(&room, "p.shard-0.frames");
    fs::write(
        room.path().join("p.shard-0.frames"),
        &list[..list.len() - 3],
    )
    .unwrap();
    room.refused(
        "merge p.json",
        6,
        &["frame 2, shard 0: m.0002.png is not listed"],
    );
    assert_eq!(
        room.json("render --plan p.json --shard 0 --json")["kept"],
        1
    );
    room.ok("merge p.json");
    // Exposure does not affect the pixels of tiles, but it does affect frames.
    room.ok(&format!(
        "plan a.test --shards 2 -o m.png --plan p.json {options} --exposure 1"
    ));
    room.refused(
        "merge p.json",
        6,
        &[
            "4 of 4 frames are missing",
            "not listed as a frame of this plan",
        ],
    );
    room.ok("render --plan p.json --shard 0");
    room.ok(&format!(
        "render a.test -o whole/m.png {options} --exposure 1"
    ));
    same_frames(&room, &["m.0000.png".to_owned(), "m.0002.png".to_owned()]);
}

#[test]
fn a_sequence_that_has_changed_meanwhile_is_refused() {
    let room = TestFolder::new();
    room.write("way", WAY);
    let plan = "plan a.test --shards 2 -o m.png --plan p.json --frames 3..6 --keyframes way";
    room.ok(plan);
    room.ok("render --plan p.json --shard 0");
    let moved = WAY.replace("2 1 4", "2 1 4.5");
    for changed in [&moved[..], "nothing of the kind"] {
        room.write("way", changed);
        let parts = [
            "the key frames in ",
            "/way have changed; make the plan again",
        ];
        room.refused("render --plan p.json --shard 1", 2, &parts);
    }
    // Only comments have changed.
    room.write("way", &format!("# A way.\n{WAY}"));
    room.ok("render --plan p.json --shard 1");
    room.ok("merge p.json");
    // After creating the plan again, earlier results belong to another sequence.
    room.write("way", &moved);
    room.ok(plan);
    let parts =
        ["p.shard-0.frames: lists frames of another sequence: the checksum of the camera's path"];
    room.refused("render --plan p.json --shard 0", 2, &parts);
    room.refused("merge p.json", 2, &parts);
    room.write("way", WAY);
    room.ok(&format!("{plan} --spp 2"));
    let parts = ["another sequence: --spp is 1 there and 2 here"];
    room.refused("render --plan p.json --shard 0", 2, &parts);
    room.refused("submit slurm p.json --dry-run", 2, &parts);
    // The same holds for shards of tiles.
    room.ok(&format!("{plan} --shard-by tile").replace("p.json", "t.json"));
    room.ok("render --plan t.json --shard 0");
    room.write("way", &moved);
    room.ok(&format!("{plan} --shard-by tile").replace("p.json", "t.json"));
    room.refused(
        "merge t.json",
        2,
        &["t.shard-0.frame-0004.tiles: holds tiles of another picture: the frame's view is "],
    );
    // The scene has changed.
    let scene = fs::read_to_string(room.path().join("a.test")).unwrap();
    room.write("a.test", &format!("{scene}\nsphere 0 0 0 .1\n"));
    room.refused(
        "render --plan p.json --shard 0",
        2,
        &["another picture: the scene's fingerprint"],
    );
}

#[test]
fn two_processes_do_not_render_one_shard() {
    for split in ["frame", "tile"] {
        let room = TestFolder::new();
        room.ok(&format!(
            "plan a.test --shards 1 --shard-by {split} -o m.png --plan p.json --frames 0..2 --turntable 4 --size 400x300 --tile 8 --spp 60"
        ));
        let mut child = start(&room, "render --plan p.json --shard 0 --threads 1");
        let first = room.path().join("p.shard-0.frame-0000.tiles");
        while !first.exists() && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let ran = room.run("render --plan p.json --shard 0");
        assert_eq!(ran.code, Some(1), "{}", ran.stderr);
        assert!(
            ran.stderr
                .contains("p.shard-0.frames: another render is using it"),
            "{}",
            ran.stderr
        );
        let _ = child.kill();
        child.wait().unwrap();
    }
}

#[test]
fn sequences_that_cannot_be_planned_are_refused() {
    let room = TestFolder::new();
    fs::create_dir(room.path().join("job")).unwrap();
    let refused = |options: &str, parts: &[&str]| {
        let line = format!("plan a.test --plan job/p.json {options}");
        room.refused(&line, 2, parts);
    };
    let turn = "--frames 0..3 --turntable 4";
    refused(
        &format!("--shards 5 -o job/m.png {turn}"),
        &["shards is 5", "the 4 frames", "by tile"],
    );
    refused(
        &format!("--shards 2 -o m.png {turn}"),
        &[
            "m.0000.png lies outside the plan's folder",
            "--shard-by tile",
        ],
    );
    refused("--shards 2 -o job/m.png --frames 0..3", &["--turntable"]);
    refused("--shards 2 -o job/m.png --shard-by tile", &["--turntable"]);
    refused(
        &format!("--shards 2 -o job/m.png {turn} --shard-by row"),
        &["frame", "tile"],
    );
    room.write("bad", "0 1 2 3\n");
    refused(
        "--shards 2 -o job/m.png --frames 0..3 --keyframes bad",
        &["bad:1: expected 10 numbers"],
    );
    room.write(
        "through",
        "0 0 0 5 0 0 0 0 1 0 45\n2 0 0 -5 0 0 0 0 1 0 45\n",
    );
    refused(
        "--shards 2 -o job/m.png --frames 0..2 --keyframes through",
        &["frame 1: "],
    );
    let line = format!("plan a.test --shards 2 --plan m.0003.png -o m.png {turn}");
    room.refused(&line, 2, &["m.0003.png", "the same file"]);
    room.ok(&format!(
        "plan a.test --shards 2 --plan job/p.json -o job/m.png {turn}"
    ));
    room.refused(
        "render --plan job/p.json --shard 2",
        2,
        &["there is no shard 2"],
    );
    room.refused(
        "merge job/p.json -o x.png",
        2,
        &["-o and --format cannot be used"],
    );
    room.refused(
        "submit slurm job/p.json -o x.png --dry-run",
        2,
        &["-o cannot be used"],
    );
}

#[test]
fn a_plan_sends_its_frames_nowhere_but_into_its_folder() {
    let room = TestFolder::new();
    for folder in ["job", "else"] {
        fs::create_dir(room.path().join(folder)).unwrap();
    }
    room.ok("plan a.test --shards 1 --plan job/p.json -o job/m.png --frames 0..1 --turntable 4");
    let plan: Value = serde_json::from_slice(&bytes(&room, "job/p.json")).unwrap();
    room.write("else/x.png", "theirs");
    std::os::unix::fs::symlink("../else/x.png", room.path().join("job/y.0001.png")).unwrap();
    for output in ["../else/m.png", "/m.png", "y.png"] {
        let mut forged = plan.clone();
        forged["output"] = json!(output);
        room.write("job/p.json", &forged.to_string());
        let ran = room.run("render --plan job/p.json --shard 0");
        assert_eq!(ran.code, Some(2), "{output}: {}", ran.stderr);
        assert!(
            ran.stderr.contains("lies outside the plan's folder"),
            "{}",
            ran.stderr
        );
    }
    assert_eq!(bytes(&room, "else/x.png"), b"theirs");
    assert_eq!(fs::read_dir(room.path().join("else")).unwrap().count(), 1);
}

#[test]
fn plans_are_carried_out_however_much_was_told_when_they_were_made() {
    let room = TestFolder::new();
    for (before, after) in [("-q", ""), ("--verbose", ""), ("", "-v"), ("", "--quiet")] {
        let line = "--shards 1 -o m.png --plan p.json --frames 0..1 --turntable 4";
        room.ok(&format!("{before} plan a.test {line} {after}"));
        assert_eq!(
            room.ok("render --plan p.json --shard 0 -q"),
            "",
            "{before}{after}"
        );
    }
}

#[test]
fn shards_of_frames_are_tasks_of_an_array() {
    let room = TestFolder::new();
    room.ok("plan a.test --shards 3 --plan p.json -o m.png --frames 0..5 --turntable 6");
    room.ok("render --plan p.json --shard 1");
    let report = room.ok("submit slurm p.json --dry-run");
    assert!(report.contains(" --array=0,2 "), "{report}");
    room.carry_out(&report);
    let script = |name: &str, index: &str| {
        let mut shell = std::process::Command::new("bash");
        shell.arg(room.path().join(name)).current_dir(room.path());
        shell
            .env("SLURM_ARRAY_TASK_ID", index)
            .env("SLURM_CPUS_ON_NODE", "1");
        super::ran(&mut shell)
    };
    let early = script("p.merge.sh", "");
    assert_eq!(early.code, Some(6), "{}", early.stderr);
    for shard in ["0", "2"] {
        let ran = script("p.shards.sh", shard);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    }
    let report = room.ok("submit slurm p.json --dry-run");
    assert!(!report.contains("--array"), "{report}");
    assert_eq!(script("p.merge.sh", "").code, Some(0));
}
