//! Tests of plans.

use super::super::planned_frames::PlannedFrames;
use super::*;
use phalanx_render::frame::Settings;
use phalanx_scene::Scene;
use serde_json::json;

pub(super) fn plan(width: u32, height: u32, shards: u32) -> RenderPlan {
    let scene = Scene::default();
    let settings = Settings {
        width,
        height,
        ..Settings::of(&scene)
    };
    let key = RenderKey::of(&scene, &settings);
    let spec = PictureSpec {
        scene: "a.test".to_owned(),
        ..PictureSpec::default()
    };
    RenderPlan::new(spec.resolve(&scene), key, "a.png".into(), shards)
}

#[test]
fn every_pixel_is_of_one_shard_and_shares_are_alike() {
    for (width, height, shards, side) in [
        (640, 480, 1, 64),
        (640, 480, 7, 32),
        (641, 479, 64, 16),
        (40, 24, 64, 8),
    ] {
        let plan = plan(width, height, shards);
        assert_eq!(plan.tile, side, "{width}x{height} in {shards}");
        let mut seen = vec![0u8; (width * height) as usize];
        let mut counts = Vec::new();
        for shard in 0..shards {
            let share = plan.share(shard).unwrap();
            counts.push(share.len());
            for tile in share {
                for y in tile.y..tile.y + tile.height {
                    for x in tile.x..tile.x + tile.width {
                        seen[(y * width + x) as usize] += 1;
                    }
                }
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(most - least <= 1, "{counts:?}");
        assert!(plan.share(shards).is_err());
    }
}

#[test]
fn shard_files_stand_beside_the_plan_in_order() {
    let plan = plan(640, 480, 64);
    let frames = PlannedFrames::of(&plan);
    let file = |shard| {
        frames
            .tile_file(Path::new("jobs/a.json"), shard, 0)
            .unwrap()
    };
    assert_eq!(file(3), Path::new("jobs/a.shard-03.tiles"));
    assert_eq!(file(63), Path::new("jobs/a.shard-63.tiles"));
}

#[test]
fn what_is_no_plan_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let good = serde_json::to_value(plan(640, 480, 4)).unwrap();
    std::fs::write(&path, good.to_string()).unwrap();
    assert_eq!(RenderPlan::read(&path).unwrap(), plan(640, 480, 4));
    let refused = |bad: &str| {
        std::fs::write(&path, bad).unwrap();
        let refused = RenderPlan::read(&path).unwrap_err();
        let message = refused.to_string();
        assert!(!message.contains(char::is_control), "{message:?}");
        refused
    };
    let field = |pointer: &str, value: serde_json::Value| {
        let mut bad = good.clone();
        *bad.pointer_mut(pointer).unwrap() = value;
        match refused(&bad.to_string()) {
            PlanError::Field { error, .. } => error.field,
            other => panic!("{pointer}: {other}"),
        }
    };
    let far = u32::MAX - 5;
    for (pointer, value, name) in [
        ("/shards", json!(0), "shards"),
        ("/shards", json!(100_001), "shards"),
        ("/tile", json!(0), "tile"),
        ("/tile", json!(7), "tile"),
        // A side that tiles may have, but not in this plan: there would be more tiles than the
        // program ever assigns.
        ("/tile", json!(8), "tile"),
        ("/spec/scene", json!(""), "scene"),
        ("/spec/scene", json!("a\nb"), "scene"),
        ("/spec/format", json!("a\r"), "format"),
        ("/output", json!(""), "output"),
        ("/output", json!("a\u{7}.png"), "output"),
        ("/spec/overrides/allow_path", json!(["a\r"]), "allow_path"),
        ("/header/scene", json!("a\r"), "header.scene"),
        ("/header/command", json!("\u{1b}"), "header.command"),
        ("/spec/encoding/bits", json!(7), "encoding.bits"),
        ("/spec/encoding/bits", json!(0), "encoding.bits"),
        ("/spec/encoding/exposure", json!(1e38), "encoding.exposure"),
        (
            "/spec/encoding/exposure",
            json!(-100.5),
            "encoding.exposure",
        ),
        ("/spec/pixels/size", json!([0, 480]), "pixels.size"),
        ("/spec/pixels/size", json!([640, 70_000]), "pixels.size"),
        (
            "/spec/pixels/region",
            json!([0, 0, 641, 480]),
            "pixels.region",
        ),
        (
            "/spec/pixels/region",
            json!([far, far, 9, 9]),
            "pixels.region",
        ),
        ("/spec/pixels/region", json!([9, 9, 0, 9]), "pixels.region"),
        ("/spec/pixels/region", json!([9, 9, 9]), "pixels.region"),
        ("/spec/pixels/spp", json!(0), "pixels.spp"),
        ("/spec/pixels/spp", json!(null), "pixels.spp"),
        ("/spec/pixels/max_depth", json!(1001), "pixels.max_depth"),
        ("/spec/pixels/min_weight", json!(-1), "pixels.min_weight"),
        ("/spec/pixels/threshold", json!(0.1), "pixels.threshold"),
        ("/spec/pixels/aperture", json!(-1), "pixels.aperture"),
        ("/stamp/scene", json!("\u{1b}[2J"), "stamp.scene"),
        ("/stamp/version", json!("\n"), "stamp.version"),
    ] {
        assert_eq!(field(pointer, value), name);
    }
    for (pointer, value) in [
        ("/spec/pixels", json!("Settings { width: 0 }")),
        ("/spec/encoding/tone/transfer", json!("x")),
        ("/spec/pixels/aov", json!(["x"])),
        ("/spec/pixels/filter", json!("\u{1b}[2J")),
        ("/spec/pixels/region", json!([0, 0, 0.5, 1])),
        ("/spec/pixels/size", json!([-1, 1])),
        ("/spec/pixels/min_weight", json!(1e39)),
        ("/spec/encoding/bits", json!(264)),
        ("/spec/encoding/exposure", json!("1")),
        ("/spec/encoding/exposure", json!("auto")),
        ("/spec/encoding/curve", json!("filmic")),
        ("/spec/overrides/light", json!("1,2,3")),
        ("/spec/overrides/light", json!(["1,2"])),
        ("/spec/overrides/camera", json!(["1,2,3"])),
        ("/spec/overrides/origin", json!("\u{1b}[2J")),
    ] {
        let mut bad = good.clone();
        *bad.pointer_mut(pointer).unwrap() = value;
        let refused = refused(&bad.to_string());
        assert!(matches!(refused, PlanError::Malformed { .. }), "{refused}");
    }
    let mut more = good.clone();
    more["spec"]["pixels"]["\u{1b}[2J"] = json!(1);
    for bad in ["{}", "", "7", "{\"schema_version\": 5}", &more.to_string()] {
        let refused = refused(bad);
        assert!(matches!(refused, PlanError::Malformed { .. }), "{refused}");
    }
    // The version decides, whatever else is in the plan.
    for version in [1u64, 2, 3, 4, u64::MAX] {
        let refused = refused(&json!({"schema_version": version, "x": 1}).to_string());
        let PlanError::Version { found: number, .. } = refused else {
            panic!("{refused}");
        };
        assert_eq!(number, version);
    }
    assert!(RenderPlan::read(folder.path()).is_err());
}

#[test]
fn a_file_without_end_is_no_plan() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let file = File::create(&path).unwrap();
    file.set_len(1 << 40).unwrap();
    let refused = RenderPlan::read(&path).unwrap_err();
    assert!(refused.to_string().contains("longer than any"), "{refused}");
}
