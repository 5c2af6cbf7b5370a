//! Entrants that trace a set of rays: our kernels, the oracle, and the peers' modes with the share
//! of their results that differ.

use super::answer::MAX_DIFFERING_SHARE;
use super::plan::{BenchPlan, SceneInfo};
use super::rounds::SampleFn;
use super::timer::{self, Chunks};
use super::workload::{BenchTrees, Workload};
use crate::peers::{BenchEngine, ONE, PeerScene};
use phalanx_render::Cores;
use phalanx_report::{ORACLE, PHALANX, RateRow};
use phalanx_trace::Kernel;

/// One engine and mode on a set of rays, with its results compared.
pub(super) struct Entrant<'a> {
    name: &'static str,
    kernel: String,
    engine: Box<dyn BenchEngine + 'a>,
    hits: u64,
    difference: Option<f64>,
}

/// A peer's name, and the scene in its form.
pub(super) type NamedPeerScene = (&'static str, PeerScene);

/// The kernels to be timed, `auto` among them. Work is counted without `auto`: its choice of
/// kernels depends on the build, and counts must not.
pub(super) fn kernels(plan: &BenchPlan) -> Vec<Kernel> {
    let all = Kernel::ALL.iter().map(|&(_, kernel)| kernel);
    let is_measured = |kernel: &Kernel| match kernel {
        Kernel::Auto => plan.timed,
        kernel => plan.kernels.contains(kernel),
    };
    all.filter(is_measured).collect()
}

/// All entrants for a set of rays. Our kernels are checked before; peers are compared here.
pub(super) fn entrants<'a>(
    trees: &'a BenchTrees,
    peers: &'a [NamedPeerScene],
    workload: &'a Workload,
    plan: &BenchPlan,
) -> Vec<Entrant<'a>> {
    let rays = workload.set.rays();
    let hits = workload.expected.hits(workload.rays()) as u64;
    let checked = |name, kernel: &str, engine: Box<dyn BenchEngine + 'a>| Entrant {
        name,
        kernel: kernel.to_owned(),
        engine,
        hits,
        difference: None,
    };
    let mut entrants = vec![checked(ORACLE, "scalar", Box::new(trees.oracle(rays)))];
    let kernels = kernels(plan).into_iter();
    let kernels = kernels.map(|k| checked(PHALANX, k.name(), Box::new(trees.kernel(k, rays))));
    entrants.extend(kernels);
    entrants.push(checked(PHALANX, ONE, Box::new(trees.one(rays))));
    let (query, all) = (workload.kind().query(), Chunks::all(workload.packets()));
    for (name, peer_scene) in peers {
        for (kernel, engine) in peer_scene(rays) {
            let answer = timer::answer(&*engine, query, &all, BenchPlan::all_threads());
            let expected = &workload.expected;
            entrants.push(Entrant {
                name,
                kernel,
                engine,
                hits: answer.hits(workload.rays()) as u64,
                difference: Some(expected.share_of_differences(&answer, workload.rays())),
            });
        }
    }
    entrants
}

impl Entrant<'_> {
    /// Traces the part of the rays that is timed.
    pub(super) fn sampler<'a>(&'a self, workload: &Workload) -> SampleFn<'a> {
        let chunks = match self.name {
            ORACLE => workload.oracle_timed(),
            _ => workload.timed(),
        };
        let (query, rays) = (workload.kind().query(), workload.rays());
        Box::new(move |passes, threads, pin| {
            let cores = Cores::here(pin);
            let timing = timer::sample(&*self.engine, query, &chunks, passes, threads, &cores);
            (timing, chunks.rays(rays) as u64)
        })
    }

    /// The entrant's row, still without samples.
    pub(super) fn row(&self, info: &SceneInfo, workload: &Workload, threads: usize) -> RateRow {
        let kind = workload.kind().name();
        RateRow {
            hits: self.hits,
            difference: self.difference,
            exact: self
                .difference
                .is_none_or(|share| share <= MAX_DIFFERING_SHARE),
            ..row(info, kind, self.name, &self.kernel, threads)
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
        exact: true,
        ..RateRow::default()
    }
}
