//! Differences between two runs on one machine that are not the program's: the machine's speed at
//! the time, and noise that the rounds of one run do not show. `perf/notes/noise.md` has how often
//! they deceive.

use super::row_keys::by_kernel;
use crate::report::baseline::LogRate;
use crate::report::statistics::median;
use crate::report::{BenchRecord, PHALANX, RateChange, RateRow};
use std::collections::BTreeMap;

/// Standard deviation of a normal distribution in median absolute deviations.
const DEVIATION: f64 = 1.4826;

/// Variance of the median of many normal samples, as a multiple of their mean's: π/2.
const OF_MEDIAN: f64 = std::f64::consts::FRAC_PI_2;

/// The machine's part in the changes from one run to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunNoise {
    /// Change of the machine's speed.
    machine: LogRate,
    /// Variance of one rate's change beyond that.
    between: f64,
}

/// Changes of an engine's kernel on a number of threads, as logarithms, over scenes and rays.
type LogChanges<'a> = BTreeMap<(&'a str, &'a str, u32), Vec<f64>>;

impl RunNoise {
    /// The machine's part in the changes between two records; `None` if they are of different
    /// machines or instruction sets, or have no tracer in common that is not ours.
    ///
    /// Three witnesses tell the machine's speed: other tracers (the oracle, and peers), ours, and
    /// the machine's limits. Their median counts, so that none can blame the machine alone: neither
    /// a slower kernel nor a slower oracle. Each is a median itself, because a few rates in a
    /// hundred are slowed by other load in all of their rounds.
    pub fn of(old: &BenchRecord, new: &BenchRecord) -> Option<RunNoise> {
        let place = |r: &BenchRecord| {
            let isa = r.program.isa_compiled.clone();
            (r.machine.cpu.clone(), r.machine.threads, isa)
        };
        if place(old) != place(new) {
            return None;
        }
        let changes = changes(&old.rows, &new.rows);
        let of = |ours: bool| {
            let groups = changes.iter().filter(|(key, _)| (key.0 == PHALANX) == ours);
            groups
                .flat_map(|(_, changes)| changes.clone())
                .collect::<Vec<f64>>()
        };
        let (mut others, mut ours) = (of(false), of(true));
        if others.is_empty() || ours.is_empty() {
            return None;
        }
        let mut witnesses = vec![median(&mut others), median(&mut ours)];
        match &mut limits(old, new)[..] {
            // The other tracers are to be believed, as in `baseline`.
            [] => witnesses.truncate(1),
            limits => witnesses.push(median(limits)),
        }
        let scatter = changes.values().flat_map(|group| {
            let middle = median(&mut group.clone());
            group
                .iter()
                .map(move |change| (change - middle) * (change - middle))
        });
        let count = changes.values().map(Vec::len).sum::<usize>();
        Some(RunNoise {
            machine: LogRate::new(median(&mut witnesses), variance_of_median(&others)),
            between: scatter.sum::<f64>() / count as f64,
        })
    }

    /// Change of the machine's speed.
    pub fn machine(&self) -> RateChange {
        self.machine.change()
    }
}

/// Change of a rate; with `noise`, beyond the machine's. The interval holds 999 of 1000 such
/// changes, because a comparison has hundreds of them. `None` where a row has no rate.
pub(super) fn rate_change(
    old: &RateRow,
    new: &RateRow,
    noise: Option<RunNoise>,
) -> Option<RateChange> {
    let change = LogRate::of(new)?.over(LogRate::of(old)?);
    let change = noise.map_or(change, |noise| {
        let between = LogRate::new(0.0, noise.between);
        change.over(noise.machine).over(between)
    });
    Some(change.mostly())
}

/// Change of all rates of a kernel together beyond the machine's, their median: a kernel that is a
/// little slower everywhere is found so, and in no single rate.
pub(super) fn kernel_changes(
    old: &BenchRecord,
    new: &BenchRecord,
    noise: RunNoise,
) -> Vec<(String, u32, usize, RateChange)> {
    let changes = changes(&old.rows, &new.rows);
    let of_kernel = |((engine, kernel, threads), mut group): ((&str, &str, u32), Vec<f64>)| {
        (engine == PHALANX).then(|| {
            let change = LogRate::new(median(&mut group), variance_of_median(&group));
            let change = change.over(noise.machine).change();
            (kernel.to_owned(), threads, group.len(), change)
        })
    };
    changes.into_iter().filter_map(of_kernel).collect()
}

fn changes<'a>(old: &'a [RateRow], new: &'a [RateRow]) -> LogChanges<'a> {
    let before = by_kernel(old);
    let mut changes = LogChanges::new();
    for (key, row) in by_kernel(new) {
        if let Some(old) = before.get(&key) {
            let change = libm::log(row.mrays_per_s.median / old.mrays_per_s.median);
            let kernel = (&*row.engine, &*row.kernel, row.threads);
            changes.entry(kernel).or_default().push(change);
        }
    }
    changes
}

/// Changes of the machine's limits, as logarithms.
fn limits(old: &BenchRecord, new: &BenchRecord) -> Vec<f64> {
    let of = |record: &BenchRecord| {
        let threads = record.limits.iter().flat_map(|limits| &limits.threads);
        let rates = threads.flat_map(|of| {
            let memory = of.bandwidth.iter();
            let memory = memory.map(|(name, rate)| ((of.threads, name.clone()), *rate));
            memory
                .chain([((of.threads, String::new()), of.gflops)])
                .collect::<Vec<_>>()
        });
        rates.collect::<BTreeMap<_, f64>>()
    };
    let before = of(old);
    let both = of(new)
        .into_iter()
        .filter_map(|(name, new)| Some(new / before.get(&name)?));
    both.map(libm::log)
        .filter(|change| change.is_finite())
        .collect()
}

/// Variance of the median of these, estimated by their median deviation.
fn variance_of_median(values: &[f64]) -> f64 {
    let middle = median(&mut values.to_vec());
    let mut off: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
    let deviation = DEVIATION * median(&mut off);
    OF_MEDIAN * deviation * deviation / values.len() as f64
}
