//! Closed pipes and signals.

use super::{SCENE, TestFolder, ran};
use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::time::Duration;

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
        let mut said = String::new();
        while !said.contains("warning: ") {
            assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
        }
        std::thread::sleep(Duration::from_millis(200));
        signal(&child, name);
        stderr.read_to_string(&mut said).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{name}: {said}");
        assert!(
            output.stdout.is_empty() && said.contains("interrupted"),
            "{name}: {said}"
        );
        assert_eq!(room.names(), before, "{name}");
        assert_eq!(fs::read_to_string(&path).ok().as_deref(), old);
    }
}
