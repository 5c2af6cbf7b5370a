//! Commands that succeed, or find a difference.

use super::{SCENE, TestFolder, ran};
use serde_json::Value;
use std::fs;

#[test]
fn render_writes_a_picture_and_a_table() {
    let room = TestFolder::new();
    let table = room.ok("render a.test -v");
    for part in [
        "40x24",
        "2 spheres, 1 triangle",
        "Mrays/s",
        "primary                   960",
        "written      a.png",
    ] {
        assert!(table.contains(part), "{part:?} in\n{table}");
    }
    assert_eq!(room.names(), ["a.png"]);
    let picture = phalanx::image::load(&room.path().join("a.png")).unwrap();
    assert_eq!((picture.width, picture.height), (40, 24));
    assert!(
        picture.pixels.iter().any(|p| p[0] > 10_000) && picture.pixels.iter().any(|p| p[0] == 0)
    );
}

#[test]
fn the_picture_is_named_by_the_user_or_the_scene_or_after_the_scene() {
    let room = TestFolder::new();
    room.write("named.test", &format!("{SCENE}output own.png\n"));
    fs::create_dir(room.path().join("sub")).unwrap();
    room.ok("render named.test");
    room.ok("render named.test -o sub/other.PNG");
    assert_eq!(room.names(), ["named.test", "own.png", "sub"]);
    assert!(room.path().join("sub/other.PNG").is_file());
    room.write("bitmap.test", &format!("{SCENE}output own.bmp\n"));
    room.refused("render bitmap.test", 2, &["own.bmp", ".png", "-o"]);
}

