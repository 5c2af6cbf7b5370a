//! Parts of a picture that a file does not specify: parallel cameras, the sky seen in mirrors,
//! normals, and warnings about empty pictures.

use super::TestFolder;

/// A square of side 2 in the plane z = 0, and a smaller one behind it to its right.
const SQUARES: &str = "\
mtllib m.mtl
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
v 2 -1 -4
v 3 -1 -4
v 3 0 -4
usemtl m
f 1 2 3 4
f 5 6 7
";

fn room(material: &str) -> TestFolder {
    let room = TestFolder::new();
    room.write("s.obj", SQUARES);
    room.write("m.mtl", &format!("newmtl m\n{material}\n"));
    room
}

fn picture(room: &TestFolder, line: &str) -> phalanx::image::Raster {
    room.ok(&format!(
        "render s.obj -o out.png --size 40x40 --threads 1 {line}"
    ));
    phalanx::image::load(&room.path().join("out.png")).unwrap()
}

/// Columns and rows between the first and the last pixel that differs from the corner.
fn extent(picture: &phalanx::image::Raster) -> [usize; 4] {
    let width = picture.width as usize;
    let shown = |k: &usize| picture.pixels[*k] != picture.pixels[0];
    let seen: Vec<usize> = (0..picture.pixels.len()).filter(shown).collect();
    let columns = || seen.iter().map(|k| k % width);
    [
        columns().min().unwrap(),
        columns().max().unwrap(),
        seen[0] / width,
        seen[seen.len() - 1] / width,
    ]
}

#[test]
fn a_parallel_camera_shows_its_height_whatever_the_distance() {
    let room = room("Kd 1 1 1");
    for eye in ["0,0,2", "0,0,90"] {
        let camera = format!("--camera {eye} 0,0,0 0,1,0 40 --light dir:0,0,1");
        let seen = extent(&picture(&room, &format!("{camera} --ortho=8")));
        // Eight units are forty pixels: from −1 to 3, and from −1 to 1.
        assert_eq!(seen, [15, 34, 15, 24], "{eye}");
    }
    // Without a height the scale at the target is kept: at a distance of 2, 90° show 4 units.
    let near = "--camera 0,0,2 0,0,0 0,1,0 90 --light dir:0,0,1 --ortho";
    assert_eq!(extent(&picture(&room, near)), [10, 29, 10, 29]);
    // A default camera frames everything.
    let [left, right, top, bottom] = extent(&picture(&room, "--ortho"));
    assert!(left > 0 && right < 39 && top > 0 && bottom < 39);
    assert!(right - left > 30 || bottom - top > 30);
    room.refused("render s.obj --ortho=-1", 2, &["--ortho", "above 0"]);
    room.refused(
        "render s.obj --ortho=3 --aperture .1 --focus 2",
        2,
        &["parallel rays has no lens"],
    );
}

#[test]
fn the_test_format_has_parallel_cameras() {
    let room = TestFolder::new();
    let scene = |lines: &str| {
        format!("size 20 20\n{lines}\nambient 1 1 1\nsphere 0 0 0 1\nsphere 2.8 0 -50 1\n")
    };
    let (camera, ortho) = ("camera 0 0 9 0 0 0 0 1 0 40", "ortho 8");
    room.write("a.test", &scene(&format!("{camera}\n{ortho}")));
    room.write("b.test", &scene(&format!("{ortho}\n{camera}")));
    for name in ["a", "b"] {
        room.ok(&format!("render {name}.test -o {name}.png --threads 1"));
    }
    let read = |name: &str| phalanx::image::load(&room.path().join(name)).unwrap();
    let (a, b) = (read("a.png"), read("b.png"));
    assert_eq!(a.pixels, b.pixels);
    // Both spheres have the same size.
    let lit = |from: usize| {
        let row = &a.pixels[10 * 20..11 * 20];
        row[from..from + 6].iter().filter(|p| p[0] > 0).count()
    };
    assert_eq!((lit(7), lit(14)), (4, 4));
    room.write("c.test", &scene("ortho 0"));
    room.refused("render c.test", 3, &["c.test:2:7", "must be positive"]);
}

#[test]
fn mirrors_see_a_sky_where_the_file_has_no_surroundings() {
    let mirror = room("Kd 0 0 0\nKs 1 1 1\nillum 3");
    let ran = mirror.run("render s.obj -o out.png --size 40x40 --threads 1");
    assert!(ran.stderr.contains("mirrors see a sky"), "{}", ran.stderr);
    let seen = phalanx::image::load(&mirror.path().join("out.png")).unwrap();
    extent(&seen);
    // Only the user's own background is visible.
    let ran = mirror.run("render s.obj -o out.png --size 40x40 --threads 1 --background .5");
    assert!(!ran.stderr.contains("sky"), "{}", ran.stderr);
    // No sky without mirrors.
    let matt = room("Kd 1 1 1");
    let ran = matt.run("render s.obj -o out.png --size 40x40 --threads 1");
    assert!(!ran.stderr.contains("sky"), "{}", ran.stderr);
}

