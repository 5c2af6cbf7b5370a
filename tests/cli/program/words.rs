//! Remarks on arguments without effect or out of proportion, their timing, and leftover files.

use super::signals::signal;
use super::{TestFolder, ran};
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

#[test]
fn the_example_of_help_runs_in_any_folder() {
    let room = TestFolder::new();
    let help = room.ok("--help");
    let mut lines = help.lines().map(str::trim_start);
    let example = lines.find_map(|line| line.strip_prefix("phalanx render "));
    let example = example.expect("an example");
    room.ok(&format!("render {example} --size 32x24"));
    assert_eq!(room.names(), ["balls.png"]);
    room.ok(&format!("render {example} --size 32x24 -o other.png"));
}

#[test]
fn keyframes_without_a_view_are_refused_before_the_first_frame() {
    let room = TestFolder::new();
    room.write("keys", "0 0 0 5 0 0 0 0 1 0 45\n4 0 0 -5 0 0 0 0 1 0 45\n");
    let line = "render a.test -o k.png --frames 0..4 --keyframes keys";
    room.refused(line, 2, &["frame 2: the camera stands on the point"]);
}

#[test]
fn frames_and_their_checkpoints_are_files_of_their_own() {
    let room = TestFolder::new();
    let line = "render a.test -o b.png --checkpoint b.##### --frames 3..4 --turntable 9";
    room.ok(line);
    for other in [
        "-o b.png --checkpoint b.####.png",
        "-o b.#.png --checkpoint b.png --snapshot b.3.png",
    ] {
        let line = format!("render a.test {other} --frames 3..4 --turntable 9");
        room.refused(&line, 2, &["are the same file"]);
    }
}

#[test]
fn the_report_of_frames_names_files_that_are_there() {
    let room = TestFolder::new();
    let written = |stdout: &str| {
        let row = stdout
            .lines()
            .find_map(|line| line.strip_prefix("written "));
        let (files, _) = row.expect("a row").split_once(": ").expect("a size");
        files.trim_start().to_owned()
    };
    let line = "render a.test -o b.png --turntable 9 --frames";
    let several = written(&room.ok(&format!("{line} 3..5")));
    assert_eq!(several, "b.0003.png to b.0005.png");
    assert_eq!(written(&room.ok(&format!("{line} 3..3"))), "b.0003.png");
    let json = room.json(&format!("{line} 4..5 --json"));
    assert_eq!(json["image"]["path"], "b.0004.png");
    assert_eq!(room.names(), ["b.0003.png", "b.0004.png", "b.0005.png"]);
}

#[test]
fn what_changes_nothing_is_said() {
    let room = TestFolder::new();
    room.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    room.write("keys", "0 0 0 5 0 0 0 0 1 0 45\n");
    let notes_of = |line: &str| {
        let ran = room.run(&format!("render -o b.png --size 8x8 {line}"));
        assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
        ran.stderr
    };
    let camera = "--camera 0,0,5 0,0,0 0,1,0 45";
    for (line, option) in [
        ("a.test --material kd=1", "--material"),
        ("a.test --light 1,2,3 --integrator ao", "--light"),
        (
            &format!("a.test {camera} --frames 0..0 --keyframes keys"),
            "--camera",
        ),
    ] {
        let note = format!("{option} has no effect");
        let notes_of = notes_of(line);
        assert_eq!(notes_of.matches(&note).count(), 1, "{line}: {notes_of}");
    }
    for line in [
        "bare.obj --material kd=1",
        "a.test --light 1,2,3",
        &format!("a.test {camera}"),
    ] {
        assert!(!notes_of(line).contains("has no effect"), "{line}");
    }
}

#[test]
fn more_threads_than_cpus_are_noted() {
    let room = TestFolder::new();
    let line = "render a.test -o b.png --size 8x8 --threads";
    let many = room.run(&format!("{line} 999"));
    assert_eq!(many.code, Some(0));
    assert!(
        many.stderr.contains("--threads 999 is more than"),
        "{}",
        many.stderr
    );
    assert_eq!(room.run(&format!("{line} 1")).stderr, "");
}