#[test]
fn render_json_is_one_document_with_the_promised_keys() {
    let room = TestFolder::new();
    let json = room.json("render a.test --json --size 33x17 --threads 2 --pin none");
    assert_eq!(json["schema_version"], 1);
    assert_eq!(
        (json["engine"].as_str(), json["threads"].as_u64()),
        (Some("simd"), Some(2))
    );
    assert_eq!(json["isa"], phalanx::isa::compiled_level());
    let image = serde_json::json!({"width": 33, "height": 17, "region": null, "frames": null, "exposure": null, "path": "a.png"});
    assert_eq!(json["image"], image);
    assert_eq!(json["scene"], "a.test");
    assert_eq!(json["rays"]["primary"], 33 * 17);
    let kinds = ["primary", "shadow", "reflection", "refraction"];
    let sum: u64 = kinds
        .iter()
        .map(|k| json["rays"][k].as_u64().unwrap())
        .sum();
    assert_eq!(json["rays"]["total"], sum);
    let speeds: f64 = kinds
        .iter()
        .map(|k| json["mrays_per_s"][k].as_f64().unwrap())
        .sum();
    assert!((speeds / json["mrays_per_s"]["total"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    for key in ["load", "build", "render", "write"] {
        assert!(json["seconds"][key].as_f64().unwrap() >= 0.0);
    }
    let occupancy = json["occupancy"].as_f64().unwrap();
    assert!(occupancy > 0.0 && occupancy <= 1.0);
    assert!(json["memory"]["peak_rss_bytes"].as_u64().unwrap() > 100_000);
    let scalar = room.json("render a.test --json --engine scalar");
    assert_eq!(
        (&scalar["engine"], &scalar["occupancy"]),
        (&Value::from("scalar"), &Value::Null)
    );
}

#[test]
fn pictures_do_not_depend_on_engine_threads_or_tiles_but_on_tone() {
    let room = TestFolder::new();
    let bytes = |options: &str| {
        room.ok(&format!("render a.test -o b.png {options}"));
        fs::read(room.path().join("b.png")).unwrap()
    };
    let plain = bytes("");
    for same in [
        "--engine scalar",
        "--threads 3 --tile 8",
        "--pin none --kernel packet8",
        "--transfer none --quantize floor",
    ] {
        assert_eq!(bytes(same), plain, "{same}");
    }
    for other in [
        "--transfer srgb",
        "--quantize round",
        "--max-depth 0",
        "--size 41x24",
        "--aperture 0.3 --focus 4",
        "--integrator ao",
        "--integrator ao --ao-distance 0.2",
    ] {
        assert_ne!(bytes(other), plain, "{other}");
    }
}

#[test]
fn verify_holds_both_engines_together() {
    let room = TestFolder::new();
    let lines = room.ok("verify a.test --threads 1,2 --kernel all --tile 16");
    let kernels = phalanx::frame::Kernel::ALL.len();
    assert_eq!(lines.lines().count(), 2 * kernels, "{lines}");
    assert!(
        lines
            .lines()
            .all(|l| l.starts_with("a.test: ") && l.ends_with(": identical")),
        "{lines}"
    );
    assert!(
        lines.contains("a.test: 2 threads, kernel packet16: identical\n"),
        "{lines}"
    );
    let json = room.json("verify a.test --json --size 24x16");
    assert_eq!(
        (&json["schema_version"], &json["identical"]),
        (&Value::from(1), &Value::from(true))
    );
    assert_eq!(json["scenes"][0]["runs"].as_array().unwrap().len(), 3);
    assert_eq!(json["scenes"][0]["rays"]["primary"], 24 * 16);
}

/// Everything random, by options and by the scene.
#[test]
fn verify_knows_every_option_and_command() {
    let room = TestFolder::new();
    let lights =
        "gloss 20\nspherelight 0 3 3 .5 .2 .2 .2\nrectlight -1 4 2 2 0 0 0 0 1 .2 .2 .2\npoint ";
    room.write("soft.test", &SCENE.replacen("point ", lights, 1));
    for options in [
        "--spp 2",
        "--spp 2 --aperture 0.3 --focus 4",
        "--integrator ao --ao-distance 0.2",
    ] {
        let line = format!("verify soft.test --size 24x16 --kernel all --threads 2 {options}");
        let lines = room.ok(&line);
        assert!(lines.lines().all(|l| l.ends_with(": identical")), "{lines}");
    }
    let json =
        room.json("verify soft.test --size 8x8 --aperture 0.5 --focus 4 --integrator ao --json");
    let scene = &json["scenes"][0];
    assert_eq!(
        (&scene["aperture"], &scene["focus"], &scene["integrator"]),
        (&Value::from(0.5), &Value::from(4.0), &Value::from("ao"))
    );
    assert_eq!(
        (&scene["spp"], &scene["ao_distance"]),
        (&Value::from(1), &Value::from(0.88))
    );
}

#[test]
fn a_record_holds_later_runs_to_it() {
    let room = TestFolder::new();
    room.ok("verify a.test --threads 1 --record r.json");
    let same = room.ok("verify a.test --threads 1 --against r.json");
    assert!(
        same.contains("a.test: against r.json: identical\n"),
        "{same}"
    );
    room.write("b.test", SCENE);
    for other in [
        "b.test",
        "a.test --size 41x24",
        "a.test --max-depth 1",
        "a.test --transfer srgb",
        "a.test --spp 2",
        "a.test --aperture 0.3 --focus 4",
        "a.test --integrator ao",
    ] {
        room.refused(
            &format!("verify {other} --against r.json"),
            2,
            &["error: the record "],
        );
    }
    // Black where the directional light shone, so the first lit pixel differs.
    room.write(
        "a.test",
        &SCENE.replace("0.5 0.5 0.5\npoint", "0 0 0\npoint"),
    );
    let changed = room.run("verify a.test --threads 1 --against r.json");
    assert_eq!(changed.code, Some(4), "{}", changed.stderr);
    assert!(
        changed
            .stdout
            .contains("against r.json: DIFFERENT, first at pixel ("),
        "{}",
        changed.stdout
    );
    let json = ran(&mut room.command("verify a.test --threads 1 --against r.json --json"));
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(json["identical"], false);
    assert_eq!(
        json["scenes"][0]["against"]["first_pixel"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
}

#[test]
fn compare_tells_equal_pictures_from_different_ones() {
    let room = TestFolder::new();
    room.ok("render a.test -o a.png");
    room.ok("render a.test -o b.png --engine scalar");
    room.ok("render a.test -o c.png --quantize round");
    room.ok("render a.test -o d.png --size 41x24");
    assert_eq!(room.ok("compare a.png b.png"), "identical\n");
    let different = room.run("compare a.png c.png --heat heat.png");
    assert_eq!(different.code, Some(4));
    assert!(
        different
            .stdout
            .starts_with("different\nlargest difference 1 of 255\n"),
        "{}",
        different.stdout
    );
    let json = ran(&mut room.command("compare a.png c.png --json"));
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(
        (&json["exact"], json["largest_difference"].as_f64()),
        (&Value::from(false), Some(1.0))
    );
    let share = json["differing_pixels"].as_f64().unwrap() / 960.0;
    assert!(share > 0.0 && (json["share"].as_f64().unwrap() - share).abs() < 1e-12);
    let heat = phalanx::image::load(&room.path().join("heat.png")).unwrap();
    let lit = heat.pixels.iter().filter(|p| p[0] > 0).count();
    assert_eq!(lit as u64, json["differing_pixels"].as_u64().unwrap());
    room.refused(
        "compare a.png d.png --heat size.png",
        4,
        &["40x24", "41x24"],
    );
}

#[test]
fn info_tells_what_is_in_a_scene() {
    let room = TestFolder::new();
    let json = room.json("info a.test --json");
    assert_eq!(
        json["primitives"],
        serde_json::json!({"spheres": 2, "triangles": 1, "cones": 0})
    );
    assert_eq!(
        json["lights"],
        serde_json::json!({"point": 1, "directional": 1, "sphere": 0, "rectangle": 0})
    );
    assert_eq!(
        json["bounds"],
        serde_json::json!({"lo": [-3.0, -1.0, -3.0], "hi": [3.0, 1.2, 3.0]})
    );
    assert!(json["materials"].as_u64().unwrap() >= 1);
    for key in ["nodes", "depth", "sah"] {
        assert!(json["bvh"][key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(json["memory"]["total_bytes"].as_u64().unwrap() > 0);
    let table = room.ok("info a.test");
    assert!(
        table.contains("1 point, 1 directional") && table.contains("(-3, -1, -3) to (3, 1.2, 3)"),
        "{table}"
    );
}

/// Only the command line selects stdout: a scene's output name is a file.
#[test]
fn a_scene_does_not_send_its_picture_to_stdout() {
    let room = TestFolder::new();
    room.write("dash.test", &SCENE.replace("camera", "output -\ncamera"));
    room.refused(
        "render dash.test",
        2,
        &["the scene's output ./-", "with -o"],
    );
    room.ok("build dash.test -o dash.phx");
    room.refused("render dash.phx", 2, &["the scene's output ./-", "with -o"]);
    assert!(room.ok("render dash.test --format png").contains("./-"));
    assert!(
        fs::read(room.path().join("-"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
}
