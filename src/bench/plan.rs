//! What a run is to measure, and how long.

use super::ray_kind::RayKind;
use crate::peers::Peer;
use crate::report::RaySetRecord;
use phalanx_render::frame::CoreAffinity;
use phalanx_trace::Kernel;
use phalanx_trace::bvh::Quality;
use std::collections::BTreeMap;

/// What to measure on every scene.
#[derive(Clone)]
pub struct BenchPlan<'p> {
    /// Kinds of rays.
    pub kinds: Vec<RayKind>,
    /// Whether whole frames are rendered, too.
    pub frames: bool,
    /// Kernels; `auto` is always measured.
    pub kernels: Vec<Kernel>,
    /// What our tree is worth.
    pub quality: Quality,
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Picture size that the rays are of.
    pub size: [u32; 2],
    /// Samples of each row at least.
    pub repeat: usize,
    /// Seconds that the samples of a row take together at least.
    pub min_time: f64,
    /// Whether workers are bound to cores even where there are fewer of them than cores.
    pub pin: bool,
    /// Other tracers.
    pub peers: &'p [Peer],
    /// Whether to time anything, or to count work only.
    pub timed: bool,
}

impl BenchPlan<'_> {
    /// The same for some kinds of rays only, without peers.
    pub fn restricted(&self, kinds: impl Fn(&RayKind) -> bool, frames: bool) -> BenchPlan<'static> {
        BenchPlan {
            kinds: self.kinds.iter().copied().filter(kinds).collect(),
            frames,
            kernels: self.kernels.clone(),
            threads: self.threads.clone(),
            peers: &[],
            ..*self
        }
    }

    /// Binding of so many workers to cores. With a worker for each core they are bound always: a
    /// sample is over before a system that has put two on one core would move one.
    pub fn pin(&self, threads: usize) -> CoreAffinity {
        match self.pin || threads >= BenchPlan::all_threads() && threads > 1 {
            true => CoreAffinity::Cores,
            false => CoreAffinity::None,
        }
    }

    /// The largest number of threads: trees are built on so many.
    pub fn max_threads(&self) -> usize {
        self.threads.iter().copied().max().unwrap_or(1)
    }

    /// Threads that what is not measured may take.
    pub fn all_threads() -> usize {
        std::thread::available_parallelism().map_or(1, |n| n.get())
    }
}

/// What is known of a scene beside the scene.
#[derive(Clone, Debug, Default)]
pub struct SceneInfo {
    /// As on the command line.
    pub name: String,
    /// Standard family.
    pub family: Option<String>,
    /// `small`, `medium` or `large`.
    pub step: Option<String>,
    /// Seconds to read or generate it.
    pub load_seconds: f64,
    /// The answers that the suite expects at this size, by kind, where it says any.
    pub expected: BTreeMap<String, RaySetRecord>,
}

/// Hears how far a run is.
pub trait ProgressListener {
    /// What is being done now, in a few words.
    fn begin_step(&mut self, what: &str);
    /// A sample was taken; `done` of this scene's work, in \[0, 1\].
    fn progress(&mut self, done: f64);
}
