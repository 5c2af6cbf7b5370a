//! Closed pipes and signals.

use super::{SCENE, TestFolder, ran};
use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let room = TestFolder::new();
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
pub fn signal(child: &std::process::Child, name: &str) {
    let id = child.id().to_string();
    let sent = Command::new("kill")
        .args([OsStr::new("-s"), name.as_ref(), id.as_ref()])
        .status();
    assert!(sent.unwrap().success());
}

#[test]
fn an_interrupted_render_leaves_the_old_picture_or_none() {
    let room = TestFolder::new();
    // Its warning indicates that signal handlers are installed.
    room.write("open.test", &format!("{SCENE}pushTransform\n"));
    for (name, code, old) in [("INT", 130, None), ("TERM", 143, Some("old"))] {
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
        let mut messages = String::new();
        while !messages.contains("warning: ") {
            assert!(stderr.read_line(&mut messages).unwrap() > 0, "{messages}");
        }
        std::thread::sleep(Duration::from_millis(200));
        signal(&child, name);
        stderr.read_to_string(&mut messages).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{name}: {messages}");
        assert!(
            output.stdout.is_empty() && messages.contains("interrupted"),
            "{name}: {messages}"
        );
        assert_eq!(room.names(), before, "{name}");
        assert_eq!(fs::read_to_string(&path).ok().as_deref(), old);
    }
}

/// A scene of glass in which the bounces of the right tile take hours, and nothing is on the left.
const GLASS: &str = "size 16 8\ncamera 0 0 6 0 0 0 0 1 0 45\npoint 3 4 5 1 1 1\nmaxdepth 60\n\
                     specular .9 .9 .9\ntransmission .9 .9 .9\n";

fn glass() -> String {
    let mut text = GLASS.to_owned();
    for k in 0..50 {
        let [x, y, z] = [k % 5, k / 5 % 5 - 2, k / 25].map(|c| f64::from(c) * 0.9);
        text += &format!("sphere {} {y} {z} .5\n", x + 1.0);
    }
    text
}

#[test]
fn a_stop_is_seen_at_once_and_finished_tiles_are_kept() {
    let room = TestFolder::new();
    room.write("glass.test", &glass());
    let options = "--tile 8 --threads 1 --min-weight 1e-30";
    let stop = |line: &str, wait: u64| {
        let mut child = room
            .command(line)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(wait));
        let start = Instant::now();
        signal(&child, "TERM");
        let mut messages = String::new();
        let stderr = child.stderr.as_mut().unwrap();
        stderr.read_to_string(&mut messages).unwrap();
        assert_eq!(
            child.wait().unwrap().code(),
            Some(143),
            "{line}: {messages}"
        );
        // Seconds are left for a machine under load: without a stop, it would be hours.
        assert!(start.elapsed() < Duration::from_secs(10), "{line}");
        messages
    };
    for more in [
        "",
        "--spp 4 --aa adaptive",
        "--spp 4096 --aperture .1 --focus 5 --aa adaptive",
        "--integrator ao --spp 65536 --max-depth 0 --size 512x256",
    ] {
        stop(&format!("render glass.test -o g.png {options} {more}"), 700);
        assert_eq!(room.names(), ["glass.test"], "{more}");
    }
    // The finished tile is kept, and the other one is not.
    let command = format!("render glass.test -o g.png {options} --checkpoint g.tiles");
    let messages = stop(&command, 1500);
    assert!(
        messages.contains("finished tiles are kept in g.tiles"),
        "{messages}"
    );
    assert_eq!(room.names(), ["g.tiles", "glass.test"]);
    let messages = stop(&command, 1500);
    assert!(
        messages.contains("resuming from g.tiles, 50.0 % done"),
        "{messages}"
    );
}

#[test]
fn a_second_signal_ends_the_process_at_once() {
    let room = TestFolder::new();
    room.write("glass.test", &glass());
    // The bounces of one pixel: the scalar engine stops after a tile.
    let line = "render glass.test -o g.png --engine scalar --threads 1 --min-weight 1e-30";
    let mut child = room
        .command(line)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(700));
    signal(&child, "INT");
    std::thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none());
    signal(&child, "TERM");
    let start = Instant::now();
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert!(start.elapsed() < Duration::from_secs(5));
}
