//! Entrants that trace a set of rays: our kernels, the oracle, and the peers' modes with the share
//! of their results that differ.

use super::answer::MAX_DIFFERING_SHARE;
use super::engines::{KernelEngine, OracleEngine};
use super::plan::{BenchPlan, SceneInfo};
use super::timer::{self, Chunks};
use super::workload::{BenchTrees, Workload};
use crate::peers::{BenchEngine, PeerScene};
use crate::report::{Estimate, RateRow};
use phalanx_scene::Scene;
use phalanx_trace::Kernel;

/// One engine and mode on a set of rays, with its results compared.
pub(super) struct Entrant<'a> {
    engine: &'static str,
    kernel: String,
    pub(super) engine_impl: Box<dyn BenchEngine + 'a>,
    hits: u64,
    difference: Option<f64>,
}

/// A peer's name, and the scene in its form.
pub(super) type NamedPeerScene = (&'static str, PeerScene);

/// The kernels to be timed, `auto` among them. Work is counted without `auto`: the kernels that it
/// selects depend on the build, and counts must not.
pub(super) fn kernels(plan: &BenchPlan) -> Vec<Kernel> {
    let all = Kernel::ALL.iter().map(|&(_, kernel)| kernel);
    let wanted = |kernel: &Kernel| match kernel {
        Kernel::Auto => plan.timed,
        kernel => plan.kernels.contains(kernel),
    };
    all.filter(wanted).collect()
}

/// All entrants for a set of rays. Our kernels have been checked before; peers are compared here.
pub(super) fn entrants<'a>(
    scene: &'a Scene,
    trees: &'a BenchTrees,
    peers: &'a [NamedPeerScene],
    workload: &'a Workload,
    plan: &BenchPlan,
) -> Vec<Entrant<'a>> {
    let rays = workload.set.rays();
    let hits = workload.expected.hits(workload.rays()) as u64;
    let ours = |engine, kernel: &str, contender| Entrant {
        engine,
        kernel: kernel.to_owned(),
        engine_impl: contender,
        hits,
        difference: None,
    };
    let oracle = Box::new(OracleEngine {
        scene,
        forest: &trees.forest,
        rays,
    });
    let mut entrants = vec![ours("oracle", "scalar", oracle as Box<dyn BenchEngine>)];
    for kernel in kernels(plan) {
        let contender = Box::new(KernelEngine {
            bvh: &trees.bvh,
            kernel,
            rays,
        });
        entrants.push(ours("phalanx", kernel.name(), contender));
    }
    let (kind, packets) = (workload.kind().query(), workload.packets());
    for (engine, rival) in peers {
        for (kernel, contender) in rival.engines(rays) {
            let all = Chunks::all(packets);
            let answer = timer::answer(&*contender, kind, &all, BenchPlan::all_threads());
            let difference = workload
                .expected
                .share_of_differences(&answer, workload.rays());
            entrants.push(Entrant {
                engine,
                kernel,
                engine_impl: contender,
                hits: answer.hits(workload.rays()) as u64,
                difference: Some(difference),
            });
        }
    }
    entrants
}

impl Entrant<'_> {
    /// The part of the rays that is timed.
    pub(super) fn chunks(&self, workload: &Workload) -> Chunks {
        match self.engine {
            "oracle" => workload.oracle_timed(),
            _ => workload.timed(),
        }
    }

    /// The entrant's row, without samples so far.
    pub(super) fn row(&self, info: &SceneInfo, workload: &Workload, threads: usize) -> RateRow {
        RateRow {
            hits: self.hits,
            difference: self.difference,
            exact: self
                .difference
                .is_none_or(|share| share <= MAX_DIFFERING_SHARE),
            ..row(
                info,
                workload.kind().name(),
                self.engine,
                &self.kernel,
                threads,
            )
        }
    }
}

/// A row without samples.
pub(super) fn row(
    info: &SceneInfo,
    rays: &str,
    engine: &str,
    kernel: &str,
    threads: usize,
) -> RateRow {
    RateRow {
        scene: info.name.clone(),
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
