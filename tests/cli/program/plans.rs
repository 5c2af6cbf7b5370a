//! Hostile plans and tiles, and names that appear in scripts.

use super::{Ran, TestFolder, ran};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

/// A folder with a plan of two shards for `m.png`, both rendered.
fn rendered(room: &TestFolder) -> Value {
    room.ok("plan a.test --shards 2 -o m.png --plan p.json");
    for shard in 0..2 {
        room.ok(&format!("render --plan p.json --shard {shard}"));
    }
    serde_json::from_slice(&fs::read(room.path().join("p.json")).unwrap()).unwrap()
}

/// The plan with one value replaced.
fn forged(room: &TestFolder, plan: &Value, pointer: &str, value: Value) {
    let mut plan = plan.clone();
    *plan.pointer_mut(pointer).unwrap() = value;
    room.write("p.json", &plan.to_string());
}

/// The header of a tile file, and the start of its records.
fn beginning(file: &[u8]) -> (Value, usize) {
    let length = u32::from_le_bytes(file[8..12].try_into().unwrap()) as usize;
    let text = serde_json::from_slice(&file[16..16 + length]).unwrap();
    (text, 16 + length)
}

/// A tile file with this beginning and a valid checksum.
fn tile_file(text: &str, records: &[u8]) -> Vec<u8> {
    let mut file = b"PHXTILES".to_vec();
    file.extend((text.len() as u32).to_le_bytes());
    file.extend(crc32fast::hash(text.as_bytes()).to_le_bytes());
    file.extend(text.as_bytes());
    file.extend(records);
    file
}

#[test]
fn numbers_that_no_plan_has_are_refused_by_name_whatever_the_tiles_say() {
    let room = TestFolder::new();
    let plan = rendered(&room);
    let tiles = fs::read(room.path().join("p.shard-0.tiles")).unwrap();
    let (head, records) = beginning(&tiles);
    let (most, far) = (u32::MAX, u32::MAX - 5);
    let sides = "pixels.size is 40x0: expected sides of 1 to 65536 pixels";
    for (name, value) in [
        ("pixels.region", json!([far, far, 400, 300])),
        ("pixels.region", json!([0, 0, most, most])),
        ("pixels.region", json!([most, 0, most, 1])),
        ("pixels.region", json!([0, 0, 0, 0])),
        ("pixels.size", json!([most, 24])),
        (sides, json!([40, 0])),
        ("shards", json!(most)),
        ("tile", json!(1)),
        ("encoding.bits", json!(7)),
        ("encoding.exposure", json!(1e38)),
    ] {
        let field = name.split(' ').next().unwrap().replace('.', "/");
        let prefix = if field.contains('/') { "/spec/" } else { "/" };
        forged(&room, &plan, &format!("{prefix}{field}"), value.clone());
        // Tiles that claim the same.
        if field.starts_with("pixels") {
            let mut head = head.clone();
            *head["picture"].pointer_mut(&format!("/{field}")).unwrap() = value;
            let tiles = tile_file(&head.to_string(), &tiles[records..]);
            fs::write(room.path().join("p.shard-0.tiles"), tiles).unwrap();
        }
        for command in [
            "merge p.json",
            "render --plan p.json --shard 0",
            "submit slurm p.json --dry-run",
        ] {
            room.refused(command, 1, &[name, ": expected "]);
        }
    }
    forged(&room, &plan, "/spec/pixels/aov", json!(["nothing"]));
    room.refused("merge p.json", 1, &["`nothing`: expected ", " line "]);
}

