//! Tests of plans for sequences.

use super::super::planned_frames::PlannedFrames;
use super::super::sequence_plan::{PlannedCamera, ShardBy};
use super::tests::plan;
use super::*;
use crate::spec::ExposureSpec;
use phalanx_scene::{CameraKey, CameraPath, Scene, View};
use serde_json::json;

fn sequence(frames: [u32; 2], shard_by: ShardBy, path: &CameraPath) -> SequencePlan {
    SequencePlan {
        frames,
        shard_by,
        view: Scene::default().view,
        camera: PlannedCamera::new(path, "/way".to_owned()),
    }
}

fn with_sequence(plan: RenderPlan, sequence: SequencePlan) -> RenderPlan {
    RenderPlan {
        sequence: Some(sequence),
        ..plan
    }
}

fn turntable(shards: u32, frames: [u32; 2], shard_by: ShardBy) -> RenderPlan {
    let path = CameraPath::Turntable { frames: 24 };
    with_sequence(plan(64, 48, shards), sequence(frames, shard_by, &path))
}

fn keyframes() -> CameraPath {
    let key = |frame, x| {
        let mut view = Scene::default().view;
        view.eye.x += x;
        CameraKey { frame, view }
    };
    CameraPath::Keys(vec![key(3, 0.1), key(9, 0.7)])
}

#[test]
fn every_frame_is_of_one_shard_and_shares_are_alike() {
    for (shards, frames) in [
        (5, [3, 26]),
        (1, [0, 0]),
        (24, [0, 23]),
        (7, [9_999_990, 10_000_000]),
    ] {
        let plan = turntable(shards, frames, ShardBy::Frame);
        plan.check().unwrap();
        let planned = PlannedFrames::of(&plan);
        let mut all = Vec::new();
        let mut counts = Vec::new();
        for shard in 0..shards {
            let share: Vec<u32> = planned.of_shard(shard).collect();
            assert!(
                share
                    .iter()
                    .all(|frame| (frame - frames[0]) % shards == shard)
            );
            counts.push(share.len());
            all.extend(share);
        }
        all.sort_unstable();
        assert!(all.into_iter().eq(planned.all()), "{shards}");
        assert!(counts.iter().max().unwrap() - counts.iter().min().unwrap() <= 1);
    }
    // With `ShardBy::Tile` each shard renders its tiles of all frames.
    let plan = turntable(30, [3, 5], ShardBy::Tile);
    plan.check().unwrap();
    let planned = PlannedFrames::of(&plan);
    assert_eq!(planned.of_shard(29).collect::<Vec<_>>(), [3, 4, 5]);
}

#[test]
fn a_plan_that_is_read_again_has_the_views_that_were_planned() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.json");
    for camera in [CameraPath::Turntable { frames: 7 }, keyframes()] {
        let made = with_sequence(plan(64, 48, 2), sequence([0, 12], ShardBy::Frame, &camera));
        std::fs::write(&path, serde_json::to_vec_pretty(&made).unwrap()).unwrap();
        let read = RenderPlan::read(&path).unwrap();
        assert_eq!(read, made);
        let planned = PlannedFrames::of(&read);
        let mut identities = Vec::new();
        for frame in planned.all() {
            let view: View = camera.view(frame, &Scene::default().view);
            assert_eq!(planned.view(frame).unwrap(), Some(view));
            assert_eq!(planned.key(frame).unwrap(), made.key().with_view(view));
            identities.push(planned.identity(frame).unwrap());
        }
        // An identity depends on how samples are encoded, and not on the file's path.
        let mut other = made.clone();
        other.output = "in/b.png".into();
        let identity = |plan: &RenderPlan, frame| PlannedFrames::of(plan).identity(frame).unwrap();
        assert_eq!(identity(&other, 3), identities[3]);
        other.spec.encoding.exposure = Some(ExposureSpec::Stops(0.25));
        assert_ne!(identity(&other, 3), identities[3]);
        let mut other = made.clone();
        other.output = "b.pfm".into();
        assert_ne!(identity(&other, 3), identities[3]);
    }
}

