//! Caches that are truncated while in use.
#![cfg(target_os = "linux")]

use super::TestFolder;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::ExitStatusExt;
use std::process::Stdio;
use std::time::Duration;

#[test]
fn a_cache_that_is_shortened_under_a_render_ends_it_with_a_message() {
    let room = TestFolder::new();
    room.ok("build standard:balls -o whole.phx");
    let picture = "-o a.png --size 4000x3000 --spp 64 --threads 2";
    let line = format!("render b.phx {picture} --progress json");
    let again = || std::fs::copy(room.path().join("whole.phx"), room.path().join("b.phx"));
    // After the first line of its progress all of it has been checked, and every part of it is
    // wanted again.
    again().unwrap();
    let mut child = room
        .command(&line)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut first = String::new();
    while !first.contains("progress") {
        assert_ne!(stderr.read_line(&mut first).unwrap(), 0, "{first}");
    }
    let cut = |length| {
        let file = File::options().write(true).open(room.path().join("b.phx"));
        file.unwrap().set_len(length).unwrap();
    };
    cut(0);
    let mut rest = String::new();
    stderr.read_to_string(&mut rest).unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(1), "{status:?}: {rest}");
    assert!(
        rest.contains("error: cannot read b.phx any more: it was truncated"),
        "{rest}"
    );
    assert_eq!(rest.matches("error: ").count(), 1, "{rest}");
    // While it is opened, too: either it is too short, or it became so.
    for delay in (0..40).map(|k| Duration::from_micros(500 * k)) {
        again().unwrap();
        let mut child = room
            .command("info b.phx")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(delay);
        cut(4096);
        let status = child.wait().unwrap();
        assert_eq!(status.signal(), None, "{delay:?}");
        assert!(matches!(status.code(), Some(0 | 1 | 3)), "{status:?}");
    }
}
