//! The rays that `phalanx bench` measures, and its reaction to a wrong answer.

use glam::Vec3;
use phalanx::bench::Answer;
use phalanx::bench::{
    BenchError, BenchPlan, OracleEngine, ProgressListener, RayKind, RaySet, SceneInfo, measure,
    primary, secondary,
};
use phalanx::bvh::Quality;
use phalanx::lanes::{LANES, LaneMask, NATIVE};
use phalanx::oracle::TwoLevelBvh;
use phalanx::packet::NO_PRIM;
use phalanx::peers::BenchEngine;
use phalanx::report::RaySetRecord;
use phalanx::scene::Scene;
use phalanx::standard;
use phalanx::trace::Kernel;
use std::collections::BTreeMap;

/// Directions have unit length, and angles are equal, up to the rounding of a few f32 operations.
const ROUNDING: f32 = 1e-5;

fn scene(name: &str) -> Scene {
    standard::scene(standard::parse_spec(name).unwrap(), 0).unwrap()
}

fn answer(scene: &Scene, set: &RaySet) -> Answer {
    let bvh = TwoLevelBvh::build(scene);
    let oracle = OracleEngine {
        scene,
        bvh: &bvh,
        rays: set.rays(),
    };
    let mut answer = Answer::with_capacity(set.kind.query(), set.queue.packets());
    match &mut answer {
        Answer::Closest(hits) => oracle.thread().closest(0..set.queue.packets(), hits),
        Answer::Occluded(blocked) => oracle.thread().occluded(0..set.queue.packets(), blocked),
    }
    answer
}

fn rays(set: &RaySet) -> Vec<(Vec3, Vec3)> {
    let all = (0..set.queue.packets()).flat_map(|packet| {
        set.queue
            .active(packet)
            .lanes()
            .map(move |lane| (packet, lane))
    });
    all.map(|(packet, lane)| {
        let (org, dir) = set.queue.ray(packet, lane);
        (org.into(), dir.into())
    })
    .collect()
}

#[test]
fn secondary_rays_start_where_the_camera_sees_something() {
    let scene = scene("standard:balls:2");
    let arena = bumpalo::Bump::new();
    let first = primary(&arena, &scene, [64, 48]).unwrap();
    assert_eq!(first.queue.len(), 64 * 48);
    let expected = answer(&scene, &first);
    let hits = expected.hits(first.queue.len());
    let Answer::Closest(packets) = &expected else {
        panic!()
    };
    let camera = rays(&first);
    let points: Vec<(Vec3, Vec3)> = (0..camera.len())
        .filter(|ray| packets[ray / LANES].prim_id.lane(ray % LANES) != NO_PRIM)
        .map(|ray| {
            let (org, dir) = camera[ray];
            (org + dir * packets[ray / LANES].t.lane(ray % LANES), dir)
        })
        .collect();
    assert_eq!(points.len(), hits);
    let size = (scene.bounds().hi - scene.bounds().lo).length();
    for kind in [RayKind::Reflection, RayKind::Diffuse, RayKind::Ao] {
        let set = secondary(&arena, &scene, kind, &first, &expected);
        let all = rays(&set);
        assert_eq!(all.len(), hits, "{kind:?}");
        for ((org, dir), (point, _)) in all.iter().zip(&points) {
            assert!((*org - *point).length() < 1e-4 * size, "{kind:?}");
            let length = if kind == RayKind::Ao { 0.05 * size } else { 1.0 };
            assert!((dir.length() / length - 1.0).abs() < ROUNDING, "{kind:?}");
        }
    }
    // About half of the hemisphere's energy is within 45 degrees of the normal; the plane below
    // looks up.
    let diffuse = rays(&secondary(
        &arena,
        &scene,
        RayKind::Diffuse,
        &first,
        &expected,
    ));
    let steep = diffuse
        .iter()
        .filter(|(_, dir)| dir.z > 0.5f32.sqrt())
        .count();
    assert!(
        steep > hits / 5 && steep < hits * 4 / 5,
        "{steep} of {hits}"
    );
}