#[test]
fn a_large_picture_that_is_claimed_takes_no_memory() {
    let room = TestFolder::new();
    room.ok("plan a.test --shards 400 -o m.png --plan p.json --size 65536x65536");
    for shard in 0..400 {
        let tiles = room.path().join(format!("p.shard-{shard:03}.tiles"));
        let plan = fs::read(room.path().join("p.json")).unwrap();
        let plan: Value = serde_json::from_slice(&plan).unwrap();
        let head = json!({"layout_version": 5, "picture": {"stamp": plan["stamp"], "pixels": plan["spec"]["pixels"]}});
        fs::write(tiles, tile_file(&head.to_string(), &[])).unwrap();
    }
    let ran = room.run_in_400_mb("merge p.json");
    assert_eq!(ran.code, Some(6), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("400 of 400 shards are missing"),
        "{}",
        ran.stderr
    );
}

#[test]
fn a_merge_writes_into_the_plans_folder_unless_it_is_told_otherwise() {
    let room = TestFolder::new();
    fs::create_dir_all(room.path().join("job/in")).unwrap();
    fs::create_dir(room.path().join("else")).unwrap();
    room.ok("plan a.test --shards 1 -o job/m.png --plan job/p.json");
    room.ok("render --plan job/p.json --shard 0");
    let text = fs::read(room.path().join("job/p.json")).unwrap();
    let plan: Value = serde_json::from_slice(&text).unwrap();
    assert_eq!(plan["output"], "m.png");
    // From any working folder.
    room.ok("merge job/p.json");
    let full = fs::read(room.path().join("job/m.png")).unwrap();
    std::os::unix::fs::symlink("../else", room.path().join("job/link")).unwrap();
    std::os::unix::fs::symlink("../else/y.png", room.path().join("job/y.png")).unwrap();
    let elsewhere = room.path().join("else/x.png");
    for output in [
        elsewhere.to_str().unwrap(),
        "../else/x.png",
        "../x.png",
        "in/../../else/x.png",
        "link/x.png",
        "y.png",
        "/x.png",
        "/nowhere/x.png",
    ] {
        let mut forged = plan.clone();
        forged["output"] = json!(output);
        room.write("job/p.json", &forged.to_string());
        let before = files(room.path());
        for command in ["merge job/p.json", "submit slurm job/p.json --dry-run"] {
            room.refused(command, 2, &["outside the plan's folder", "-o"]);
        }
        assert_eq!(files(room.path()), before, "{output}");
        // An explicit destination is used, and shards are rendered whatever the picture's name.
        room.ok("render --plan job/p.json --shard 0");
        room.ok("merge job/p.json -o else/told.png");
        assert!(fs::read(room.path().join("else/told.png")).unwrap() == full);
        fs::remove_file(room.path().join("else/told.png")).unwrap();
    }
}

/// Names of all files beneath a folder, sorted.
fn files(folder: &Path) -> Vec<String> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        all.push(entry.path().display().to_string());
        if entry.file_type().unwrap().is_dir() {
            all.extend(files(&entry.path()));
        }
    }
    all.sort();
    all
}

#[test]
fn a_plan_whose_picture_lies_elsewhere_says_so_at_once() {
    let room = TestFolder::new();
    for folder in ["job", "pictures"] {
        fs::create_dir(room.path().join(folder)).unwrap();
    }
    let line = "plan a.test --shards 1 -o pictures/m.png --plan job/p.json";
    let ran = room.run(line);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(
        ran.stderr
            .contains("note: pictures/m.png lies outside the plan's folder"),
        "{}",
        ran.stderr
    );
    assert!(
        ran.stdout
            .contains("phalanx merge job/p.json -o pictures/m.png"),
        "{}",
        ran.stdout
    );
    room.ok("render --plan job/p.json --shard 0");
    room.refused(
        "merge job/p.json",
        2,
        &["pictures/m.png lies outside", "-o"],
    );
    room.refused("submit slurm job/p.json --dry-run", 2, &["-o"]);
    room.ok("merge job/p.json -o pictures/m.png");
    room.ok("render a.test -o whole.png");
    let read = |name: &str| fs::read(room.path().join(name)).unwrap();
    assert!(read("pictures/m.png") == read("whole.png"));
    let names = room.names();
    let report = room.ok("submit slurm job/p.json -o pictures/it's.png --dry-run");
    assert_eq!(room.names(), names, "nothing is written");
    room.carry_out(&report);
    let script = fs::read_to_string(room.path().join("job/p.merge.sh")).unwrap();
    assert!(script.contains(r"/pictures/it'\''s.png'"), "{script}");
}