#[test]
fn a_path_is_told_from_others_wherever_it_comes_from() {
    let checksum = |path: &CameraPath, file: &str| {
        let mut sequence = sequence([0, 12], ShardBy::Frame, path);
        sequence.camera = PlannedCamera::new(path, file.to_owned());
        let plan = with_sequence(plan(64, 48, 2), sequence);
        PlannedFrames::of(&plan).path_checksum()
    };
    let keys = checksum(&keyframes(), "/a");
    assert_eq!(keys, checksum(&keyframes(), "/b"));
    let turn = |frames| checksum(&CameraPath::Turntable { frames }, "");
    assert!(turn(7) != turn(8) && turn(7) != keys);
}

#[test]
fn files_of_a_shard_stand_beside_the_plan() {
    let plan = turntable(20, [0, 119], ShardBy::Frame);
    let planned = PlannedFrames::of(&plan);
    let path = Path::new("jobs/a.json");
    assert_eq!(
        planned.list_file(path, 3).unwrap(),
        Path::new("jobs/a.shard-03.frames")
    );
    let tiles = planned.tile_file(path, 3, 7).unwrap();
    assert_eq!(tiles, Path::new("jobs/a.shard-03.frame-0007.tiles"));
    let name = planned.name(Path::new("x/b-###.png"), 7);
    assert_eq!(name, Path::new("x/b-007.png"));
}

#[test]
fn a_sequence_that_nobody_planned_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.json");
    let made = with_sequence(
        plan(64, 48, 3),
        sequence([0, 12], ShardBy::Frame, &keyframes()),
    );
    let good = serde_json::to_value(made).unwrap();
    let refused = |bad: &serde_json::Value| {
        std::fs::write(&path, bad.to_string()).unwrap();
        let refused = RenderPlan::read(&path).unwrap_err();
        let message = refused.to_string();
        assert!(!message.contains(char::is_control), "{message:?}");
        refused
    };
    let keys = "sequence.camera.keyframes";
    for (pointer, value, name) in [
        ("/sequence/frames", json!([3, 2]), "sequence.frames"),
        ("/sequence/frames", json!([0, u32::MAX]), "sequence.frames"),
        ("/sequence/frames", json!([5, 6]), "shards"),
        ("/sequence/view/eye", json!([1e39, 0, 0]), ""),
        ("/sequence/view/up", json!([0, 0, 0]), "sequence.view"),
        ("/sequence/view/fovy", json!(180), "sequence.view"),
        ("/sequence/view/ortho", json!(-1), "sequence.view"),
        ("/sequence/camera/keyframes/keys", json!([]), keys),
        ("/sequence/camera/keyframes/keys/1/frame", json!(3), keys),
        (
            "/sequence/camera/keyframes/keys/1/view/up",
            json!([0, 0, 0]),
            keys,
        ),
        ("/sequence/camera/keyframes/file", json!("a\u{1b}[2J"), keys),
        (
            "/sequence/camera",
            json!({"turntable": {"frames": 0}}),
            "sequence.camera.turntable",
        ),
        ("/sequence/camera", json!({"turntable": {}}), ""),
        ("/sequence/shard_by", json!("pixel"), ""),
    ] {
        let mut bad = good.clone();
        match (bad.pointer_mut(pointer), pointer.rsplit_once('/')) {
            (Some(field), _) => *field = value,
            (None, Some((parent, field))) => bad.pointer_mut(parent).unwrap()[field] = value,
            (None, None) => unreachable!(),
        }
        match refused(&bad) {
            PlanError::Field { error, .. } => assert_eq!(error.field, name, "{pointer}"),
            PlanError::Malformed { reason, .. } => assert_eq!(name, "", "{pointer}: {reason}"),
            other => panic!("{pointer}: {other}"),
        }
    }
}

#[test]
fn a_picture_has_no_sequence_in_its_plan() {
    let text = serde_json::to_value(plan(64, 48, 3)).unwrap();
    assert!(text.get("sequence").is_none());
}
