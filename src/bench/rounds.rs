//! The timed part: every measurement takes a sample in every round, so that changes of the
//! machine's speed affect all of them alike.

use super::error::BenchError;
use super::plan::{BenchPlan, ProgressListener};
use super::timer::Timing;
use phalanx_render::frame::CoreAffinity;
use phalanx_report::{Estimate, RateRow};

/// Minimum time of a sample in seconds. It is long compared with the cost of starting threads, and
/// short because disturbances of a shared machine last for milliseconds to seconds: the same time
/// spread over more rounds, further apart, finds more quiet moments.
const MIN_SAMPLE_SECONDS: f64 = 0.005;

/// Takes a sample of some passes on a number of threads: their timing, and the rays of each.
pub(super) type SampleFn<'a> = Box<dyn Fn(usize, usize, CoreAffinity) -> (Timing, u64) + 'a>;

/// The measurement of a row.
pub(super) struct Measurement<'a> {
    row: RateRow,
    sampler: SampleFn<'a>,
    /// Minimum number of passes of a sample.
    min_passes: usize,
    passes: usize,
    seconds: f64,
    /// Seconds of each piece of a pass when it was fastest, one entry per round.
    rounds: Vec<Vec<f64>>,
}

impl<'a> Measurement<'a> {
    pub(super) fn new(row: RateRow, min_passes: usize, sampler: SampleFn<'a>) -> Measurement<'a> {
        Measurement {
            row,
            sampler,
            min_passes,
            passes: 1,
            seconds: 0.0,
            rounds: Vec::new(),
        }
    }

    fn wants_more(&self, plan: &BenchPlan) -> bool {
        self.rounds.len() < plan.repeat || self.seconds < plan.min_time
    }

    /// The first sample is a single pass. It fills caches and page tables, which does no harm as
    /// only the fastest visit counts. It determines how many passes the other samples need.
    fn measure_round(&mut self, plan: &BenchPlan) {
        let threads = self.row.threads as usize;
        let (timing, rays) = (self.sampler)(self.passes, threads, plan.pin(threads));
        let rate = rays as f64 * self.passes as f64 / 1e6 / timing.wall;
        let enough = (MIN_SAMPLE_SECONDS / timing.pass()).ceil() as usize;
        self.passes = enough.clamp(self.min_passes, MAX_PASSES);
        self.seconds += timing.wall;
        self.row.samples.push(rate);
        self.row.rays_timed = rays;
        self.rounds.push(timing.fastest);
    }

    /// Returns the row; `None` if the clock is too coarse to measure a sample.
    fn finish(mut self) -> Option<RateRow> {
        self.row.mrays_per_s = Estimate::of_fastest(&self.rounds, self.row.rays_timed as f64 / 1e6);
        let rate = self.row.mrays_per_s.median;
        let seen = self.row.samples.iter().all(|rate| rate.is_finite());
        (seen && rate.is_finite()).then_some(self.row)
    }
}

/// Minimum number of rounds of a run that is ended early: the first only fills caches.
const MIN_ROUNDS: usize = 2;

/// Maximum number of passes of a sample, if one is too short for the clock.
const MAX_PASSES: usize = 10_000;

/// Takes all measurements, round by round, so that a disturbance of the machine affects all of
/// them. Every other round is in reverse order, so that no engine always comes after the same other
/// engine, whose tree fills the caches. If the listener ends the run, rates have the samples taken
/// until then.
pub(super) fn run_rounds(
    mut measurements: Vec<Measurement>,
    plan: &BenchPlan,
    listener: &mut dyn ProgressListener,
) -> Result<Vec<RateRow>, BenchError> {
    let mut round = 0;
    'rounds: while measurements.iter().any(|entry| entry.wants_more(plan)) {
        let total = measurements.len() * plan.repeat.max(round + 1);
        let count = measurements.len();
        for k in 0..count {
            let turn = if round % 2 == 1 { count - 1 - k } else { k };
            measurements[turn].measure_round(plan);
            let done = (round * count + k + 1) as f64 / total as f64;
            if let Err(stopped) = listener.progress(done) {
                if round >= MIN_ROUNDS {
                    break 'rounds;
                } else {
                    return Err(stopped);
                }
            }
        }
        round += 1;
    }
    let rows = measurements.into_iter().filter_map(Measurement::finish);
    Ok(rows.collect())
}
