//! `phalanx compare`, by format: figures, verdicts, and pictures that cannot be compared.

use super::{TestFolder, ran};
use serde_json::Value;
use std::fs;

/// Two renders that differ a little, in every format.
fn rendered() -> TestFolder {
    let room = TestFolder::new();
    for ending in ["png", "jpg", "exr", "hdr", "pfm"] {
        room.ok(&format!("render a.test -o a.{ending}"));
        room.ok(&format!("render a.test -o b.{ending} --max-depth 1"));
    }
    room
}

/// The document of a comparison, with any verdict, and the exit code.
fn document(room: &TestFolder, line: &str) -> (Value, Option<i32>) {
    let ran = ran(&mut room.command(&format!("compare {line} --json")));
    let json = serde_json::from_str(&ran.stdout);
    (
        json.unwrap_or_else(|e| panic!("{line}: {e}: {}", ran.stderr)),
        ran.code,
    )
}

#[test]
fn every_format_is_compared_with_those_of_its_kind() {
    let room = rendered();
    for ending in ["png", "jpg", "exr", "hdr", "pfm"] {
        assert_eq!(
            room.ok(&format!("compare a.{ending} a.{ending}")),
            "identical\n"
        );
        let (json, code) = document(&room, &format!("a.{ending} b.{ending}"));
        assert_eq!(
            (code, &json["verdict"]),
            (Some(4), &Value::from("different")),
            "{ending}"
        );
        let layer = &json["layers"][0];
        assert_eq!(layer["name"], "color");
        for key in [
            "largest_difference",
            "rmse",
            "psnr",
            "ssim",
            "flip",
            "differing_pixels",
        ] {
            assert!(layer[key].as_f64().unwrap() > 0.0, "{ending} {key}");
        }
        assert!(layer["at"]["x"].as_u64().unwrap() < 40);
        assert!(layer["ssim"].as_f64().unwrap() < 1.0);
        let largest = json["largest_difference"].as_f64().unwrap();
        let just = format!("a.{ending} b.{ending} --tolerance {largest}");
        let (json, code) = document(&room, &just);
        assert_eq!(
            (code, &json["verdict"]),
            (Some(0), &Value::from("within_tolerance"))
        );
        assert_eq!(json["differing_pixels"], 0);
        let below = largest * 0.999;
        let (json, code) = document(&room, &format!("a.{ending} b.{ending} --tolerance {below}"));
        assert_eq!(code, Some(4), "{json}");
        // All pixels beyond the tolerance may be permitted, by number or by share.
        let differing = json["differing_pixels"].as_u64().unwrap();
        for (most, want) in [
            (format!("{differing}"), 0),
            (format!("{}", differing - 1), 4),
            ("100%".into(), 0),
        ] {
            let line = format!("a.{ending} b.{ending} --tolerance {below} --max-differing {most}");
            assert_eq!(document(&room, &line).1, Some(want), "{line}");
        }
    }
    assert_eq!(room.ok("compare a.exr a.pfm"), "identical\n");
    assert_eq!(document(&room, "a.png a.jpg --tolerance 255").1, Some(0));
    assert_eq!(document(&room, "a.hdr a.exr --tolerance 0.02").1, Some(0));
    let help = "compare only PNG and JPEG, or only EXR, HDR and PFM";
    let parts = [
        "a.exr holds linear radiance, and a.png samples for a screen",
        help,
    ];
    room.refused("compare a.exr a.png --heat heat.png", 2, &parts);
    room.refused(
        "compare a.jpg a.hdr",
        2,
        &["a.hdr holds linear radiance", help],
    );
}