#[test]
fn links_beside_a_plan_lead_nowhere_else() {
    let room = TestFolder::new();
    let in_room = |name: &str| room.path().join(name);
    fs::create_dir(in_room("job")).unwrap();
    fs::create_dir(in_room("else")).unwrap();
    let frames = "--frames 0..1 --turntable 2";
    for (name, more) in [
        ("p", ""),
        ("f", frames),
        ("t", &format!("{frames} --shard-by tile")),
    ] {
        room.ok(&format!(
            "plan a.test --shards 2 --size 16x12 -o job/{name}.png --plan job/{name}.json {more}"
        ));
    }
    room.write("else/theirs", "theirs");
    for (command, link) in [
        ("render --plan job/p.json --shard 0", "p.shard-0.tiles"),
        ("merge job/p.json", "p.shard-1.tiles"),
        ("render --plan job/f.json --shard 0", "f.shard-0.frames"),
        (
            "render --plan job/f.json --shard 0",
            "f.shard-0.frame-0000.tiles",
        ),
        ("merge job/f.json", "f.shard-0.frames"),
        (
            "render --plan job/t.json --shard 0",
            "t.shard-0.frame-0001.tiles",
        ),
        ("merge job/t.json", "t.shard-1.frame-0001.tiles"),
        ("submit slurm job/p.json --dry-run", "p.shards.sh"),
        ("submit slurm job/p.json", "p.merge.sh"),
        ("submit slurm job/p.json", "p.shard-1.log"),
        ("submit slurm job/p.json", "p.merge.log"),
    ] {
        for target in ["../else/theirs", "../else/made"] {
            let path = in_room("job").join(link);
            let _ = fs::remove_file(&path);
            std::os::unix::fs::symlink(target, &path).unwrap();
            let ran = room.run(command);
            assert_eq!(ran.code, Some(1), "{command}: {}", ran.stderr);
            let part = format!("{link} lies outside the plan's folder");
            assert!(ran.stderr.contains(&part), "{command}: {}", ran.stderr);
            fs::remove_file(path).unwrap();
            assert_eq!(
                fs::read(in_room("else/theirs")).unwrap(),
                b"theirs",
                "{command}"
            );
            assert!(!in_room("else/made").exists(), "{command}");
        }
    }
    // Within the folder they may lead anywhere except to an input.
    room.write("job/kept", "");
    std::os::unix::fs::symlink("kept", in_room("job/p.shard-0.tiles")).unwrap();
    room.ok("render --plan job/p.json --shard 0");
    assert!(fs::metadata(in_room("job/kept")).unwrap().len() > 0);
    std::os::unix::fs::symlink("p.json", in_room("job/p.merge.sh")).unwrap();
    room.refused("submit slurm job/p.json", 2, &["would overwrite the plan"]);
    assert!(!in_room("job/p.shards.sh").exists());
}

