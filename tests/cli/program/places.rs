//! Destinations of results: files are replaced; anything else is written to and keeps its kind.

use super::signals::signal;
use super::{Ran, TestFolder, ran};
use std::fs::{self, File, Permissions};
use std::io::Read;
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::os::unix::net::UnixListener;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const BENCH: &str = "bench a.test --rays primary --threads 1 --size 16x16 --repeat 1 --min-time 0";

/// Every writer, with `@` for its file's name, and the extension that it needs.
fn writers() -> Vec<(String, &'static str)> {
    let mut all = vec![
        ("render a.test -o @".to_owned(), "png"),
        ("render a.test -o @".to_owned(), "jpg"),
        ("render a.test -o @".to_owned(), "exr"),
        ("render a.test -o @".to_owned(), "hdr"),
        ("render a.test -o @".to_owned(), "pfm"),
        ("render a.test -o x.png --heat prims @".to_owned(), "png"),
        ("render a.test -o x.png --snapshot @".to_owned(), "png"),
        ("generate balls --size 1 -o @".to_owned(), "nff"),
        ("generate tetra --size 1 -o @".to_owned(), "ply"),
        ("build a.test -o @".to_owned(), "phx"),
        (
            "plan a.test --shards 2 -o x.png --plan @".to_owned(),
            "json",
        ),
        ("merge plan.json -o @".to_owned(), "png"),
        ("verify a.test --threads 1 --record @".to_owned(), "json"),
        ("compare one.png other.png --heat @".to_owned(), "png"),
        (
            "compare one.png other.png --side-by-side @".to_owned(),
            "png",
        ),
    ];
    for option in ["json", "csv", "html", "dump-rays"] {
        all.push((format!("{BENCH} --{option} @"), "out"));
    }
    all
}

/// A folder with the files that those commands read.
pub fn furnished() -> TestFolder {
    let room = TestFolder::new();
    room.ok("render a.test -o one.png");
    room.ok("render a.test -o other.png --exposure 1");
    room.ok("plan a.test --shards 1 -o whole.png --plan plan.json");
    room.ok("render --plan plan.json --shard 0");
    room
}

pub fn path_in(room: &TestFolder, name: &str) -> PathBuf {
    room.path().join(name)
}

fn make_fifo(room: &TestFolder, name: &str) {
    let made = Command::new("mkfifo").arg(path_in(room, name)).status();
    assert!(made.unwrap().success());
}

/// A device node, if this user may create one.
fn make_device(room: &TestFolder, name: &str) -> bool {
    let null = ["c", "1", "3"];
    let mut command = Command::new("mknod");
    let made = command.arg(path_in(room, name)).args(null).output();
    let made = cfg!(target_os = "linux") && made.is_ok_and(|output| output.status.success());
    // A folder may be of a file system without devices.
    let made = made
        && File::options()
            .write(true)
            .open(path_in(room, name))
            .is_ok();
    if !made {
        println!("skipped: this user cannot make a device node");
    }
    made
}

/// The result of a run with a reader on its pipe, and the bytes from the pipe.
fn read_by_cat(room: &TestFolder, line: &str, fifo: &str) -> (Ran, Vec<u8>) {
    let mut cat = Command::new("cat");
    let mut cat = cat
        .arg(path_in(room, fifo))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = cat.stdout.take().unwrap();
    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        out.read_to_end(&mut bytes).unwrap();
        bytes
    });
    let ran = room.run(line);
    let still = fs::symlink_metadata(path_in(room, fifo))
        .unwrap()
        .file_type();
    if !matches!(ran.code, Some(0 | 4)) || !still.is_fifo() {
        // Its writer has not opened it, and will not.
        cat.kill().unwrap();
    }
    cat.wait().unwrap();
    (ran, reader.join().unwrap())
}

