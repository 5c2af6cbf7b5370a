//! The measurement of one scene: the order of its stages.

use super::counters;
use super::entrants::{Entrant, NamedPeerScene, entrants, kernels};
use super::error::BenchError;
use super::frames::Frames;
use super::machine::this_machine;
use super::plan::{BenchPlan, ProgressListener, SceneInfo};
use super::rounds::{Measurement, run_rounds};
use super::workload::{self, BenchTrees, Workload, timed};
use bumpalo::Bump;
use phalanx_report::{
    BenchRecord, CounterRow, Program, RateRow, RunInfo, SCHEMA_VERSION, SceneRecord,
};
use phalanx_scene::Scene;

/// Results of measuring a scene.
pub struct Measured {
    /// The scene.
    pub scene: SceneRecord,
    /// The scene's rates; empty if the plan only counts work.
    pub rows: Vec<RateRow>,
    /// The scene's counted work.
    pub counters: Vec<CounterRow>,
    /// Notes for the reader, such as a peer that could not take part.
    pub notes: Vec<String>,
}

/// The record of all scenes of one run.
pub fn record(program: Program, run: RunInfo, all: Vec<Measured>) -> BenchRecord {
    let mut record = BenchRecord {
        schema_version: SCHEMA_VERSION,
        program,
        machine: this_machine(),
        run,
        scenes: Vec::new(),
        rows: Vec::new(),
        counters: Vec::new(),
    };
    for measured in all {
        record.scenes.push(measured.scene);
        record.rows.extend(measured.rows);
        record.counters.extend(measured.counters);
    }
    record
}

/// Measures a validated scene: trees, rays, the right results, the results of all engines, counts,
/// and only then times.
///
/// # Errors
/// [`BenchError`] if one of our kernels, or the oracle, gives a wrong result: then there are no
/// rates. [`BenchError::Stopped`] if the listener ends the run before each rate has two samples.
pub fn measure(
    scene: &Scene,
    info: &SceneInfo,
    plan: &BenchPlan,
    listener: &mut dyn ProgressListener,
) -> Result<Measured, BenchError> {
    listener.begin_step("building")?;
    let mut trees = BenchTrees::build(scene, plan);
    listener.built(scene, &trees.bvh);
    let (peers, notes) = build_peers(scene, info, plan, &mut trees);
    listener.begin_step("checking")?;
    let arena = Bump::new();
    let workloads = workload::workloads(&arena, &trees, plan, info)?;
    for workload in &workloads {
        listener.begin_step("checking")?;
        workload::check(&trees, workload, plan, info)?;
    }
    let frames = Frames::new(&trees, plan);
    let frame_hits = frames.check(info)?;
    let counters = counters(&trees, &workloads, plan, info);
    let scene_record = workload::scene_record(info, &trees, &workloads, plan.size);
    let mut rows = Vec::new();
    if plan.timed {
        let entrants = |workload| entrants(&trees, &peers, workload, plan);
        let entrants: Vec<Vec<Entrant>> = workloads.iter().map(entrants).collect();
        let mut measurements = measurements(&workloads, &entrants, plan, info);
        measurements.extend(frames.measurements(info, frame_hits));
        listener.begin_step("measuring")?;
        rows = run_rounds(measurements, plan, listener)?;
    }
    Ok(Measured {
        scene: scene_record,
        rows,
        counters,
        notes,
    })
}

/// Builds the peers that can trace the scene; the others go into the notes.
fn build_peers(
    scene: &Scene,
    info: &SceneInfo,
    plan: &BenchPlan,
    trees: &mut BenchTrees,
) -> (Vec<NamedPeerScene>, Vec<String>) {
    let (mut peers, mut notes) = (Vec::new(), Vec::new());
    let settings = plan.build_settings();
    for peer in plan.peers.iter().filter(|_| plan.timed) {
        let (built, seconds) = timed(|| peer.build(scene, &settings));
        match built {
            Ok(peer_scene) => {
                trees.seconds.insert(peer.name().to_owned(), seconds);
                peers.push((peer.name(), peer_scene));
            }
            Err(unsupported) => notes.push(format!("{}: {unsupported}", info.name)),
        }
    }
    (peers, notes)
}

fn counters(
    trees: &BenchTrees,
    workloads: &[Workload],
    plan: &BenchPlan,
    info: &SceneInfo,
) -> Vec<CounterRow> {
    let rows = workloads.iter().flat_map(|workload| {
        let kernels = kernels(plan).into_iter();
        kernels.map(|kernel| counters::count_work(&info.name, &trees.bvh, kernel, workload))
    });
    rows.collect()
}

/// Minimum number of passes of rays in a sample, so that every engine starts alike: the first pass
/// may find the caches full of another engine's tree, or, after a kernel of the same tree, full of
/// its own.
const RAY_PASSES: usize = 2;

/// Measurements of all engines, side by side for each kind and number of threads.
fn measurements<'a>(
    workloads: &'a [Workload],
    entrants: &'a [Vec<Entrant>],
    plan: &BenchPlan,
    info: &SceneInfo,
) -> Vec<Measurement<'a>> {
    let mut measurements = Vec::new();
    for (workload, entrants) in workloads.iter().zip(entrants) {
        for &threads in &plan.threads {
            measurements.extend(entrants.iter().map(|entrant| {
                let row = entrant.row(info, workload, threads);
                Measurement::new(row, RAY_PASSES, entrant.sampler(workload))
            }));
        }
    }
    measurements
}