#[test]
fn files_of_other_layouts_are_refused_by_version() {
    let room = TestFolder::new();
    let plan = rendered(&room);
    // As written by earlier versions.
    let old = json!({
        "schema_version": 1, "scene": "a.test", "arguments": ["plan"], "output": "/m.png", "shards": 1, "tile": 8,
        "developing": {"exposure": 0.0, "srgb": false, "round": false, "bits": 8},
        "picture": {"version": "0.1.0", "scene": "0", "width": 4, "height": 3, "region": [0, 0, 4, 3], "layers": [], "settings": "Settings { width: 0 }"},
    });
    room.write("old.json", &old.to_string());
    let parts = [
        "old.json: made by another version of phalanx",
        "version 1, this program reads version 5",
    ];
    room.refused("merge old.json", 1, &parts);
    let tiles = fs::read(room.path().join("p.shard-0.tiles")).unwrap();
    let (_, records) = beginning(&tiles);
    for (name, head) in [
        ("1", old["picture"].to_string()),
        ("2", json!({"layout_version": 2, "picture": 7}).to_string()),
        ("3", json!({"layout_version": 3, "picture": 7}).to_string()),
        ("4", json!({"layout_version": 4, "picture": 7}).to_string()),
        ("6", json!({"layout_version": 6, "colours": 7}).to_string()),
    ] {
        let old = tile_file(&head, &tiles[records..]);
        for file in ["c.tiles", "p.shard-0.tiles"] {
            fs::write(room.path().join(file), &old).unwrap();
        }
        let version = format!("version {name}, this program reads version 5");
        room.refused(
            "render a.test -o a.png --checkpoint c.tiles",
            2,
            &["c.tiles: made by another version", &version],
        );
        room.refused("render --plan p.json --shard 0", 2, &[&version]);
        room.refused("merge p.json", 2, &[&version]);
        assert_eq!(fs::read(room.path().join("c.tiles")).unwrap(), old);
    }
    assert_eq!(plan["spec"]["pixels"]["spp"], 1);
}

#[test]
fn a_pipe_in_the_place_of_tiles_is_no_file_to_wait_for() {
    let room = TestFolder::new();
    rendered(&room);
    fs::remove_file(room.path().join("p.shard-1.tiles")).unwrap();
    let made = Command::new("mkfifo")
        .arg(room.path().join("p.shard-1.tiles"))
        .status();
    assert!(made.unwrap().success());
    room.refused(
        "merge p.json",
        1,
        &["p.shard-1.tiles", "is no regular file"],
    );
    room.refused("render --plan p.json --shard 1", 1, &["is no regular file"]);
    room.refused(
        "render a.test -o a.png --checkpoint p.shard-1.tiles",
        1,
        &["in a regular file only"],
    );
    let made = Command::new("mkfifo")
        .arg(room.path().join("b.test"))
        .status();
    assert!(made.unwrap().success());
    room.refused(
        "plan b.test --shards 1 -o a.png --plan q.json",
        2,
        &["b.test is not a regular file"],
    );
}

fn run(room: &TestFolder, arguments: &[&str]) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    ran(command.current_dir(room.path()).args(arguments))
}

#[test]
fn names_with_control_characters_stand_in_no_script() {
    let room = TestFolder::new();
    room.ok("plan a.test --shards 2 -o m.png --plan good.json");
    let text = fs::read_to_string(room.path().join("good.json")).unwrap();
    for bad in [
        "x\ntouch here #",
        "x\rtouch here #",
        "a\u{1b}[2J",
        "\n",
        "tab\t",
        "\u{85}",
    ] {
        let name = format!("{bad}.json");
        // Refused both when the plan is created and after renaming it.
        let made = run(
            &room,
            &[
                "plan", "a.test", "--shards", "2", "-o", "m.png", "--plan", &name,
            ],
        );
        assert_eq!(made.code, Some(2), "{bad:?}: {}", made.stderr);
        assert!(
            made.stderr.contains("control characters"),
            "{}",
            made.stderr
        );
        room.write(&name, &text);
        let before = room.names();
        let submitted = run(&room, &["submit", "slurm", &name, "--dry-run"]);
        assert_eq!(submitted.code, Some(2), "{bad:?}: {}", submitted.stderr);
        assert!(
            submitted.stderr.contains("control characters"),
            "{}",
            submitted.stderr
        );
        assert_eq!(room.names(), before, "{bad:?}");
        fs::remove_file(room.path().join(&name)).unwrap();
        // Nor in the user's own additions.
        let picture = format!("{bad}.png");
        for more in [&["-o", &picture][..], &["--time", bad], &["--", bad]] {
            let arguments = [&["submit", "slurm", "good.json", "--dry-run"], more].concat();
            assert_eq!(run(&room, &arguments).code, Some(2), "{more:?}");
        }
        assert_eq!(room.names(), ["good.json"]);
    }
    // A folder's name appears in the script, too.
    let folder = room.path().join("f\ntouch here #");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("p.json"), &text).unwrap();
    let mut inside = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    let inside = inside
        .current_dir(&folder)
        .args(["submit", "slurm", "p.json"]);
    assert_eq!(ran(inside).code, Some(2));
}

