//! A scene, ready for measurement: both trees, the rays, and their right results.

use super::answer::Answer;
use super::engines::{KernelEngine, OneRayEngine, OracleEngine};
use super::error::BenchError;
use super::fingerprint::fingerprint;
use super::plan::{BenchPlan, SceneInfo};
use super::rays::{RaySet, primary, secondary};
use super::timer::{self, CHUNK_PACKETS, Chunks};
use crate::peers::{BenchEngine, ONE, RaySetRef};
use bumpalo::Bump;
use phalanx_oracle::TwoLevelBvh;
use phalanx_report::{ORACLE, PHALANX, RayKind, RaySetRecord, SceneRecord};
use phalanx_scene::{PrimKind, Scene};
use phalanx_trace::Kernel;
use phalanx_trace::bvh::Bvh;
use std::collections::BTreeMap;
use std::time::Instant;

/// A scene with both trees, and their build times in seconds.
pub(super) struct BenchTrees<'a> {
    pub(super) scene: &'a Scene,
    pub(super) bvh: Bvh,
    pub(super) oracle_bvh: TwoLevelBvh,
    pub(super) seconds: BTreeMap<String, f64>,
}

impl<'a> BenchTrees<'a> {
    pub(super) fn build(scene: &'a Scene, plan: &BenchPlan) -> BenchTrees<'a> {
        let settings = plan.build_settings();
        let (bvh, bvh_seconds) = timed(|| Bvh::build_with(scene, &settings));
        let (oracle_bvh, oracle_seconds) = timed(|| TwoLevelBvh::build(scene));
        let seconds = [(PHALANX, bvh_seconds), (ORACLE, oracle_seconds)];
        let seconds = seconds.map(|(engine, s)| (engine.to_owned(), s));
        BenchTrees {
            scene,
            bvh,
            oracle_bvh,
            seconds: seconds.into(),
        }
    }

    /// One of our kernels on some rays.
    pub(super) fn kernel<'r>(&'r self, kernel: Kernel, rays: RaySetRef<'r>) -> KernelEngine<'r> {
        let bvh = &self.bvh;
        KernelEngine { bvh, kernel, rays }
    }

    /// One ray of a set a call.
    pub(super) fn one(&self, rays: RaySetRef) -> OneRayEngine<'_> {
        OneRayEngine::new(&self.bvh, rays)
    }

    /// The oracle on some rays.
    pub(super) fn oracle<'r>(&'r self, rays: RaySetRef<'r>) -> OracleEngine<'r> {
        let (scene, bvh) = (self.scene, &self.oracle_bvh);
        OracleEngine { scene, bvh, rays }
    }
}

/// The result of `make`, and the seconds it takes.
pub(super) fn timed<T>(make: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let made = make();
    (made, start.elapsed().as_secs_f64())
}

/// A set of rays and its right results.
pub(super) struct Workload<'a> {
    pub(super) set: RaySet<'a>,
    pub(super) expected: Answer,
}

/// Approximate number of rays of a set that are timed. A fifth of the usual 2^18 takes less time,
/// which is spent on more rounds; that makes a rate on a shared machine reproducible. Timing a part
/// only changes the rate itself by 4 % at most in most sets (perf/notes/noise.md). The rays are the
/// same in every run.
const TIMED_RAYS: usize = 1 << 16;

/// Number of those rays that the oracle is timed on. It is many times slower than the kernels, and
/// would take most of a run. Its chunks are smaller, so that they take no longer than the kernels'.
const ORACLE_TIMED_RAYS: usize = 1 << 14;
const ORACLE_CHUNK: usize = 16;

/// Rays that the oracle traces if a kernel's results replace its own.
const ORACLE_CHECKED_RAYS: usize = 1 << 15;

impl Workload<'_> {
    pub(super) fn kind(&self) -> RayKind {
        self.set.kind
    }

    pub(super) fn rays(&self) -> usize {
        self.set.queue.len()
    }

    pub(super) fn packets(&self) -> usize {
        self.set.queue.packets()
    }

    /// The part of the rays that all engines but the oracle are timed on.
    pub(super) fn timed(&self) -> Chunks {
        Chunks::some(self.packets(), CHUNK_PACKETS, TIMED_RAYS)
    }

    /// The part of the rays that the oracle is timed on.
    pub(super) fn oracle_timed(&self) -> Chunks {
        Chunks::some(self.packets(), ORACLE_CHUNK, ORACLE_TIMED_RAYS)
    }

    fn record(&self) -> RaySetRecord {
        record(&self.expected, self.rays())
    }
}