#[test]
fn a_name_stays_on_its_line() {
    let room = TestFolder::new();
    let name = "we\nird\u{1b}[2J.test";
    room.write(name, "size 8 8\nnonsense\n");
    let shown = "we\\nird\\u{1b}[2J";
    for (command, arguments) in [
        ("render", vec![name]),
        ("info", vec![name]),
        ("info", vec!["we\nird\u{1b}[2J.none"]),
        ("render", vec!["a.test", "-o", "no\nwe\nird\u{1b}[2J/b.png"]),
        ("compare", vec![name, "a.png"]),
    ] {
        let ran = ran(room.command(command).args(&arguments));
        assert_ne!(ran.code, Some(0));
        assert!(ran.stderr.contains(shown), "{arguments:?}: {}", ran.stderr);
        assert!(
            !ran.stderr.contains("we\nird"),
            "{arguments:?}: {}",
            ran.stderr
        );
    }
    let mut render = room.command("render a.test --size 8x8");
    let written = ran(render.args(["-o", "we\nird.png"]));
    assert!(
        written.stdout.contains(
            "written      we\\nird.png: 8x8, 1 sample per pixel, linear (see --transfer)\n"
        ),
        "{}",
        written.stdout
    );
}

/// Starts a long render, and waits until it has started.
fn begun(room: &TestFolder, program: &str) -> std::process::Child {
    room.write("open.test", &format!("{}pushTransform\n", super::SCENE));
    let line = "render open.test -o b.png --size 4096x4096 --tile 8 --engine scalar --threads 1";
    let phalanx = room.command(line);
    let mut command = match program {
        "" => phalanx,
        _ => {
            let mut command = std::process::Command::new(program);
            command.current_dir(room.path()).arg(phalanx.get_program());
            command.args(phalanx.get_args());
            command
        }
    };
    let streams = command.stdin(Stdio::null()).stdout(Stdio::piped());
    let mut child = streams.stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut messages = String::new();
    while !messages.contains("warning: ") {
        assert!(stderr.read_line(&mut messages).unwrap() > 0, "{messages}");
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    // Later messages are read, so that the program never waits for space in the pipe.
    std::thread::spawn(move || std::io::copy(&mut stderr, &mut std::io::sink()));
    child
}

#[test]
fn a_hangup_ends_a_render_as_other_signals_do() {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    if ignored.is_some_and(|mask| mask.ends_with(['1', '3', '5', '7', '9', 'b', 'd', 'f'])) {
        eprintln!("skipped: these tests run under nohup, whose children ignore hangups");
        return;
    }
    let room = TestFolder::new();
    let mut child = begun(&room, "");
    signal(&child, "HUP");
    assert_eq!(child.wait().unwrap().code(), Some(129));
    assert_eq!(room.names(), ["open.test"]);
    // `nohup` disables it.
    let mut child = begun(&room, "nohup");
    signal(&child, "HUP");
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "goes on");
    signal(&child, "TERM");
    assert_eq!(child.wait().unwrap().code(), Some(143));
}

#[test]
fn what_a_killed_run_leaves_is_removed_and_what_a_living_one_needs_is_not() {
    let room = TestFolder::new();
    let mut living = begun(&room, "");
    let parts = || {
        let names = room.names().into_iter();
        names
            .filter(|name| name.ends_with(".part"))
            .collect::<Vec<_>>()
    };
    let mut waited = 0;
    while parts().is_empty() && waited < 100 {
        std::thread::sleep(std::time::Duration::from_millis(100));
        waited += 1;
    }
    let its_own = parts();
    assert_eq!(its_own.len(), 1, "{:?}", room.names());
    room.ok("render a.test -o c.png --size 8x8");
    assert_eq!(parts(), its_own);
    living.kill().unwrap();
    living.wait().unwrap();
    assert_eq!(parts(), its_own, "a leftover");
    room.ok("render a.test -o c.png --size 8x8");
    assert!(parts().is_empty(), "{:?}", parts());
    assert!(fs::metadata(room.path().join("b.png")).is_err());
}