#[test]
fn layers_have_a_row_each_and_missing_ones_are_a_difference() {
    let room = TestFolder::new();
    room.ok("render a.test -o a.exr --aov depth,albedo,material");
    room.ok("render a.test -o b.exr --aov depth,ns,material --max-depth 1");
    let shown = room.run("compare a.exr b.exr --tolerance 100");
    assert_eq!(shown.code, Some(4), "{}", shown.stdout);
    let rows: Vec<Vec<&str>> = shown
        .stdout
        .lines()
        .map(|l| l.split_whitespace().collect())
        .collect();
    assert_eq!(rows[0], ["different"]);
    assert_eq!(rows[1][..2], ["layer", "largest"]);
    assert_eq!(rows[2][0], "color");
    for layer in ["Z", "material"] {
        assert!(rows.contains(&vec![layer, "identical"]), "{}", shown.stdout);
    }
    for (label, layer) in [("first", "albedo"), ("second", "N")] {
        let row = vec!["only", "in", label, layer];
        assert!(rows.contains(&row), "{}", shown.stdout);
    }
    // Rays that miss have no depth, in both.
    let note = shown
        .stdout
        .lines()
        .find(|line| line.starts_with("not finite"));
    assert!(
        note.unwrap().ends_with("0 of them different"),
        "{}",
        shown.stdout
    );
    assert!(
        shown.stdout.lines().all(|line| line.chars().count() <= 80),
        "{}",
        shown.stdout
    );
    let (json, _) = document(&room, "a.exr b.exr");
    let only = [&json["only_in_a"], &json["only_in_b"]];
    assert_eq!(
        only,
        [&Value::from(vec!["albedo"]), &Value::from(vec!["N"])]
    );
    room.ok("render a.test -o c.pfm");
    let (json, code) = document(&room, "a.exr c.pfm");
    assert_eq!(
        (code, &json["verdict"]),
        (Some(0), &Value::from("identical"))
    );
    assert_eq!(
        json["not_compared"],
        Value::from(vec!["Z", "albedo", "material"])
    );
}

#[test]
fn pictures_of_the_differences_are_written_for_every_format() {
    let room = rendered();
    for ending in ["png", "jpg", "exr", "hdr", "pfm"] {
        let line = format!("a.{ending} b.{ending} --heat heat.png --side-by-side both.png");
        let (json, _) = document(&room, &line);
        let read = |name: &str| phalanx::image::load(&room.path().join(name)).unwrap();
        let (heat, both) = (read("heat.png"), read("both.png"));
        let lit = heat.pixels.iter().filter(|p| p[0] > 0).count();
        assert_eq!(
            lit as u64,
            json["differing_pixels"].as_u64().unwrap(),
            "{ending}"
        );
        assert_eq!([both.width, both.height], [3 * 40 + 16, 24]);
        assert_eq!(json["side_by_side"], "both.png");
        let row = &both.pixels[12 * 136..13 * 136];
        assert_eq!(row[96..], heat.pixels[12 * 40..13 * 40], "{ending}");
    }
    let same = "--heat and --side-by-side are the same file";
    room.refused(
        "compare a.png b.png --heat x.png --side-by-side x.png",
        2,
        &[same],
    );
}

#[test]
fn broken_pictures_of_every_format_are_refused() {
    let room = rendered();
    for (ending, kind) in [
        ("png", "a PNG picture"),
        ("exr", "an OpenEXR picture"),
        ("hdr", "a Radiance HDR picture"),
        ("pfm", "a portable float map"),
    ] {
        let full = fs::read(room.path().join(format!("a.{ending}"))).unwrap();
        let half = room.path().join(format!("half.{ending}"));
        fs::write(half, &full[..full.len() / 2]).unwrap();
        let expected = format!("error: half.{ending}: not {kind} that can be read: ");
        room.refused(
            &format!("compare a.{ending} half.{ending} --heat h.png"),
            1,
            &[&expected],
        );
        room.refused(
            &format!("compare half.{ending} a.{ending}"),
            1,
            &[&expected],
        );
    }
    // Only a JPEG's end marker may be missing.
    let full = fs::read(room.path().join("a.jpg")).unwrap();
    fs::write(room.path().join("cut.jpg"), &full[..full.len() - 2]).unwrap();
    room.ok("compare a.jpg cut.jpg");
    fs::write(room.path().join("half.jpg"), &full[..full.len() / 2]).unwrap();
    room.refused("compare a.jpg half.jpg", 1, &["it ends too early"]);
    fs::write(room.path().join("huge.pfm"), "PF\n65536 65536\n-1\n").unwrap();
    room.refused("compare huge.pfm a.pfm", 1, &["it ends too early"]);
}
