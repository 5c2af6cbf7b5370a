//! Standard scenes on the command line.

use super::TestFolder;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;

#[test]
fn a_standard_scene_stands_where_a_file_may() {
    let room = TestFolder::new();
    let table = room.ok("render standard:balls:2 --size 40x40");
    assert!(table.contains("balls.png"), "{table}");
    assert_eq!(room.names(), ["balls.png"]);
    room.ok("render standard:menger:4k --size 40x40 -o m.png");
    let info = room.json("info standard:terrain:5k --json");
    assert_eq!(info["scene"], "standard:terrain:5k");
    let triangles = info["primitives"]["triangles"].as_u64().unwrap();
    assert!((4800..5200).contains(&triangles), "{triangles}");
    let verified = room.ok("verify standard:hair:4k a.test --size 32x24 --threads 1");
    assert!(verified.contains("standard:hair:4k: 1 thread, kernel auto: identical"));
}

#[test]
fn wrong_names_and_sizes_are_2_with_the_closest_name_and_where_all_are_listed() {
    let room = TestFolder::new();
    for command in ["render", "verify", "info"] {
        let cases = [
            ("standard:terain", "did you mean `terrain`"),
            ("standard:", "did you mean"),
            ("standard:tree:x", "`x` of tree"),
            ("standard:tree:0", "tree comes in sizes 1 to"),
            ("standard:room:1k", "room comes in sizes 4000 to"),
            ("standard:room:99999M", "not 99999000000"),
            ("standard:room:1M:2", "`1M:2` of room"),
        ];
        for (name, part) in cases {
            let parts = ["error: ", part, "phalanx scenes"];
            room.refused(&format!("{command} {name}"), 2, &parts);
        }
    }
}

#[test]
fn scenes_lists_every_scene_with_its_counts() {
    let room = TestFolder::new();
    let document = room.json("scenes --json");
    assert_eq!(document["schema_version"], 1);
    let scenes = document["scenes"].as_array().unwrap();
    let named = |name: &str| scenes.iter().find(|s| s["name"] == name).unwrap();
    let tree = named("tree");
    assert_eq!(
        (&tree["spheres"], &tree["cones"], &tree["lights"]),
        (&4095.into(), &4095.into(), &7.into())
    );
    assert_eq!(tree["family"], "spd");
    let street = named("street");
    assert_eq!(street["default_size"], 1_000_000);
    assert_eq!(street["family"], "modern");
    let table = room.ok("scenes");
    for scene in scenes {
        let purpose = scene["purpose"].as_str().unwrap();
        let name = scene["name"].as_str().unwrap();
        let line = table.lines().find(|l| l.ends_with(purpose)).unwrap();
        assert!(line.starts_with(name), "{line}");
    }
    assert!(table.contains("9,345"), "gears:\n{table}");
    room.refused("scenes all", 2, &["unexpected argument"]);
}

#[test]
fn generated_files_are_scenes_that_can_be_read() {
    let room = TestFolder::new();
    room.ok("generate shells --size 2 -o shells.nff");
    room.ok("generate standard:cornell:4k -o cornell.test");
    room.ok("generate room --size 5k -o room.nff");
    for name in ["shells.nff", "cornell.test", "room.nff"] {
        room.ok(&format!("info {name}"));
    }
    let made = room.json("info cornell.test --json");
    let own = room.json("info standard:cornell:4k --json");
    assert_eq!(made["primitives"], own["primitives"]);
    let document = room.json("generate menger --size 5k -o menger.PLY --json");
    let length = fs::metadata(room.path().join("menger.PLY")).unwrap().len();
    assert_eq!(document["bytes"], length);
    assert_eq!(document["size"], 5000);
    assert!(!document["losses"].as_array().unwrap().is_empty());
    let ply = fs::read(room.path().join("menger.PLY")).unwrap();
    assert!(ply.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
    // An existing file is replaced.
    room.ok("generate balls --size 1 -o shells.nff");
    let text = fs::read_to_string(room.path().join("shells.nff")).unwrap();
    assert_eq!(text.lines().filter(|l| l.starts_with("s ")).count(), 10);
}

#[test]
fn formats_that_cannot_hold_a_scene_are_2_unless_it_is_tessellated() {
    let room = TestFolder::new();
    let cases = [
        ("balls -o a.ply", "spheres"),
        ("jacks -o a.ply", "cones"),
        ("jacks -o b.test", "cones"),
    ];
    for (line, shape) in cases {
        let parts = ["error: ", shape, "--tessellate"];
        room.refused(&format!("generate {line}"), 2, &parts);
        room.ok(&format!("generate {line} --tessellate 2"));
    }
    assert_eq!(room.names(), ["a.ply", "b.test"]);
}

#[test]
fn what_generate_cannot_do_is_said_before_anything_is_written() {
    let room = TestFolder::new();
    for (line, part) in [
        ("generate", "<NAME>"),
        ("generate balls", "--output"),
        ("generate bals -o a.nff", "did you mean `balls`"),
        ("generate balls --size many -o a.nff", "`many` of balls"),
        ("generate balls --size 99 -o a.nff", "comes in sizes"),
        ("generate balls:3 --size 3 -o a.nff", "omit --size"),
        ("generate balls -o a.obj", ".nff, .ply or .test"),
        ("generate balls -o a", ".nff, .ply or .test"),
        ("generate balls -o a.ply --tessellate 0", "1..=1000"),
    ] {
        room.refused(line, 2, &["error: ", part]);
    }
    let missing = "generate balls --size 1 -o none/a.nff";
    room.refused(missing, 1, &["cannot write none/a.nff"]);
}

#[test]
fn an_interrupted_generation_leaves_the_old_file_and_no_part_of_a_new_one() {
    let room = TestFolder::new();
    room.write("a.nff", "old");
    let before = room.names();
    let mut child = room
        .command("generate terrain --size 5M -o a.nff")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Its temporary file shows that it has started.
    while room.names() == before {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(100));
    super::signals::signal(&child, "INT");
    let mut messages = String::new();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    stderr.read_line(&mut messages).unwrap();
    stderr.read_to_string(&mut messages).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{messages}");
    assert!(messages.contains("interrupted"), "{messages}");
    assert_eq!(room.names(), before);
    assert_eq!(
        fs::read_to_string(room.path().join("a.nff")).unwrap(),
        "old"
    );
}