#[test]
fn a_picture_that_shows_nothing_says_why() {
    let stderr_of = |material: &str, line: &str| {
        let room = room(material);
        let ran = room.run(&format!("render s.obj -o out.png --size 40x40 {line}"));
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        ran.stderr
    };
    let seen = "--camera 0,0,5 0,0,0 0,1,0 40";
    // Alone in its file, such a material would be taken as opaque.
    let hidden = "Kd 1 1 1\nd 0\nnewmtl other\nKd 1 1 1";
    for (material, line, reason) in [
        (
            "Kd 1 1 1",
            "--camera 0,0,5 0,0,9 0,1,0 40",
            "behind the camera",
        ),
        (
            "Kd 1 1 1",
            "--camera 9,0,5 9,0,0 0,1,0 40",
            "to the side of the picture",
        ),
        (
            "Kd 1 1 1",
            "--camera 0,9,5 0,9,0 0,1,0 40",
            "above or below",
        ),
        (hidden, seen, "every surface is fully transparent"),
        (
            "Ke .5 .5 .5\nKd 0 0 0",
            "--camera 0,0,.1 0,0,0 0,1,0 9",
            "one surface fills it",
        ),
        (
            "Kd 1 1 1",
            "--camera 0,0,5 0,0,0 0,1,0 40 --exposure=-60",
            "--exposure",
        ),
        (
            "Kd 1 1 1",
            "--camera 0,0,5 0,0,0 0,1,0 40 --exposure 60",
            "--exposure",
        ),
    ] {
        let stderr = stderr_of(material, line);
        let warned = stderr.contains("warning: the picture is empty");
        assert!(warned && stderr.contains(reason), "{line}: {stderr}");
    }
    assert!(!stderr_of("Kd 1 1 1", seen).contains("empty"));
    // Small, but not by its colour.
    let tiny =
        room("Kd 1 1 1").run("render s.obj -o a.png --size 3x3 --camera 0,0,5 0,0,9 0,1,0 40");
    assert!(tiny.stderr.contains("behind the camera"), "{}", tiny.stderr);
    // A detail may well have one colour.
    let detail = format!("{seen} --region 0 0 4 4");
    assert!(!stderr_of(hidden, &detail).contains("empty"));
}

/// Lights and samples of a first look, on all ways to a picture.
#[test]
fn a_bare_mesh_is_smooth_and_its_dark_side_lit_however_it_is_rendered() {
    let room = room("Kd 1 1 1");
    let spp = |line: &str| {
        let report = room.json(&format!("render {line} -o out.png --size 40x30 --json"));
        report["spp"].as_u64().unwrap()
    };
    room.ok("build s.obj -o s.phx");
    let camera = "--camera 0,0,9 0,0,0 0,1,0 40";
    for (line, want) in [
        ("s.obj", 4),
        ("s.phx", 4),
        ("s.obj --spp 1", 1),
        ("s.obj --spp 7", 7),
        ("s.obj --aa adaptive --spp 9", 9),
        ("s.obj --light 1,2,3", 4),
        ("s.phx --light 1,2,3", 4),
        ("a.test", 1),
        ("standard:tetra:2", 1),
    ] {
        assert_eq!(spp(line), want, "{line}");
    }
    // However the camera is placed: a sequence of views looks like its frames.
    for scene in ["s.obj", "s.phx"] {
        assert_eq!(spp(&format!("{scene} {camera}")), 4);
        for line in ["", camera] {
            let described = room.json(&format!("info {scene} {line} --json"));
            assert_eq!(described["lights"]["directional"], 1, "{scene} {line}");
        }
    }
    let picture = "--size 40x30 --tile 8";
    let bytes = |name: &str| std::fs::read(room.path().join(name)).unwrap();
    room.ok(&format!(
        "render s.obj -o a.png {picture} --checkpoint a.tiles"
    ));
    room.ok(&format!(
        "plan s.obj --shards 2 -o b.png --plan p.json {picture}"
    ));
    for shard in 0..2 {
        room.ok(&format!("render --plan p.json --shard {shard}"));
    }
    room.ok("merge p.json");
    room.ok(&format!("render s.obj -o c.png {picture} --engine scalar"));
    room.ok(&format!(
        "render s.obj -o d.png {picture} --spp 4 --checkpoint a.tiles"
    ));
    room.ok(&format!("render s.phx -o e.png {picture}"));
    for other in ["b.png", "c.png", "d.png"] {
        assert!(bytes("a.png") == bytes(other), "{other}");
    }
    let pixels = |name: &str| {
        phalanx::image::load(&room.path().join(name))
            .unwrap()
            .pixels
    };
    assert_eq!(pixels("a.png"), pixels("e.png"));
    room.ok(&format!(
        "verify s.obj {picture} --frames 1..2 --turntable 3"
    ));
}

