//! Who traces a set of rays: our kernels, the oracle, and the peers' modes with what they answer otherwise.

use super::answer::EXACT_SHARE;
use super::clock::{self, Chunks};
use super::ours::{KernelContender, OracleContender};
use super::plan::{Heading, Plan};
use super::subject::{Question, Trees};
use crate::peers::{Contender, PeerScene};
use crate::report::{Estimate, Row};
use phalanx_scene::Scene;
use phalanx_trace::Kernel;

/// One way to trace a set of rays, its answer known.
pub(super) struct Member<'a> {
    engine: &'static str,
    kernel: String,
    pub(super) contender: Box<dyn Contender + 'a>,
    hits: u64,
    difference: Option<f64>,
}

/// A peer's name, and the scene in its form.
pub(super) type Rival = (&'static str, PeerScene);

/// The kernels to be timed, `auto` among them. Work is counted without it: which kernels it is made of depends on the build, and
/// counts must not.
pub(super) fn kernels(plan: &Plan) -> Vec<Kernel> {
    let all = Kernel::ALL.iter().map(|&(_, kernel)| kernel);
    let wanted = |kernel: &Kernel| match kernel {
        Kernel::Auto => plan.timed,
        kernel => plan.kernels.contains(kernel),
    };
    all.filter(wanted).collect()
}

/// Everybody who is to trace a set of rays. Ours have been checked before; peers are asked here.
pub(super) fn lineup<'a>(
    scene: &'a Scene,
    trees: &'a Trees,
    rivals: &'a [Rival],
    question: &'a Question,
    plan: &Plan,
) -> Vec<Member<'a>> {
    let rays = question.set.rays();
    let hits = question.truth.hits(question.rays()) as u64;
    let ours = |engine, kernel: &str, contender| Member {
        engine,
        kernel: kernel.to_owned(),
        contender,
        hits,
        difference: None,
    };
    let oracle = Box::new(OracleContender {
        scene,
        forest: &trees.forest,
        rays,
    });
    let mut members = vec![ours("oracle", "scalar", oracle as Box<dyn Contender>)];
    for kernel in kernels(plan) {
        let contender = Box::new(KernelContender {
            bvh: &trees.bvh,
            kernel,
            rays,
        });
        members.push(ours("phalanx", kernel.name(), contender));
    }
    let (kind, packets) = (question.kind().question(), question.packets());
    for (engine, rival) in rivals {
        for (kernel, contender) in rival.contenders(rays) {
            let all = Chunks::all(packets);
            let answer = clock::answer(&*contender, kind, &all, Plan::all_threads());
            let difference = question
                .truth
                .share_of_differences(&answer, question.rays());
            members.push(Member {
                engine,
                kernel,
                contender,
                hits: answer.hits(question.rays()) as u64,
                difference: Some(difference),
            });
        }
    }
    members
}

impl Member<'_> {
    /// The part of the rays that is timed.
    pub(super) fn chunks(&self, question: &Question) -> Chunks {
        match self.engine {
            "oracle" => question.oracle_timed(),
            _ => question.timed(),
        }
    }

    /// Its row, yet without samples.
    pub(super) fn row(&self, heading: &Heading, question: &Question, threads: usize) -> Row {
        Row {
            hits: self.hits,
            difference: self.difference,
            exact: self.difference.is_none_or(|share| share <= EXACT_SHARE),
            ..row(
                heading,
                question.kind().name(),
                self.engine,
                &self.kernel,
                threads,
            )
        }
    }
}

/// A row without samples.
pub(super) fn row(
    heading: &Heading,
    rays: &str,
    engine: &str,
    kernel: &str,
    threads: usize,
) -> Row {
    Row {
        scene: heading.name.clone(),
        rays: rays.to_owned(),
        engine: engine.to_owned(),
        kernel: kernel.to_owned(),
        threads: threads as u32,
        mrays_per_s: Estimate::default(),
        rays_timed: 0,
        hits: 0,
        difference: None,
        exact: true,
        same_as: None,
        samples: Vec::new(),
    }
}
