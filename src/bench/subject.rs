//! A scene ready to be measured: both trees, the rays, and the right answers to them.

use super::answer::Answer;
use super::clock::{self, CHUNK, Chunks};
use super::fingerprint::fingerprint;
use super::kind::Kind;
use super::ours::{KernelContender, OracleContender};
use super::plan::{Heading, Plan};
use super::rays::{RaySet, primary, secondary};
use super::wrong::Wrong;
use crate::peers::Contender;
use crate::report::{RaySetRecord, SceneRecord};
use bumpalo::Bump;
use phalanx_oracle::Forest;
use phalanx_scene::Scene;
use phalanx_trace::Kernel;
use phalanx_trace::bvh::{BuildSettings, Bvh};
use std::collections::BTreeMap;
use std::time::Instant;

/// Both trees of a scene, and the seconds it took to build them.
pub(super) struct Trees {
    pub(super) bvh: Bvh,
    pub(super) forest: Forest,
    pub(super) seconds: BTreeMap<String, f64>,
}

impl Trees {
    pub(super) fn build(scene: &Scene, plan: &Plan) -> Trees {
        let settings = BuildSettings {
            quality: plan.quality,
            threads: plan.most_threads(),
        };
        let (bvh, ours) = timed(|| Bvh::build_with(scene, &settings));
        let (forest, theirs) = timed(|| Forest::build(scene));
        let seconds = [("phalanx", ours), ("oracle", theirs)];
        let seconds = seconds.map(|(engine, s)| (engine.to_owned(), s));
        Trees {
            bvh,
            forest,
            seconds: seconds.into(),
        }
    }
}

/// What `make` makes, and the seconds it takes.
pub(super) fn timed<T>(make: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let made = make();
    (made, start.elapsed().as_secs_f64())
}

/// A set of rays and the right answer to it.
pub(super) struct Question<'a> {
    pub(super) set: RaySet<'a>,
    pub(super) truth: Answer,
}

/// Rays of a set that are timed, about. The time that a fifth of the usual 2^18 takes less is spent in more rounds,
/// which is what makes a rate on a shared machine the same twice; it changes the rate itself by 4 % at most in most sets
/// (perf/notes/noise.md). The same rays in every run.
const TIMED_RAYS: usize = 1 << 16;

/// And of those that the oracle is timed on: it is many times slower than the kernels, and would take most of a run. Its
/// chunks are small ones, so that they take no longer than the kernels'.
const ORACLE_TIMED_RAYS: usize = 1 << 14;
const ORACLE_CHUNK: usize = 16;

/// Rays that the oracle answers where a kernel's answer stands for its own.
const ORACLE_CHECKED_RAYS: usize = 1 << 15;

impl Question<'_> {
    pub(super) fn kind(&self) -> Kind {
        self.set.kind
    }

    pub(super) fn rays(&self) -> usize {
        self.set.queue.len()
    }

    pub(super) fn packets(&self) -> usize {
        self.set.queue.packets()
    }

    /// The part of the rays that everybody but the oracle is timed on.
    pub(super) fn timed(&self) -> Chunks {
        Chunks::some(self.packets(), CHUNK, TIMED_RAYS)
    }

    /// The part that the oracle is timed on.
    pub(super) fn oracle_timed(&self) -> Chunks {
        Chunks::some(self.packets(), ORACLE_CHUNK, ORACLE_TIMED_RAYS)
    }

    fn record(&self) -> RaySetRecord {
        record(&self.truth, self.rays())
    }
}

/// The ray sets that a plan asks for, with the right answers. Sets without rays are left out.
pub(super) fn questions<'a>(
    arena: &'a Bump,
    scene: &Scene,
    trees: &Trees,
    plan: &Plan,
    heading: &Heading,
) -> Result<Vec<Question<'a>>, Wrong> {
    let ask = |set: RaySet<'a>| {
        let truth = truth(scene, trees, heading, &set);
        Question { set, truth }
    };
    let first = primary(arena, scene, plan.size).map_err(|source| Wrong::View {
        scene: heading.name.clone(),
        source,
    })?;
    let first = ask(first);
    let mut questions = Vec::new();
    for &kind in plan.kinds.iter().filter(|kind| **kind != Kind::Primary) {
        questions.push(ask(secondary(arena, scene, kind, &first.set, &first.truth)));
    }
    if plan.kinds.contains(&Kind::Primary) {
        questions.insert(0, first);
    }
    questions.retain(|question| question.rays() > 0);
    Ok(questions)
}