#[test]
fn shadow_rays_end_at_the_light() {
    let scene = scene("standard:balls:2");
    let arena = bumpalo::Bump::new();
    let first = primary(&arena, &scene, [64, 48]).unwrap();
    let expected = answer(&scene, &first);
    let set = secondary(&arena, &scene, RayKind::Shadow, &first, &expected);
    assert_eq!(set.tmax, 1.0);
    let light = scene.lights.position.get(0);
    assert!(!set.queue.is_empty());
    for (org, dir) in rays(&set) {
        assert!((org + dir - light).length() < 1e-3 * light.length());
    }
}

struct Nobody;

impl ProgressListener for Nobody {
    fn begin_step(&mut self, _: &str) -> Result<(), BenchError> {
        Ok(())
    }
    fn progress(&mut self, _: f64) -> Result<(), BenchError> {
        Ok(())
    }
}

fn plan(timed: bool) -> BenchPlan<'static> {
    BenchPlan {
        kinds: RayKind::ALL.to_vec(),
        frames: true,
        kernels: Kernel::ALL.map(|(_, kernel)| kernel).to_vec(),
        quality: Quality::default(),
        threads: vec![1],
        size: [40, 32],
        repeat: 1,
        min_time: 0.0,
        pin: false,
        peers: &[],
        timed,
    }
}

/// Sets are reproducible; and nothing is measured if one is not as expected.
#[test]
fn an_answer_that_the_suite_does_not_expect_gives_no_rates() {
    let scene = scene("standard:tree:4");
    let run = |expected| {
        let heading = SceneInfo {
            name: "tree".to_owned(),
            expected,
            ..SceneInfo::default()
        };
        measure(&scene, &heading, &plan(true), &mut Nobody)
    };
    let measured = run(BTreeMap::new()).unwrap();
    assert!(!measured.rows.is_empty());
    let expected = measured.scene.rays;
    assert!(run(expected.clone()).is_ok());
    for kind in ["primary", "shadow", "diffuse"] {
        for break_it in [
            |e: &mut RaySetRecord| e.hits += 1,
            |e: &mut RaySetRecord| e.checksum = "00000000".to_owned(),
        ] {
            let mut wrong = expected.clone();
            break_it(wrong.get_mut(kind).unwrap());
            match run(wrong) {
                Err(BenchError::Suite { kind: measured, .. }) => assert_eq!(measured, kind),
                _ => panic!("{kind}: rates for a wrong answer"),
            }
        }
    }
}

/// Counts that must not depend on the kernel's width.
#[test]
fn work_adds_up() {
    let scene = scene("standard:balls:3");
    let heading = SceneInfo {
        name: "balls".to_owned(),
        ..SceneInfo::default()
    };
    let measured = measure(&scene, &heading, &plan(false), &mut Nobody).unwrap();
    assert!(measured.rows.is_empty());
    for row in &measured.counters {
        let work = row.work;
        assert_eq!(work.active_lanes, row.ray_count, "{row:?}");
        assert_eq!(work.packets, row.ray_count.div_ceil(8), "{row:?}");
        let each = work.box_tests as f64 / work.node_visits as f64;
        match row.kernel.as_str() {
            // The last packet of an odd number is traced eight wide.
            "packet16" => assert!(each > 30.0 && each <= 32.0, "{row:?}"),
            "packet8" => assert_eq!(each, 16.0, "{row:?}"),
            "single" => assert_eq!(each, NATIVE as f64, "{row:?}"),
            // Those of a node, and of each child that is met as many as there are cells at least.
            _ => assert!(each >= 8.0, "{row:?}"),
        }
        assert!(
            work.leaf_visits > 0 && work.prim_tests >= work.leaf_visits,
            "{row:?}"
        );
        assert!(work.bytes > 64 * work.node_visits, "{row:?}");
    }
    let rows_of = |kernel: &str| {
        let mut rows = measured.counters.iter().filter(|row| row.kernel == kernel);
        rows.find(|row| row.rays == "primary").unwrap().work
    };
    // Sixteen lanes visit the nodes of both eights once.
    let (eight, sixteen) = (rows_of("packet8"), rows_of("packet16"));
    assert!(sixteen.node_visits < eight.node_visits);
    assert!(2 * sixteen.node_visits >= eight.node_visits);
}