#[cfg(unix)]
#[test]
fn an_array_that_slurm_refuses_is_told_of_its_limit() {
    use std::os::unix::fs::PermissionsExt;
    let room = TestFolder::new();
    room.ok("plan a.test --shards 4 -o m.png --plan p.json");
    let submit = |reason: &str| {
        room.write(
            "sbatch",
            &format!("#!/bin/sh\necho 'sbatch: error: {reason}' >&2\nexit 1\n"),
        );
        let executable = fs::Permissions::from_mode(0o755);
        fs::set_permissions(room.path().join("sbatch"), executable).unwrap();
        let mut command = room.command("submit slurm p.json");
        let done = ran(command.env("PATH", room.path()));
        assert_eq!(done.code, Some(1), "{}", done.stderr);
        assert!(done.stderr.contains(reason), "{}", done.stderr);
        done.stderr.contains("MaxArraySize") && done.stderr.contains("fewer shards")
    };
    assert!(submit(
        "Batch job submission failed: Invalid job array specification"
    ));
    assert!(!submit(
        "Batch job submission failed: Invalid partition name specified"
    ));
}

#[test]
fn other_names_are_words_of_the_scripts_whatever_is_in_them() {
    let room = TestFolder::new();
    let odd = "it's \"$(touch here)\" `touch here`; touch here & #SBATCH --x %a \\ *? ä";
    let name = format!("{odd}.json");
    let picture = format!("{odd}.png");
    let planned = run(
        &room,
        &[
            "plan", "a.test", "--shards", "2", "-o", &picture, "--plan", &name,
        ],
    );
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    let submitted = run(&room, &["submit", "slurm", &name, "--dry-run"]);
    assert_eq!(submitted.code, Some(0), "{}", submitted.stderr);
    room.carry_out(&submitted.stdout);
    let script = |script: &str, index: &str| {
        let path = room.path().join(format!("{odd}.{script}.sh"));
        let mut shell = Command::new("bash");
        let shell = shell.arg(path).current_dir(room.path());
        let done = ran(shell
            .env("SLURM_ARRAY_TASK_ID", index)
            .env("SLURM_CPUS_ON_NODE", "1"));
        assert_eq!(done.code, Some(0), "{}", done.stderr);
    };
    script("shards", "0");
    script("shards", "1");
    script("merge", "");
    assert!(!room.names().iter().any(|name| name == "here"));
    room.ok("render a.test -o whole.png");
    let read = |name: &str| fs::read(room.path().join(name)).unwrap();
    assert!(read(&picture) == read("whole.png"));
    // The line that would submit it: a percent sign in the name has no meaning for Slurm.
    assert!(
        submitted.stdout.contains("--x %%a "),
        "{}",
        submitted.stdout
    );
    assert!(
        submitted.stdout.contains(".shard-%a.log"),
        "{}",
        submitted.stdout
    );
    let line = format!(
        "sbatch() {{ printf '%s\\n' \"$@\"; }}\n{}",
        submitted.stdout
    );
    let words = ran(Command::new("bash").args(["-c", &line]));
    assert!(
        words
            .stdout
            .lines()
            .any(|word| word == format!("--job-name=phalanx-{odd}")),
        "{}",
        words.stdout
    );
}