/// The right answer to a set of rays: the oracle's, or, to save its time, a kernel's that is the expected one to the bit.
fn truth(scene: &Scene, trees: &Trees, heading: &Heading, set: &RaySet) -> Answer {
    let (kind, rays, threads) = (set.kind, set.queue.len(), Plan::all_threads());
    let all = Chunks::all(set.queue.packets());
    if let Some(expected) = heading.expected.get(kind.name()) {
        let contender = KernelContender {
            bvh: &trees.bvh,
            kernel: Kernel::Auto,
            rays: set.rays(),
        };
        let answer = clock::answer(&contender, kind.question(), &all, threads);
        if *expected == record(&answer, rays) {
            return answer;
        }
    }
    let oracle = OracleContender {
        scene,
        forest: &trees.forest,
        rays: set.rays(),
    };
    clock::answer(&oracle, kind.question(), &all, threads)
}

fn record(answer: &Answer, rays: usize) -> RaySetRecord {
    RaySetRecord {
        rays: rays as u64,
        hits: answer.hits(rays) as u64,
        checksum: format!("{:08x}", answer.checksum(rays)),
    }
}

/// Whether every kernel gives the right answer, and the oracle where it is timed; and whether that is what the suite
/// expects.
pub(super) fn check(
    scene: &Scene,
    trees: &Trees,
    question: &Question,
    plan: &Plan,
    heading: &Heading,
) -> Result<(), Wrong> {
    let rays = question.set.rays();
    let all = || Chunks::all(question.packets());
    for kernel in plan.kernels.iter().copied().chain([Kernel::Auto]) {
        let bvh = &trees.bvh;
        let contender = KernelContender { bvh, kernel, rays };
        check_one(&contender, kernel.name(), all(), question, heading)?;
    }
    let forest = &trees.forest;
    let oracle = OracleContender {
        scene,
        forest,
        rays,
    };
    let chunks = Chunks::some(question.packets(), CHUNK, ORACLE_CHECKED_RAYS);
    check_one(&oracle, "oracle", chunks, question, heading)?;
    check_expected(question, heading)
}

fn check_one(
    contender: &dyn Contender,
    name: &str,
    chunks: Chunks,
    question: &Question,
    heading: &Heading,
) -> Result<(), Wrong> {
    let kind = question.kind();
    let answer = clock::answer(contender, kind.question(), &chunks, Plan::all_threads());
    let numbers = chunks.ray_numbers(question.rays());
    match question.truth.first_difference(&answer, numbers) {
        None => Ok(()),
        Some(ray) => Err(Wrong::Kernel {
            scene: heading.name.clone(),
            kind: kind.name(),
            kernel: name.to_owned(),
            ray,
            found: answer.describe(ray),
            expected: question.truth.describe(ray),
        }),
    }
}

fn check_expected(question: &Question, heading: &Heading) -> Result<(), Wrong> {
    let kind = question.kind().name();
    let (found, expected) = (question.record(), heading.expected.get(kind));
    match expected {
        Some(expected) if *expected != found => Err(Wrong::Suite {
            scene: heading.name.clone(),
            kind,
            expected: expected.to_string(),
            found: found.to_string(),
        }),
        _ => Ok(()),
    }
}

/// The scene's part of the record.
pub(super) fn scene_record(
    scene: &Scene,
    heading: &Heading,
    trees: &Trees,
    questions: &[Question],
    size: [u32; 2],
) -> SceneRecord {
    let kinds = [
        ("spheres", scene.spheres.len()),
        ("ellipsoids", scene.ellipsoids.len()),
        ("triangles", scene.triangles.len()),
        ("cones", scene.cones.len()),
        ("instances", scene.instances.len()),
    ];
    let kinds = kinds.into_iter().filter(|(_, count)| *count > 0);
    let bvh = &trees.bvh;
    SceneRecord {
        name: heading.name.clone(),
        family: heading.family.clone(),
        step: heading.step.clone(),
        hash: format!("{:08x}", fingerprint(scene)),
        origin: scene.is_moved().then_some(scene.origin),
        primitives: kinds
            .map(|(kind, count)| (kind.to_owned(), count as u64))
            .collect(),
        primitive_count: scene.prim_count() as u64,
        size,
        load_seconds: heading.load_seconds,
        build_seconds: trees.seconds.clone(),
        tree_bytes: (bvh.node_bytes() + bvh.prim_bytes()) as u64,
        rays: questions
            .iter()
            .map(|q| (q.kind().name().to_owned(), q.record()))
            .collect(),
    }
}
