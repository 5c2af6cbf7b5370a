//! Differences of one run from another on the same machine: the machine's speed at the time, other
//! load, and noise that the rounds of one run do not show. `perf/notes/noise.md` has how often they
//! deceive.

use super::log_rate::{LogRate, RateChange};
use crate::statistics::median;
use crate::{BenchRecord, PHALANX, RateRow, RecordIndex};
use std::collections::BTreeMap;

/// Standard deviation of a normal distribution in median absolute deviations.
const DEVIATION: f64 = 1.4826;

/// Variance of the median of many normal samples, as a multiple of their mean's: π/2.
const OF_MEDIAN: f64 = std::f64::consts::FRAC_PI_2;

/// Changes from one run to another on the same machine, and the machine's part in them.
pub(super) struct RunNoise<'a> {
    /// Change of the machine's speed.
    machine: LogRate,
    /// The machine's part in the change of one rate: its speed, and what differs from run to run.
    of_rate: LogRate,
    /// The same for most rates: those that no other load slowed in all of their rounds.
    of_most_rates: LogRate,
    changes: LogChanges<'a>,
}

/// Changes of an engine's kernel on a number of threads, as logarithms, by scene and rays.
type LogChanges<'a> = BTreeMap<(&'a str, &'a str, u32), KernelChanges<'a>>;

/// Changes of one kernel's rates, as logarithms, by scene and rays.
pub(super) type KernelChanges<'a> = BTreeMap<(&'a str, &'a str), f64>;

impl<'a> RunNoise<'a> {
    /// The machine's part in the changes between two records; `None` if they have no tracer in
    /// common that is not ours.
    ///
    /// Other tracers (the oracle, and peers) show the machine's speed: the median of their changes,
    /// because a few rates in a hundred are slowed by other load in all of their rounds.
    pub fn between(before: &RecordIndex<'a>, now: &RecordIndex<'a>) -> Option<RunNoise<'a>> {
        let changes = changes(before, now);
        let others = changes.iter().filter(|(key, _)| key.0 != PHALANX);
        let others = others.flat_map(|(_, changes)| changes.values().copied());
        let others: Vec<f64> = others.collect();
        if others.is_empty() || changes.keys().all(|key| key.0 != PHALANX) {
            return None;
        }
        let scatter = changes.values().flat_map(|kernel| {
            let middle = median_of(kernel.values().copied());
            kernel.values().map(move |change| change - middle)
        });
        let scatter: Vec<f64> = scatter.collect();
        let squares = scatter.iter().map(|off| off * off).sum::<f64>();
        let machine = median_with_variance(&others);
        Some(RunNoise {
            machine,
            of_rate: machine.beyond(0.0, squares / scatter.len() as f64),
            of_most_rates: machine.beyond(0.0, robust_variance(scatter.into_iter())),
            changes,
        })
    }

    /// Change of the machine's speed.
    pub fn machine(&self) -> RateChange {
        self.machine.change()
    }

    /// Changes of our kernels by kernel and threads, beyond the machine's and other load's.
    ///
    /// Other tracers take turns with ours on the same rays, so that other load slows both: the
    /// deviation of their change of a measurement from their median is load. Their error cancels,
    /// since it is in the load as well as in the machine's change.
    pub fn beyond_load(&self) -> impl Iterator<Item = ((&'a str, u32), KernelChanges<'a>)> {
        let load = self.load();
        let ours = self.changes.iter().filter(|(key, _)| key.0 == PHALANX);
        ours.map(move |(&(_, kernel, threads), changes)| {
            let beyond = changes.iter().map(|(&(scene, rays), change)| {
                let load = load.get(&(scene, rays, threads)).unwrap_or(&0.0);
                ((scene, rays), change - load - self.machine.value())
            });
            ((kernel, threads), beyond.collect())
        })
    }

    /// Mean deviation of other tracers' changes from their medians, by scene, rays and threads.
    fn load(&self) -> BTreeMap<(&'a str, &'a str, u32), f64> {
        let mut deviations: BTreeMap<_, Vec<f64>> = BTreeMap::new();
        let others = self.changes.iter().filter(|(key, _)| key.0 != PHALANX);
        for (&(_, _, threads), changes) in others {
            let middle = median_of(changes.values().copied());
            for (&(scene, rays), change) in changes {
                let measurement = deviations.entry((scene, rays, threads)).or_default();
                measurement.push(change - middle);
            }
        }
        let mean = |all: Vec<f64>| all.iter().sum::<f64>() / all.len() as f64;
        let means = deviations.into_iter().map(|(key, all)| (key, mean(all)));
        means.collect()
    }
}

/// Returns true if two records are of one machine and instruction set.
pub(super) fn is_same_machine(old: &BenchRecord, new: &BenchRecord) -> bool {
    old.machine.cpu == new.machine.cpu
        && old.machine.threads == new.machine.threads
        && old.program.isa_compiled == new.program.isa_compiled
}

/// Change of a rate; with `noise`, beyond the machine's. The interval holds 1999 of 2000 such
/// changes, because a comparison has hundreds of them. `None` if a row has no rate.
pub(super) fn rate_change(
    old: &RateRow,
    new: &RateRow,
    noise: Option<&RunNoise>,
) -> Option<RateChange> {
    let change = LogRate::change_between(old, new)?;
    let change = noise.map_or(change, |noise| change.over(noise.of_rate));
    Some(change.mostly())
}

/// Returns true if a rate is slower by more than the threshold, with an interval of 95 %, unless
/// other load slowed it: it is worth measuring again.
pub(super) fn looks_slower(
    old: &RateRow,
    new: &RateRow,
    noise: Option<&RunNoise>,
    threshold: f64,
) -> bool {
    LogRate::change_between(old, new).is_some_and(|change| {
        let change = noise.map_or(change, |noise| change.over(noise.of_most_rates));
        change.change().slower_than(threshold)
    })
}

fn changes<'a>(before: &RecordIndex<'a>, now: &RecordIndex<'a>) -> LogChanges<'a> {
    let mut changes = LogChanges::new();
    let engines = now.engines.iter();
    let pairs = engines.flat_map(|engine| before.shared(now, engine));
    // The rate of another part of the rays is another rate.
    let alike = |old: &RateRow, new: &RateRow| {
        old.has_rate() && new.has_rate() && old.rays_timed == new.rays_timed
    };
    for (old, new) in pairs.filter(|(old, new)| alike(old, new)) {
        let change = libm::log(new.mrays_per_s.median / old.mrays_per_s.median);
        let kernel = (&*new.engine, &*new.kernel, new.threads);
        let of_kernel = changes.entry(kernel).or_default();
        of_kernel.insert((&*new.scene, &*new.rays), change);
    }
    changes
}

fn median_of(values: impl Iterator<Item = f64>) -> f64 {
    median(&mut values.collect::<Vec<f64>>())
}

/// Median of the values, and its variance, estimated by their median deviation.
pub(super) fn median_with_variance(values: &[f64]) -> LogRate {
    let middle = median_of(values.iter().copied());
    let variance = robust_variance(values.iter().map(|value| value - middle));
    LogRate::new(middle, OF_MEDIAN * variance / values.len() as f64)
}

/// Variance of values whose mean is known to be zero, by the median of their sizes.
pub(super) fn robust_variance(values: impl Iterator<Item = f64>) -> f64 {
    let deviation = DEVIATION * median_of(values.map(f64::abs));
    deviation * deviation
}
