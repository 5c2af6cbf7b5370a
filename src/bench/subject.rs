//! A scene ready to be measured: both trees, the rays, and the right answers to them.

use super::answer::Answer;
use super::clock;
use super::fingerprint::fingerprint;
use super::kind::Kind;
use super::ours::{KernelContender, OracleContender};
use super::plan::{Heading, Plan};
use super::rays::{RaySet, primary, secondary};
use super::wrong::Wrong;
use crate::bvh::{BuildSettings, Bvh};
use crate::oracle::Forest;
use crate::report::{RaySetRecord, SceneRecord};
use crate::scene::Scene;
use crate::trace::Kernel;
use bumpalo::Bump;
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
        let threads = plan.threads.iter().copied().max().unwrap_or(1);
        let settings = BuildSettings {
            threads,
            ..BuildSettings::default()
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

/// A set of rays and the oracle's answer to it.
pub(super) struct Question<'a> {
    pub(super) set: RaySet<'a>,
    pub(super) truth: Answer,
}

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

    fn record(&self) -> RaySetRecord {
        let rays = self.rays();
        RaySetRecord {
            rays: rays as u64,
            hits: self.truth.hits(rays) as u64,
            checksum: format!("{:08x}", self.truth.checksum(rays)),
        }
    }
}

/// The ray sets that a plan asks for, with the oracle's answers. Sets without rays are left out.
pub(super) fn questions<'a>(
    arena: &'a Bump,
    scene: &Scene,
    trees: &Trees,
    plan: &Plan,
    heading: &Heading,
) -> Result<Vec<Question<'a>>, Wrong> {
    let ask = |set: RaySet<'a>| {
        let oracle = OracleContender {
            scene,
            forest: &trees.forest,
            rays: set.rays(),
        };
        let (question, packets) = (set.kind.question(), set.queue.packets());
        let truth = clock::answer(&oracle, question, packets, plan.all_threads());
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

/// Whether every kernel answers as the oracle does, and the oracle as the suite expects.
pub(super) fn check(
    bvh: &Bvh,
    question: &Question,
    plan: &Plan,
    heading: &Heading,
) -> Result<(), Wrong> {
    let kind = question.kind();
    if let Some(expected) = heading.expected.get(kind.name()) {
        let found = question.record();
        let same = (expected.rays, expected.hits) == (found.rays, found.hits)
            && expected.checksum == found.checksum;
        if !same {
            return Err(Wrong::Suite {
                scene: heading.name.clone(),
                kind: kind.name(),
                expected_hits: expected.hits,
                expected_rays: expected.rays,
                expected_checksum: expected.checksum.clone(),
                hits: found.hits,
                rays: found.rays,
                checksum: found.checksum,
            });
        }
    }
    let kernels = plan.kernels.iter().copied().chain([Kernel::Auto]);
    for kernel in kernels {
        let contender = KernelContender {
            bvh,
            kernel,
            rays: question.set.rays(),
        };
        let answer = clock::answer(
            &contender,
            kind.question(),
            question.packets(),
            plan.all_threads(),
        );
        if let Some(ray) = question.truth.first_difference(&answer, question.rays()) {
            return Err(Wrong::Kernel {
                scene: heading.name.clone(),
                kind: kind.name(),
                kernel: kernel.name().to_owned(),
                ray,
                found: answer.describe(ray),
                expected: question.truth.describe(ray),
            });
        }
    }
    Ok(())
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