#[test]
fn a_made_up_camera_frames_the_picture_that_is_asked_for() {
    let room = TestFolder::new();
    room.write("w.obj", "v -5 0 0\nv 5 0 0\nv 5 1 0\nv -5 1 0\nf 1 2 3 4\n");
    room.ok("build w.obj -o w.phx");
    let seen = |line: &str, [width, height]: [usize; 2]| {
        let size = format!("--size {width}x{height} --threads 1");
        room.ok(&format!("render {line} -o out.png {size}"));
        let picture = phalanx::image::load(&room.path().join("out.png")).unwrap();
        let [left, right, top, bottom] = extent(&picture);
        let framed = left > 0 && right < width - 1 && top > 0 && bottom < height - 1;
        assert!(framed, "{line} {size}: {left} {right} {top} {bottom}");
        assert!(right - left > width * 3 / 4 || bottom - top > height * 3 / 4);
        picture.pixels
    };
    for size in [[60, 60], [40, 90], [90, 40]] {
        let direct = seen("w.obj", size);
        assert_eq!(seen("w.phx", size), direct);
        assert_eq!(seen("w.phx --up y", size), direct);
        assert_eq!(seen("w.phx --up z", size), seen("w.obj --up z", size));
        assert_ne!(seen("w.obj --up=-x", size), direct);
    }
    room.ok("render w.obj -o t#.png --size 40x90 --frames 0..3 --turntable 4 --threads 1");
    for frame in 0..4 {
        let picture = phalanx::image::load(&room.path().join(format!("t{frame}.png"))).unwrap();
        let [left, right, ..] = extent(&picture);
        assert!(left > 0 && right < 39, "{frame}: {left} {right}");
    }
    let ran = room.run("render w.obj -o out.png --camera 0,0,9 0,0,0 0,1,0 40 --up z");
    assert!(ran.stderr.contains("--up has no effect"), "{}", ran.stderr);
    room.refused("render w.obj --up w", 2, &["--up", "-x"]);
}

/// Text of an OBJ file of a half cylinder of 12 sides, 15 degrees apart, without normals.
fn half_pipe() -> String {
    let angles = (0..=12).map(|k| (f64::from(k) * 15.0).to_radians().sin_cos());
    let vertices = angles.map(|(sin, cos)| format!("v {cos} -1 {sin}\nv {cos} 1 {sin}\n"));
    let sides = (0..12).map(|k| [1, 2, 4, 3].map(|corner| corner + 2 * k));
    let faces = sides.map(|[a, b, c, d]| format!("f {d} {c} {b}\nf {d} {b} {a}\n"));
    vertices.chain(faces).collect()
}

/// Made normals are part of the scene: of its files, caches, checkpoints and commands.
#[test]
fn smooth_surfaces_are_smooth_wherever_the_scene_is() {
    let room = TestFolder::new();
    room.write("s.obj", &half_pipe());
    let bytes = |line: &str| {
        let line = format!("render {line} -o out.png --size 40x30 --threads 1");
        room.ok(&line);
        std::fs::read(room.path().join("out.png")).unwrap()
    };
    let pixels = |line: &str| {
        bytes(line);
        phalanx::image::load(&room.path().join("out.png"))
            .unwrap()
            .pixels
    };
    let (flat, smooth) = (pixels("s.obj"), pixels("s.obj --smooth"));
    assert!(flat != smooth);
    assert!(pixels("s.obj --smooth=30 --engine scalar") == smooth);
    assert!(pixels("s.obj --smooth=14") == flat);
    room.ok("verify s.obj --smooth --size 40x30");
    room.ok("build s.obj --smooth -o s.phx");
    assert!(pixels("s.phx") == smooth);
    let line = "render s.obj -o out.png --size 40x30 --checkpoint c.ckpt";
    room.ok(line);
    room.refused(&format!("{line} --smooth"), 2, &["c.ckpt"]);
    for (line, what) in [
        ("s.phx --smooth", "on a scene cache"),
        ("a.test --smooth", "all triangles"),
        ("s.obj --smooth=14", "beyond its angle"),
    ] {
        let ran = room.run(&format!("info {line}"));
        let note = format!(
            "--smooth has no effect{}",
            if line.contains("phx") { " " } else { ": " }
        );
        assert!(
            ran.stderr.contains(&note) && ran.stderr.contains(what),
            "{}",
            ran.stderr
        );
    }
    for angle in ["-1", "181", "x", "nan", ""] {
        let line = format!("info s.obj --smooth={angle}");
        room.refused(&line, 2, &["--smooth"]);
    }
    // The program, three times the file, and some of what normals take.
    let limit = (24 << 20) + 3 * half_pipe().len() + 1500;
    let line = format!("info s.obj --max-memory {limit} --smooth");
    room.refused(&line, 1, &["smooth normals"]);
}
