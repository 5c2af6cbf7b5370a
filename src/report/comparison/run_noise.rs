//! Differences of one run from another on the same machine: the machine's speed at the time, noise
//! that the rounds of one run do not show, and kernels that changed. `perf/notes/noise.md` has how
//! often they deceive.

use super::log_rate::{LogRate, RateChange};
use super::regressions::ROWS_TO_DECIDE;
use crate::statistics::median;
use crate::{BenchRecord, PHALANX, RateRow, RecordIndex};
use serde::Serialize;
use std::collections::BTreeMap;

/// Standard deviation of a normal distribution in median absolute deviations.
const DEVIATION: f64 = 1.4826;

/// Variance of the median of many normal samples, as a multiple of their mean's: π/2.
const OF_MEDIAN: f64 = std::f64::consts::FRAC_PI_2;

/// Threshold of a whole kernel, as a share of that of one rate: its median is known that much
/// better. On a busy machine it found a kernel 5 % slower in five pairs of records of six, and none
/// in 552 that had not changed (`perf/notes/noise.md`).
const KERNEL_THRESHOLD: f64 = 1.0 / 3.0;

/// A kernel whose rates have changed together since the first record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KernelChange {
    /// Index of the record.
    pub record: usize,
    /// Kernel.
    pub kernel: String,
    /// Threads.
    pub threads: u32,
    /// Number of its rates.
    pub rates: usize,
    /// Median of their changes, beyond the machine's, with its 95 % interval.
    pub change: RateChange,
}

/// Changes from one run to another on the same machine, and the machine's part in them.
pub(super) struct RunNoise<'a> {
    /// Change of the machine's speed.
    machine: LogRate,
    /// The machine's part in the change of one rate: its speed, and what differs from run to run.
    of_rate: LogRate,
    changes: LogChanges<'a>,
}

/// Changes of an engine's kernel on a number of threads, as logarithms, by scene and rays.
type LogChanges<'a> = BTreeMap<(&'a str, &'a str, u32), BTreeMap<(&'a str, &'a str), f64>>;

impl<'a> RunNoise<'a> {
    /// The machine's part in the changes between two records; `None` if they are of different
    /// machines or instruction sets, or have no tracer in common that is not ours.
    ///
    /// Other tracers (the oracle, and peers) show the machine's speed: the median of their changes,
    /// because a few rates in a hundred are slowed by other load in all of their rounds.
    pub fn of(
        (old, before): (&BenchRecord, &RecordIndex<'a>),
        (new, now): (&BenchRecord, &RecordIndex<'a>),
    ) -> Option<RunNoise<'a>> {
        let same = old.machine.cpu == new.machine.cpu
            && old.machine.threads == new.machine.threads
            && old.program.isa_compiled == new.program.isa_compiled;
        if !same {
            return None;
        }
        let changes = changes(before, now);
        let of = |ours: bool| -> Vec<f64> {
            let groups = changes.iter().filter(|(key, _)| (key.0 == PHALANX) == ours);
            let changes = groups.flat_map(|(_, changes)| changes.values().copied());
            changes.collect()
        };
        let mut others = of(false);
        if others.is_empty() || of(true).is_empty() {
            return None;
        }
        let scatter = changes.values().flat_map(|group| {
            let middle = middle(group);
            let off = group.values().map(move |change| change - middle);
            off.map(|off| off * off)
        });
        let count = changes.values().map(BTreeMap::len).sum::<usize>();
        let machine = LogRate::new(median(&mut others), variance_of_median(&others));
        let between = LogRate::new(0.0, scatter.sum::<f64>() / count as f64);
        Some(RunNoise {
            machine,
            of_rate: machine.over(between),
            changes,
        })
    }

    /// Change of the machine's speed.
    pub fn machine(&self) -> RateChange {
        self.machine.change()
    }
}

/// Change of a rate; with `noise`, beyond the machine's. The interval holds 999 of 1000 such
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

/// Our kernels whose rates together differ from the first record's by more than a share of the
/// threshold of one rate, the whole interval: a kernel that is a little slower everywhere is found
/// so, and in no single rate.
///
/// Other tracers take turns with ours on the same rays, so that other load slows both: what their
/// change of a measurement deviates by from their median is load, and is taken out.
pub(super) fn changed_kernels(noise: &[Option<RunNoise>], threshold: f64) -> Vec<KernelChange> {
    let threshold = threshold * KERNEL_THRESHOLD;
    let mut changed = Vec::new();
    for (i, noise) in noise.iter().enumerate() {
        let Some(noise) = noise else { continue };
        let load = load(&noise.changes);
        for (&(engine, kernel, threads), changes) in &noise.changes {
            if engine != PHALANX || changes.len() < ROWS_TO_DECIDE {
                continue;
            }
            let beyond_load = changes.iter().map(|(&(scene, rays), change)| {
                change - load.get(&(scene, rays, threads)).unwrap_or(&0.0)
            });
            let mut beyond_load: Vec<f64> = beyond_load.collect();
            let change = LogRate::new(median(&mut beyond_load), variance_of_median(&beyond_load));
            // The others' error is in the load, too, with which it cancels.
            let change = change.over(noise.machine.exactly()).change();
            if change.exceeds(threshold) {
                changed.push(KernelChange {
                    record: i + 1,
                    kernel: kernel.to_owned(),
                    threads,
                    rates: changes.len(),
                    change,
                });
            }
        }
    }
    changed
}

fn changes<'a>(before: &RecordIndex<'a>, now: &RecordIndex<'a>) -> LogChanges<'a> {
    let mut changes = LogChanges::new();
    let engines = now.engines.iter();
    let both = engines.flat_map(|engine| before.shared(now, engine));
    for (old, new) in both.filter(|(old, new)| old.has_rate() && new.has_rate()) {
        let change = libm::log(new.mrays_per_s.median / old.mrays_per_s.median);
        let kernel = (&*new.engine, &*new.kernel, new.threads);
        let of_kernel = changes.entry(kernel).or_default();
        of_kernel.insert((&*new.scene, &*new.rays), change);
    }
    changes
}

/// Mean deviation of other tracers' changes from their medians, by scene, rays and threads.
fn load<'a>(changes: &LogChanges<'a>) -> BTreeMap<(&'a str, &'a str, u32), f64> {
    let mut deviations: BTreeMap<_, Vec<f64>> = BTreeMap::new();
    let others = changes.iter().filter(|(key, _)| key.0 != PHALANX);
    for (&(_, _, threads), changes) in others {
        let middle = middle(changes);
        for (&(scene, rays), change) in changes {
            let of_measurement = deviations.entry((scene, rays, threads)).or_default();
            of_measurement.push(change - middle);
        }
    }
    let mean = |all: Vec<f64>| all.iter().sum::<f64>() / all.len() as f64;
    let means = deviations.into_iter().map(|(key, all)| (key, mean(all)));
    means.collect()
}

fn middle(changes: &BTreeMap<(&str, &str), f64>) -> f64 {
    median(&mut changes.values().copied().collect::<Vec<f64>>())
}

/// Variance of the median of these, estimated by their median deviation.
fn variance_of_median(values: &[f64]) -> f64 {
    let middle = median(&mut values.to_vec());
    let mut off: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
    let deviation = DEVIATION * median(&mut off);
    OF_MEDIAN * deviation * deviation / values.len() as f64
}
