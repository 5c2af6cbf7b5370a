//! Commands that are copied from pictures, pages and reports run as they are, whatever a stranger
//! named a file, and run nothing else.

use super::view::{ViewProcess, shot};
use super::{Ran, SCENE, TestFolder, ran};
use memchr::memmem;
use phalanx::image::{Picture, save_png};
use serde_json::json;
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

/// Names that are options, patterns, other programs, other scenes or more than one line.
const ODD: [&str; 7] = [
    "-x.test",
    "--output=y.test",
    "=ls.test",
    "a\u{3}\ntouch here #.test",
    "it's $(touch here) \\ä.test",
    "standard:tree.test",
    "-",
];

/// Runs a command in bash, which must succeed.
fn bash(room: &TestFolder, line: &str) {
    let line = line.replacen("phalanx", env!("CARGO_BIN_EXE_phalanx"), 1);
    let ran = ran(Command::new("bash")
        .current_dir(room.path())
        .args(["-c", &line]));
    assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
}

fn run(room: &TestFolder, words: &[&OsStr]) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    ran(command.current_dir(room.path()).args(words))
}

/// The text of a PNG's comment.
fn comment(png: &[u8]) -> Option<String> {
    let position = memmem::find(png, b"phalanx render ")?;
    let text = &png[position..];
    // Up to the checksum of its chunk.
    let length = memmem::find(text, b"--quantize floor")? + "--quantize floor".len();
    String::from_utf8(text[..length].to_vec()).ok()
}

#[test]
fn a_picture_of_a_scene_with_any_name_can_be_made_again() {
    let room = TestFolder::new();
    for name in ODD {
        room.write(&format!("./{name}"), SCENE);
        let path = format!("./{name}");
        let format = ["--format", "test"].map(OsStr::new);
        let words = ["render", &path, "-o", "one.png"].map(OsStr::new);
        let words = if name == "-" { [&words[..], &format].concat() } else { words.to_vec() };
        let rendered = run(&room, &words);
        assert_eq!(rendered.code, Some(0), "{name:?}: {}", rendered.stderr);
        let one = fs::read(room.path().join("one.png")).unwrap();
        let command = comment(&one).unwrap_or_else(|| panic!("{name:?}"));
        assert!(!command.contains(char::is_control), "{command:?}");
        bash(&room, &format!("{command} -o two.png"));
        assert!(
            fs::read(room.path().join("two.png")).unwrap() == one,
            "{command}"
        );
        assert!(!room.path().join("here").exists(), "{command}");
    }
    // A name that no text has gets no command, and ordinary ones no quotes.
    let name = OsStr::from_bytes(b"a\xff.test");
    fs::write(room.path().join(name), SCENE).unwrap();
    let words = ["render", "-o", "one.png"].map(OsStr::new);
    assert_eq!(run(&room, &[&words[..], &[name]].concat()).code, Some(0));
    assert_eq!(
        comment(&fs::read(room.path().join("one.png")).unwrap()),
        None
    );
    room.ok("render a.test -o one.png");
    let command = comment(&fs::read(room.path().join("one.png")).unwrap()).unwrap();
    assert!(command.starts_with("phalanx render a.test --"), "{command}");
}

#[test]
fn commands_of_a_page_are_safe_to_paste() {
    let room = TestFolder::new();
    for name in &ODD[..5] {
        room.write(name, SCENE);
        let mut command = room.command("view --allow-path . --allow-path ..");
        command.arg(format!("./{name}"));
        let served = ViewProcess::spawn(&mut command);
        let reply = served.post("command", shot("shaded", 1)).json();
        let command = reply["command"].as_str().unwrap();
        assert!(!command.contains(char::is_control), "{command:?}");
        bash(&room, command);
        assert!(!room.path().join("here").exists(), "{command}");
    }
    let name = OsStr::from_bytes(b"a\xff.test");
    fs::write(room.path().join(name), SCENE).unwrap();
    let served = ViewProcess::spawn(room.command("view").arg(name));
    let reply = served.post("command", shot("shaded", 1));
    assert!(reply.status == 400 && reply.json()["error"].as_str().unwrap().contains("UTF-8"));
    assert_eq!(served.post("save", shot("shaded", 1)).status, 200);
}

