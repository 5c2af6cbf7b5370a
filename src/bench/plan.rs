//! Settings of a run: what to measure, and for how long.

use super::error::BenchError;
use crate::peers::Peer;
use phalanx_render::frame::{CoreAffinity, Sampling};
use phalanx_report::{RayKind, RaySetRecord, RunInfo, SuiteScene};
use phalanx_scene::{Scene, thread_count};
use phalanx_trace::Kernel;
use phalanx_trace::bvh::{BuildSettings, Bvh, Quality};
use std::collections::BTreeMap;

/// The measurements of every scene.
#[derive(Clone)]
pub struct BenchPlan<'p> {
    /// Kinds of rays.
    pub kinds: Vec<RayKind>,
    /// True if whole frames are rendered, too.
    pub frames: bool,
    /// Kernels; `auto` is always measured.
    pub kernels: Vec<Kernel>,
    /// Build quality of our tree.
    pub quality: Quality,
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Picture size that the rays belong to.
    pub size: [u32; 2],
    /// Minimum number of samples of each row.
    pub repeat: usize,
    /// Minimum total time of the samples of a row, in seconds.
    pub min_time: f64,
    /// True if workers are bound to cores even if there are more cores than workers.
    pub pin: bool,
    /// Other tracers.
    pub peers: &'p [Peer],
    /// True if rates are timed, false if only work is counted.
    pub timed: bool,
}

impl BenchPlan<'_> {
    /// The same plan for some kinds of rays only, without peers.
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

    /// Binding of the given number of workers to cores. With one worker per core they are always
    /// bound: a sample is over before the system would move one of two workers on the same core.
    pub fn pin(&self, threads: usize) -> CoreAffinity {
        if self.pin || threads >= BenchPlan::all_threads() && threads > 1 {
            CoreAffinity::Cores
        } else {
            CoreAffinity::None
        }
    }

    /// The largest number of threads.
    pub fn max_threads(&self) -> usize {
        self.threads.iter().copied().max().unwrap_or(1)
    }

    /// How trees are built, on the largest number of threads.
    pub fn build_settings(&self) -> BuildSettings {
        BuildSettings {
            quality: self.quality,
            threads: self.max_threads(),
        }
    }

    /// Settings and time of a run of this plan, for its record.
    pub fn run_info(&self, started: String, arguments: Vec<String>, seconds: f64) -> RunInfo {
        RunInfo {
            started,
            arguments,
            seconds,
            partial: false,
            size: self.size,
            repeat: self.repeat as u32,
            spp: Sampling::CENTER.spp,
            min_time: self.min_time,
            pinned: self.pin,
            quality: self.quality.name().to_owned(),
            peers: self.peers.iter().map(|peer| peer.describe()).collect(),
        }
    }

    /// Number of threads for work that is not measured.
    pub fn all_threads() -> usize {
        thread_count(0)
    }
}

/// Facts about a scene that the scene itself does not hold.
#[derive(Clone, Debug, Default)]
pub struct SceneInfo {
    /// Name of the scene, as on the command line.
    pub name: String,
    /// Standard family.
    pub family: Option<String>,
    /// `small`, `medium` or `large`.
    pub step: Option<String>,
    /// Seconds it took to read or generate the scene.
    pub load_seconds: f64,
    /// The results that the suite expects at this size, by kind, if any.
    pub expected: BTreeMap<String, RaySetRecord>,
}

impl SceneInfo {
    /// A scene of the suite; results are expected only at the suite's own size.
    pub fn of_suite(scene: &SuiteScene, answers: bool) -> SceneInfo {
        SceneInfo {
            name: scene.name.clone(),
            family: Some(scene.family.clone()),
            step: Some(scene.step.clone()),
            load_seconds: 0.0,
            expected: if answers { scene.expected.clone() } else { BTreeMap::new() },
        }
    }
}

/// Receives the progress of a run. An error, which should be [`BenchError::Stopped`], ends it.
pub trait ProgressListener {
    /// Begins a step, described by `what` in a few words.
    fn begin_step(&mut self, what: &str) -> Result<(), BenchError>;
    /// Receives the tree of a scene, before anything is traced.
    fn built(&mut self, _scene: &Scene, _bvh: &Bvh) {}
    /// Reports that a sample was taken; `done` is the finished share of this scene's work, in \[0,
    /// 1\].
    fn progress(&mut self, done: f64) -> Result<(), BenchError>;
}
