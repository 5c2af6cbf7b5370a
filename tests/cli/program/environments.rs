//! Environments on the command line: the same picture by every way to it.

use super::TestFolder;
use std::fs;

/// A mirror, a glass ball and nothing around them.
const BALLS: &str = "size 48 36\nmaxdepth 4\ncamera 0 1 6 0 0 0 0 1 0 40\ndirectional 1 2 3 1 1 1\n\
    diffuse .2 .2 .2\nspecular .8 .8 .8\nsphere -1 0 0 .9\nspecular .1 .1 .1\ntransmission .8 .8 .8\n\
    ior 1.5\nsphere 1 0 0 .9\n";

/// A folder with balls and with an environment.
fn surrounded() -> TestFolder {
    let room = TestFolder::new();
    room.write("balls.test", BALLS);
    fs::create_dir(room.path().join("maps")).unwrap();
    let (width, height) = (16, 8);
    let mut pfm = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    for k in 0..width * height {
        let color = [k % width, k / width, 3 * (k % 5)].map(|c| c as f32 / 10.0);
        pfm.extend(color.iter().flat_map(|c| c.to_le_bytes()));
    }
    fs::write(room.path().join("maps/a b.pfm"), pfm).unwrap();
    room
}

const TURNED: [&str; 4] = ["--environment", "maps/a b.pfm", "--environment-turn", "-30"];

/// Runs a command with the environment.
fn ok(room: &TestFolder, line: &str) -> super::Ran {
    let ran = super::ran(room.command(line).args(TURNED));
    assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
    ran
}

#[test]
fn shards_caches_and_commands_make_the_same_picture() {
    let room = surrounded();
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    let noted = ok(&room, "render balls.test -o one.png").stderr;
    assert_eq!(
        noted.matches("lights no matt surface").count(),
        1,
        "{noted}"
    );
    let one = bytes("one.png");
    room.ok("render balls.test -o plain.png");
    assert!(bytes("plain.png") != one);
    ok(&room, "render balls.test -o two.png --threads 3 --tile 8");
    ok(&room, "render balls.test -o three.png --engine scalar");
    ok(
        &room,
        "plan balls.test --shards 3 -o four.png --plan p.json",
    );
    for shard in 0..3 {
        room.ok(&format!("render --plan p.json --shard {shard}"));
    }
    room.ok("merge p.json");
    for name in ["two.png", "three.png", "four.png"] {
        assert!(bytes(name) == one, "{name}");
    }
    // A cache holds it, and may be turned further. Its pictures name another scene.
    ok(&room, "build balls.test -o balls.phx");
    room.ok("render balls.phx -o cached.pfm");
    ok(&room, "render balls.test -o read.pfm");
    assert!(bytes("cached.pfm") == bytes("read.pfm"));
    ok(&room, "render balls.phx -o again.pfm");
    assert!(bytes("again.pfm") == bytes("read.pfm"));
    room.ok("render balls.phx -o turned.pfm --environment-turn 10");
    assert!(bytes("turned.pfm") != bytes("read.pfm"));
    let frames = ok(
        &room,
        "render balls.test -o f#.png --turntable 4 --size 24x18",
    );
    assert_eq!(frames.stderr.matches("lights no matt surface").count(), 1);
    ok(&room, "verify balls.test --kernel all");
}

#[test]
fn a_background_hides_it_and_bare_options_are_explained() {
    let room = surrounded();
    room.ok("render balls.test -o a.pfm --environment .5,.25,1 --background .5,.25,1");
    room.ok("render balls.test -o b.pfm --environment .5,.25,1");
    room.ok("render balls.test -o c.pfm --background .5,.25,1");
    let bytes = |name: &str| fs::read(room.path().join(name)).unwrap();
    assert!(bytes("a.pfm") == bytes("b.pfm") && bytes("b.pfm") == bytes("c.pfm"));
    let alone = room.run("render balls.test -o d.pfm --environment-turn 10");
    assert!(alone.stderr.contains("no effect without an environment"));
    room.refused(
        "render balls.test -o e.png --environment balls.test",
        2,
        &["balls.test", "not a picture that can be read"],
    );
    room.refused(
        "render balls.test -o e.png --environment none.hdr",
        1,
        &["cannot read none.hdr"],
    );
    // 512 MiB of halfs, which the file need not hold to be refused.
    let header = "PF\n16384 5461\n-1.0\n";
    let file = fs::File::create(room.path().join("large.pfm")).unwrap();
    std::io::Write::write_all(&mut &file, header.as_bytes()).unwrap();
    file.set_len(header.len() as u64 + 16384 * 5461 * 12)
        .unwrap();
    for scene in ["balls.test", "standard:cornell"] {
        room.refused(
            &format!("render {scene} -o e.png --environment large.pfm --max-memory 300M"),
            1,
            &["for the environment", "--max-memory allows"],
        );
    }
    room.refused(
        "render balls.test -o e.png --environment 1,-1,1",
        2,
        &["negative"],
    );
}