/// The ray sets of a plan, with the right results. Sets without rays are omitted.
pub(super) fn workloads<'a>(
    arena: &'a Bump,
    trees: &BenchTrees,
    plan: &BenchPlan,
    info: &SceneInfo,
) -> Result<Vec<Workload<'a>>, BenchError> {
    let workload = |set: RaySet<'a>| {
        let expected = compute_expected(trees, info, &set);
        Workload { set, expected }
    };
    let scene = trees.scene;
    let first = primary(arena, scene, plan.size).map_err(|source| BenchError::View {
        scene: info.name.clone(),
        source,
    })?;
    let first = workload(first);
    let secondary = |&kind| secondary(arena, scene, kind, &first.set, &first.expected);
    let kinds = plan.kinds.iter().filter(|kind| **kind != RayKind::Primary);
    let mut workloads: Vec<Workload> = kinds.map(secondary).map(workload).collect();
    if plan.kinds.contains(&RayKind::Primary) {
        workloads.insert(0, first);
    }
    workloads.retain(|workload| workload.rays() > 0);
    Ok(workloads)
}

/// The right results of a set of rays: the oracle's, or, to save its time, those of a kernel that
/// match the expected ones bit for bit.
fn compute_expected(trees: &BenchTrees, info: &SceneInfo, set: &RaySet) -> Answer {
    let all = Chunks::all(set.queue.packets());
    let trace = |engine: &dyn BenchEngine| {
        timer::answer(engine, set.kind.query(), &all, BenchPlan::all_threads())
    };
    if let Some(expected) = info.expected.get(set.kind.name()) {
        let answer = trace(&trees.kernel(Kernel::Auto, set.rays()));
        if *expected == record(&answer, set.queue.len()) {
            return answer;
        }
    }
    trace(&trees.oracle(set.rays()))
}

fn record(answer: &Answer, rays: usize) -> RaySetRecord {
    RaySetRecord {
        rays: rays as u64,
        hits: answer.hits(rays) as u64,
        checksum: format!("{:08x}", answer.checksum(rays)),
    }
}

/// Checks that every kernel gives the right results, and so does the oracle if it is timed, and
/// that they are the suite's results.
pub(super) fn check(
    trees: &BenchTrees,
    workload: &Workload,
    plan: &BenchPlan,
    info: &SceneInfo,
) -> Result<(), BenchError> {
    let rays = workload.set.rays();
    for kernel in plan.kernels.iter().copied().chain([Kernel::Auto]) {
        let all = Chunks::all(workload.packets());
        check_one(
            &trees.kernel(kernel, rays),
            kernel.name(),
            all,
            workload,
            info,
        )?;
    }
    if plan.timed {
        let all = Chunks::all(workload.packets());
        check_one(&trees.one(rays), ONE, all, workload, info)?;
    }
    let chunks = Chunks::some(workload.packets(), CHUNK_PACKETS, ORACLE_CHECKED_RAYS);
    check_one(&trees.oracle(rays), ORACLE, chunks, workload, info)?;
    check_expected(workload, info)
}

fn check_one(
    engine: &dyn BenchEngine,
    name: &str,
    chunks: Chunks,
    workload: &Workload,
    info: &SceneInfo,
) -> Result<(), BenchError> {
    let kind = workload.kind();
    let answer = timer::answer(engine, kind.query(), &chunks, BenchPlan::all_threads());
    let numbers = chunks.ray_numbers(workload.rays());
    match workload.expected.first_difference(&answer, numbers) {
        None => Ok(()),
        Some(ray) => Err(BenchError::Kernel {
            scene: info.name.clone(),
            kind: kind.name(),
            kernel: name.to_owned(),
            ray,
            found: answer.describe(ray),
            expected: workload.expected.describe(ray),
        }),
    }
}

fn check_expected(workload: &Workload, info: &SceneInfo) -> Result<(), BenchError> {
    let kind = workload.kind().name();
    let (answer, expected) = (workload.record(), info.expected.get(kind));
    match expected {
        Some(expected) if *expected != answer => Err(BenchError::Suite {
            scene: info.name.clone(),
            kind,
            expected: expected.to_string(),
            found: answer.to_string(),
        }),
        _ => Ok(()),
    }
}

/// The scene's part of the record.
pub(super) fn scene_record(
    info: &SceneInfo,
    trees: &BenchTrees,
    workloads: &[Workload],
    size: [u32; 2],
) -> SceneRecord {
    let (scene, bvh) = (trees.scene, &trees.bvh);
    let kinds = PrimKind::ALL.map(|kind| (kind.name(), scene.count(kind)));
    let kinds = kinds
        .into_iter()
        .chain([("instance", scene.instances.len())]);
    let kinds = kinds.filter(|(_, count)| *count > 0);
    SceneRecord {
        name: info.name.clone(),
        family: info.family.clone(),
        step: info.step.clone(),
        hash: format!("{:08x}", fingerprint(scene)),
        origin: scene.is_moved().then_some(scene.origin),
        primitives: kinds
            .map(|(kind, count)| (format!("{kind}s"), count as u64))
            .collect(),
        primitive_count: scene.prim_count() as u64,
        size,
        load_seconds: info.load_seconds,
        build_seconds: trees.seconds.clone(),
        tree_bytes: (bvh.node_bytes() + bvh.prim_bytes()) as u64,
        rays: workloads
            .iter()
            .map(|q| (q.kind().name().to_owned(), q.record()))
            .collect(),
    }
}