#[test]
fn every_writer_writes_into_a_pipe() {
    let room = furnished();
    for (number, (line, ending)) in writers().iter().enumerate() {
        let fifo = format!("{number}.pipe.{ending}");
        make_fifo(&room, &fifo);
        let (ran, bytes) = read_by_cat(&room, &line.replace('@', &fifo), &fifo);
        let still = fs::symlink_metadata(path_in(&room, &fifo))
            .unwrap()
            .file_type();
        assert!(still.is_fifo(), "{line}: replaced");
        assert!(matches!(ran.code, Some(0 | 4)), "{line}: {}", ran.stderr);
        let file = format!("{number}.file.{ending}");
        room.run(&line.replace('@', &file));
        let wanted = fs::read(path_in(&room, &file)).unwrap();
        assert!(!bytes.is_empty(), "{line}: nothing came");
        // A record contains its time, a plan its arguments.
        if ending != &"json" && !line.starts_with("bench") {
            assert!(bytes == wanted, "{line}: other bytes than the file's");
        }
    }
}

#[test]
fn every_writer_writes_into_a_device() {
    let room = furnished();
    if !make_device(&room, "null") {
        return;
    }
    for (number, (line, ending)) in writers().iter().enumerate() {
        let link = format!("{number}.{ending}");
        symlink("null", path_in(&room, &link)).unwrap();
        let ran = room.run(&line.replace('@', &link));
        assert!(matches!(ran.code, Some(0 | 4)), "{line}: {}", ran.stderr);
        let node = fs::symlink_metadata(path_in(&room, "null")).unwrap();
        assert!(node.file_type().is_char_device(), "{line}: replaced");
        assert!(
            path_in(&room, &link).is_symlink(),
            "{line}: the link is gone"
        );
    }
    // A name without an ending gets a PNG.
    room.ok("render a.test -o null");
    room.ok("render a.test -o x.png --heat time null --snapshot null");
}

#[test]
fn every_writer_keeps_links_and_permissions() {
    let room = furnished();
    for (number, (line, ending)) in writers().iter().enumerate() {
        let [old, link, loose] = ["old", "link", "loose"].map(|n| format!("{number}.{n}.{ending}"));
        fs::write(path_in(&room, &old), "old").unwrap();
        fs::set_permissions(path_in(&room, &old), Permissions::from_mode(0o604)).unwrap();
        symlink(&old, path_in(&room, &link)).unwrap();
        let made = format!("{number}.made.{ending}");
        symlink(&made, path_in(&room, &loose)).unwrap();
        for (link, target) in [(&link, &old), (&loose, &made)] {
            let ran = room.run(&line.replace('@', link));
            assert!(matches!(ran.code, Some(0 | 4)), "{line}: {}", ran.stderr);
            assert!(
                path_in(&room, link).is_symlink(),
                "{line}: the link is gone"
            );
            assert_ne!(fs::read(path_in(&room, target)).unwrap(), b"old", "{line}");
        }
        let mode = |name: &str| {
            fs::metadata(path_in(&room, name))
                .unwrap()
                .permissions()
                .mode()
        };
        assert_eq!(mode(&old) & 0o7777, 0o604, "{line}");
        assert_eq!(mode(&made), mode("a.test"), "{line}");
    }
    let parts = room.names();
    assert!(parts.iter().all(|n| !n.ends_with(".part")), "{parts:?}");
}

/// The scene is missing, but the destination is checked first.
#[test]
fn folders_sockets_and_circles_are_refused_before_any_work() {
    let room = furnished();
    fs::remove_file(path_in(&room, "a.test")).unwrap();
    fs::remove_file(path_in(&room, "one.png")).unwrap();
    for ending in [
        "png", "jpg", "exr", "hdr", "pfm", "nff", "ply", "phx", "json", "out",
    ] {
        fs::create_dir(path_in(&room, &format!("folder.{ending}"))).unwrap();
        symlink(
            format!("circle.{ending}"),
            path_in(&room, &format!("circle.{ending}")),
        )
        .unwrap();
        symlink("no/where", path_in(&room, &format!("lost.{ending}"))).unwrap();
        UnixListener::bind(path_in(&room, &format!("socket.{ending}"))).unwrap();
    }
    for (line, ending) in writers() {
        for (name, part) in [
            ("folder", "there is a folder of that name"),
            ("circle", "circle"),
            ("lost", "there is no folder"),
            ("socket", "it is a socket"),
        ] {
            let line = line.replace('@', &format!("{name}.{ending}"));
            room.refused(&line, 1, &["error: cannot write ", part]);
        }
    }
}

