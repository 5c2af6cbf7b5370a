//! The timed part: every entry takes a sample in every round, so that the machine's mood falls on all of them alike.

use super::clock::{self, Chunks};
use super::kind::Question;
use super::plan::{Listener, Plan};
use crate::frame::{Control, Pin, Settings, Tree, render_tree};
use crate::peers::Contender;
use crate::render::Cores;
use crate::report::{Estimate, Row};
use crate::scene::Scene;

/// Seconds that a sample takes at least: long beside the clock's and the threads' own costs.
const SAMPLE: f64 = 0.02;

/// What an entry does in a sample.
pub(super) enum Task<'a> {
    /// Traces rays.
    Rays {
        contender: &'a dyn Contender,
        question: Question,
        chunks: Chunks,
        rays: usize,
    },
    /// Renders a frame.
    Frame {
        scene: &'a Scene,
        tree: Tree<'a>,
        settings: Settings,
    },
}

impl Task<'_> {
    /// Seconds and rays of some passes.
    fn sample(&self, passes: usize, threads: usize, pin: Pin) -> (f64, u64) {
        match self {
            Task::Rays {
                contender,
                question,
                chunks,
                rays,
            } => {
                let cores = Cores::here(pin);
                let seconds = clock::sample(*contender, *question, chunks, passes, threads, &cores);
                (seconds, (chunks.rays(*rays) * passes) as u64)
            }
            Task::Frame {
                scene,
                tree,
                settings,
            } => {
                let settings = Settings {
                    threads,
                    pin,
                    ..settings.clone()
                };
                let frames = (0..passes).filter_map(|_| {
                    let frame = render_tree(scene, *tree, &settings, &Control::default());
                    // It was rendered before, to be compared.
                    frame.ok().map(|f| (f.seconds, f.stats.rays.total()))
                });
                frames.fold((0.0, 0), |sum, f| (sum.0 + f.0, sum.1 + f.1))
            }
        }
    }
}

/// A row in the making.
pub(super) struct Entry<'a> {
    pub(super) row: Row,
    pub(super) task: Task<'a>,
    passes: usize,
    seconds: f64,
}

impl<'a> Entry<'a> {
    pub(super) fn new(row: Row, task: Task<'a>) -> Entry<'a> {
        Entry {
            row,
            task,
            passes: 1,
            seconds: 0.0,
        }
    }

    /// Unmeasured, to fill caches and page tables; says how many passes a sample needs.
    fn warm_up(&mut self, plan: &Plan) {
        let threads = self.row.threads as usize;
        let (seconds, rays) = self.task.sample(1, threads, plan.pin(threads));
        if seconds > 0.0 {
            self.passes = (SAMPLE / seconds).ceil() as usize;
        }
        self.row.rays_timed = rays;
    }

    fn wants_more(&self, plan: &Plan) -> bool {
        self.row.samples.len() < plan.repeat || self.seconds < plan.min_time
    }

    fn take(&mut self, plan: &Plan) {
        let threads = self.row.threads as usize;
        let (seconds, rays) = self
            .task
            .sample(self.passes.max(1), threads, plan.pin(threads));
        self.seconds += seconds;
        self.row.samples.push(rays as f64 / 1e6 / seconds);
    }
}

/// Measures all entries, round by round; all take as many samples, so that the k-th of one belongs to the k-th of another.
pub(super) fn race(mut entries: Vec<Entry>, plan: &Plan, listener: &mut dyn Listener) -> Vec<Row> {
    for entry in &mut entries {
        entry.warm_up(plan);
    }
    let mut round = 0;
    while entries.iter().any(|entry| entry.wants_more(plan)) {
        let total = entries.len() * plan.repeat.max(round + 1);
        let count = entries.len();
        for (k, entry) in entries.iter_mut().enumerate() {
            entry.take(plan);
            listener.progress((round * count + k + 1) as f64 / total as f64);
        }
        round += 1;
    }
    // A clock too coarse to see a sample gives no rate.
    entries.retain(|entry| entry.row.samples.iter().all(|rate| rate.is_finite()));
    let finished = entries.into_iter().map(|mut entry| {
        entry.row.mrays_per_s = Estimate::of(&entry.row.samples);
        entry.row
    });
    finished.collect()
}