#[test]
fn the_command_of_a_page_writes_beside_the_textures_of_a_model() {
    let room = TestFolder::new();
    let red = Picture {
        width: 2,
        height: 2,
        rgb: [255, 0, 0].repeat(4),
    };
    for name in ["model.png", "model-nodes.png"] {
        save_png(&room.path().join(name), &red).unwrap();
    }
    let material = |name: &str| format!("newmtl {name}\nKd 1 1 1\nmap_Kd {name}.png\n");
    room.write("model.mtl", &(material("model") + &material("model-nodes")));
    room.write(
        "model.obj",
        "mtllib model.mtl\nusemtl model\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n\
         usemtl model-nodes\nf 3/3 2/2 1/1\n",
    );
    let before = fs::read(room.path().join("model.png")).unwrap();
    let served = ViewProcess::start(&room, "view model.obj");
    for (mode, names) in [
        ("shaded", &["-o model-render.png"][..]),
        (
            "cost",
            &["-o model-render.png", "--heat nodes model-render-nodes.png"],
        ),
    ] {
        let reply = served.post("command", shot(mode, 1)).json();
        let command = reply["command"].as_str().unwrap();
        for name in names {
            assert!(command.contains(name), "{command}");
        }
        bash(&room, command);
        let saved = served.post("save", shot(mode, 1));
        let name = saved
            .header("Content-Disposition")
            .split('"')
            .nth(1)
            .unwrap();
        assert!(names.iter().any(|word| word.ends_with(name)), "{name}");
        assert!(
            saved.body == fs::read(room.path().join(name)).unwrap(),
            "{command}"
        );
    }
    assert!(fs::read(room.path().join("model.png")).unwrap() == before);
}

#[test]
fn a_command_makes_the_picture_that_is_saved_or_is_refused_with_it() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view standard:balls:2 --quality best");
    let reply = served.post("command", shot("cost", 1)).json();
    let command = reply["command"].as_str().unwrap();
    assert!(command.contains("--quality best"), "{command}");
    bash(&room, command);
    let saved = served.post("save", shot("cost", 1)).body;
    assert!(saved == fs::read(room.path().join("balls-nodes.png")).unwrap());
    let reply = served.post("command", shot("shaded", 1)).json();
    assert!(!reply["command"].as_str().unwrap().contains("--quality"));
    // A lens needs perspective.
    let served = ViewProcess::start(&room, "view a.test --aperture .1 --focus 2");
    let mut parallel = shot("shaded", 1);
    parallel["view"]["ortho"] = json!(2);
    for name in ["command", "save"] {
        assert_eq!(served.post(name, parallel.clone()).status, 400, "{name}");
        assert_eq!(served.post(name, shot("shaded", 1)).status, 200, "{name}");
    }
}

#[test]
fn a_plan_prints_commands_that_run() {
    let room = TestFolder::new();
    for plan in ["my plan.json", "-p.json", "it's.json"] {
        let path = format!("./{plan}");
        let words = [
            "plan", "a.test", "--shards", "2", "-o", "p.png", "--plan", &path,
        ];
        let planned = run(&room, &words.map(OsStr::new));
        assert_eq!(planned.code, Some(0), "{}", planned.stderr);
        let rows = planned.stdout.lines();
        let commands = rows.filter_map(|row| Some(&row[row.find("phalanx ")?..]));
        let commands: Vec<&str> = commands.collect();
        let (render, _) = commands[0].split_once(" I, I from").unwrap();
        bash(&room, &format!("{render} 0"));
        let merge = ran(Command::new("bash").current_dir(room.path()).args([
            "-c",
            &commands[1].replacen("phalanx", env!("CARGO_BIN_EXE_phalanx"), 1),
        ]));
        assert_eq!(merge.code, Some(6), "{}", merge.stderr);
        let help = merge.stderr.split("phalanx render").nth(1).unwrap();
        let (render, _) = help.split_once(" I, or as").unwrap();
        bash(&room, &format!("phalanx render{render} 1"));
        bash(&room, commands[1]);
    }
    let planned = room.ok("plan a.test --shards 2 -o p.png --plan p.json");
    assert!(
        planned.contains("phalanx render --plan p.json --shard I"),
        "{planned}"
    );
}

#[test]
fn the_number_of_a_job_is_found_among_other_words_of_sbatch() {
    let room = TestFolder::new();
    room.ok("plan a.test --shards 2 -o p.png --plan p.json");
    let submit = |message: &str| {
        room.write(
            "sbatch",
            &format!("#!/bin/sh\necho \"$@\" >> calls\nprintf -- '{message}'\n"),
        );
        let path = room.path().join("sbatch");
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
        let path = format!("{}:/usr/bin:/bin", room.path().display());
        ran(room.command("submit slurm p.json --json").env("PATH", path))
    };
    for message in [
        "4711\\n",
        "4711;east\\n",
        "Project charge: 10 units\\n4711\\n",
        "4711;east\\nThank you, 3 jobs left\\n",
    ] {
        let submitted = submit(message);
        let report: serde_json::Value = serde_json::from_str(&submitted.stdout).unwrap();
        assert_eq!(report["array_job"], "4711", "{message}");
        let calls = fs::read_to_string(room.path().join("calls")).unwrap();
        let merge = calls.lines().last().unwrap();
        assert!(merge.starts_with("--dependency=afterany:4711 "), "{merge}");
    }
    for message in ["", "Welcome to \\033[2J job 12\\n", "-1\\n"] {
        let submitted = submit(message);
        assert_eq!(submitted.code, Some(1), "{message}");
        let words = submitted.stderr;
        assert!(
            words.contains("may have been submitted") && !words.contains('\u{1b}'),
            "{words}"
        );
        assert!(
            message.is_empty() || words.contains("Welcome") || words.contains("-1"),
            "{words}"
        );
    }
}