#[test]
fn no_frame_is_rendered_where_a_later_one_cannot_be_written() {
    let room = TestFolder::new();
    fs::create_dir(path_in(&room, "f.0002.png")).unwrap();
    make_fifo(&room, "c.0001.ckpt");
    let line = "render a.test --frames 0..2 --turntable 3 -o";
    room.refused(
        &format!("{line} f.png"),
        1,
        &["cannot write f.0002.png: there is a folder"],
    );
    room.refused(
        &format!("{line} g.png --checkpoint c.ckpt"),
        1,
        &["cannot use c.0001.ckpt", "in a regular file only"],
    );
}

/// Runs `sh` with `$PHALANX`.
fn shell(room: &TestFolder, script: &str) -> Ran {
    let mut command = Command::new("sh");
    command.env("PHALANX", env!("CARGO_BIN_EXE_phalanx"));
    ran(command.current_dir(room.path()).args(["-c", script]))
}

/// Output of a script before and after the picture stays there.
#[test]
fn open_files_are_written_where_they_stand() {
    let room = TestFolder::new();
    room.ok("render a.test -o a.png");
    let picture = fs::read(path_in(&room, "a.png")).unwrap();
    let wanted = [b"before\n", &picture[..], b"after\n"].concat();
    symlink("/dev/stdout", path_in(&room, "link")).unwrap();
    for name in ["-", "/dev/stdout", "/dev/fd/1", "link", "/dev/fd/3"] {
        let third = name == "/dev/fd/3";
        let to = if third { ">&3" } else { "" };
        let script = format!(
            "echo before {to}; \"$PHALANX\" render a.test -o {name} 2> told; echo after {to}"
        );
        let redirected = if third {
            format!("exec 3> out; {script}")
        } else {
            format!("{{ {script}; }} > out")
        };
        fs::remove_file(path_in(&room, "out")).ok();
        let ran = shell(&room, &redirected);
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.stderr);
        let out = fs::read(path_in(&room, "out")).unwrap();
        assert!(out == wanted, "{name}: {}", String::from_utf8_lossy(&out));
        let messages = fs::read_to_string(path_in(&room, "told")).unwrap();
        // Otherwise the table would be among the picture's bytes.
        let table = if third { &ran.stdout } else { &messages };
        assert!(table.contains("Mrays/s"), "{name}: {table}");
        if !third {
            shell(&room, &format!("{{ {script}; }} | cat > out"));
            assert!(
                fs::read(path_in(&room, "out")).unwrap() == wanted,
                "{name}, piped"
            );
        }
    }
    assert!(path_in(&room, "link").is_symlink());
    let json = shell(
        &room,
        &format!("\"$PHALANX\" {BENCH} --json /dev/stdout 2> told"),
    );
    assert!(serde_json::from_str::<serde_json::Value>(&json.stdout).is_ok());
    let messages = fs::read_to_string(path_in(&room, "told")).unwrap();
    assert!(messages.contains("a.test: "), "{messages}");
}

#[test]
fn open_files_that_cannot_be_written_are_refused_before_any_work() {
    let room = TestFolder::new();
    for (name, script) in [
        ("/dev/fd/0", "< /dev/null"),
        ("/dev/fd/7", "7< a.test"),
        ("/dev/fd/77", ""),
    ] {
        let script = format!("\"$PHALANX\" render none.test -o {name} --format png {script}");
        let ran = shell(&room, &script);
        assert_eq!(ran.code, Some(1), "{name}: {}", ran.stderr);
        let part = format!("error: cannot write {name}: ");
        assert!(ran.stderr.contains(&part), "{}", ran.stderr);
    }
}

#[test]
fn a_pipe_whose_reader_goes_away_is_an_error() {
    let room = TestFolder::new();
    for ending in ["png", "pfm"] {
        let fifo = format!("f.{ending}");
        make_fifo(&room, &fifo);
        let line = format!("render a.test -o {fifo} --size 700x700");
        let script = format!("head -c 5 {fifo} > got & \"$PHALANX\" {line}");
        let ran = shell(&room, &script);
        assert_eq!(ran.code, Some(1), "{}", ran.stderr);
        let part = format!("error: cannot write {fifo}: Broken pipe");
        assert!(ran.stderr.contains(&part), "{}", ran.stderr);
        assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
    }
}

/// No reader on the pipe: opening it blocks, until a signal ends that.
#[test]
fn a_signal_ends_the_waiting_for_a_reader() {
    let room = TestFolder::new();
    let endings = ["png", "pfm", "nff", "json"];
    endings
        .iter()
        .for_each(|ending| make_fifo(&room, &format!("f.{ending}")));
    let before = room.names();
    for line in [
        "render a.test -o f.png",
        "render a.test -o f.pfm --size 200x200",
        "render a.test -o f.png --heat nodes f.png",
        "render a.test -o g.png --snapshot f.png",
        "generate balls -o f.nff",
        &format!("{BENCH} --json f.json"),
    ] {
        let mut command = room.command(line);
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        signal(&child, "TERM");
        let start = Instant::now();
        while child.try_wait().unwrap().is_none() {
            let waited = start.elapsed() > Duration::from_secs(20);
            if waited {
                child.kill().unwrap();
            }
            assert!(!waited, "{line}: it goes on waiting");
            std::thread::sleep(Duration::from_millis(20));
        }
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        let snapshot = line.contains("--snapshot");
        // There the picture is complete, only unread.
        let codes = if snapshot { vec![0, 143] } else { vec![143] };
        let code = output.status.code().unwrap_or(-1);
        assert!(codes.contains(&code), "{line}: {code}: {stderr}");
        fs::remove_file(path_in(&room, "g.png")).ok();
        assert_eq!(room.names(), before, "{line}");
    }
}

#[test]
fn finished_tiles_are_kept_in_regular_files_only() {
    let room = furnished();
    make_fifo(&room, "fifo");
    fs::create_dir(path_in(&room, "folder")).unwrap();
    for (name, part) in [
        ("fifo", "in a regular file only"),
        ("/dev/null", "in a regular file only"),
        ("/dev/stdout", "in a regular file only"),
        ("folder", "there is a folder of that name"),
    ] {
        let line = format!("render none.test -o x.png --checkpoint {name}");
        room.refused(&line, 1, &["error: cannot use ", part]);
    }
    fs::remove_file(path_in(&room, "plan.shard-0.tiles")).unwrap();
    make_fifo(&room, "plan.shard-0.tiles");
    for line in ["render --plan plan.json --shard 0", "merge plan.json"] {
        room.refused(line, 1, &["shard-0.tiles is no regular file"]);
    }
}

#[test]
fn two_results_do_not_go_to_one_file() {
    let room = TestFolder::new();
    symlink("x.png", path_in(&room, "y.png")).unwrap();
    for line in [
        "render none.test -o x.png --checkpoint x.png",
        "render none.test -o x.png --checkpoint ./y.png",
        "render none.test -o x.png --snapshot y.png",
        "render none.test -o x.png --heat nodes x.png",
        "bench none.test --json x.png --csv x.png",
        "plan none.test --shards 2 -o x.png --plan x.png",
        "render a.test --checkpoint a.png",
    ] {
        room.refused(line, 2, &["are the same file"]);
    }
}

/// The line matters only if a picture would be written by it.
#[test]
fn a_scene_does_not_choose_the_folder_of_its_picture() {
    for name in ["a/p.png", "../p.png", "/tmp/p.png", "C:p.png", ".."] {
        let room = TestFolder::new();
        let scene = "camera 0 0 4 0 0 0 0 1 0 40\nambient 1 1 1\nsphere 0 0 0 1\n";
        room.write("p.test", &format!("size 8 6\noutput {name}\n{scene}"));
        room.ok("info p.test");
        room.ok("render p.test -o x.png");
        let parts = ["is not a bare file name", "choose a file with -o"];
        room.refused("render p.test", 2, &parts);
    }
}
