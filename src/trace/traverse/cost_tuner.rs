//! Choice of a kernel for any hit by the cost of a batch: its first packets are timed.
//!
//! The times of a picture's packets range from 20 to 3000 ns. The other kernel, beams or single
//! rays, takes 80 to 400 ns before a ray hits anything, and less than packets from there on. So
//! packets are faster for rays that soon escape or end, and the other kernel for rays with much in
//! their path. The time of a few packets predicts this; no property of the rays does
//! (`perf/notes/coherence.md`).

use super::batch_slice::BatchSlice;
use super::kernel_tuner::PerClassTuner;
use crate::stopwatch::Stopwatch;
use std::ops::Range;

/// Number of classes of cost: less than [`LEAST_COST`], twice as much, four times, and so on.
pub(super) const COST_CLASSES: usize = 9;

/// Upper bound of the time of a packet in the first class, in seconds.
const LEAST_COST: f32 = 32e-9;

/// Number of timed packets: two squares of the picture.
const PROBE: usize = 8;

/// Minimum size, in packets, of a batch whose first packets are timed: too little of a smaller one
/// would be left.
const MIN_PROBED: usize = 5 * PROBE;

/// Maximum number of batches between probes, and the number of consecutive equal decisions that
/// adds one batch to the interval.
const MAX_UNPROBED: u32 = 7;
const SAME_FOR_EACH: u32 = 3;

/// A tuner of packets, the first kernel, and another kernel, for batches of `N` classes and any
/// cost.
#[derive(Clone, Copy, Debug)]
pub(super) struct CostTuner<const N: usize> {
    classes: PerClassTuner<N>,
    /// Offsets of a class's log ratio, by cost.
    biases: [f32; COST_CLASSES],
    /// True if the other kernel can also trace just a few packets.
    both_probe: bool,
    /// True if the other kernel was faster for the last probed batch.
    last: bool,
    /// Number of consecutive probes with the same result.
    same: u32,
    /// Batches since the last probe.
    unprobed: u32,
}

impl<const N: usize> CostTuner<N> {
    /// A tuner with the initial estimate, for all classes, and the penalty of [`KernelTuner::new`].
    ///
    /// [`KernelTuner::new`]: super::kernel_tuner::KernelTuner::new
    pub(super) fn new(
        log_ratio: f32,
        trial_penalty: f32,
        biases: [f32; COST_CLASSES],
        both_probe: bool,
    ) -> CostTuner<N> {
        CostTuner {
            classes: PerClassTuner::new([log_ratio; N], trial_penalty),
            biases,
            both_probe,
            last: false,
            same: 0,
            unprobed: 0,
        }
    }

    /// Traces a batch of a class by one of the two kernels, or both: see [`KernelTuner::trace`].
    ///
    /// [`KernelTuner::trace`]: super::kernel_tuner::KernelTuner::trace
    pub(super) fn trace(
        &mut self,
        class: usize,
        batch: Range<usize>,
        mut trace: impl FnMut(bool, &BatchSlice),
    ) {
        let skips = (self.same / SAME_FOR_EACH).min(MAX_UNPROBED);
        if batch.len() < MIN_PROBED || self.unprobed < skips {
            self.unprobed += 1;
            trace(self.last, &BatchSlice::all(batch));
            return;
        }
        self.unprobed = 0;
        let rest = batch.start + PROBE..batch.end;
        let start = Stopwatch::start();
        let second = self.both_probe && self.last;
        trace(second, &BatchSlice::all(batch.start..rest.start));
        let seconds = start.elapsed().as_secs_f32() / PROBE as f32;
        let bias = self.biases[cost_class(seconds)];
        let parts = BatchSlice::trial_in_pieces;
        let second = (self.classes).trace(class, bias, rest, parts, trace);
        self.same = if second == self.last { self.same + 1 } else { 0 };
        self.last = second;
    }
}

/// The class of a time of a packet, in seconds.
fn cost_class(seconds: f32) -> usize {
    let times = (seconds / LEAST_COST) as u32;
    ((u32::BITS - times.leading_zeros()) as usize).min(COST_CLASSES - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_class_takes_twice_as_long_as_the_last() {
        let times = [
            0.0,
            31.0,
            33.0,
            63.0,
            65.0,
            129.0,
            3900.0,
            4100.0,
            1e9,
            f32::INFINITY,
        ];
        let classes = times.map(|nanoseconds| cost_class(nanoseconds * 1e-9));
        assert_eq!(classes, [0, 0, 1, 1, 2, 3, 7, 8, 8, 8]);
    }

    /// Traces a hundred batches for which one kernel is the faster at any cost, and gives back how
    /// many of them had their first packets timed.
    fn probes(packets: usize, second: bool) -> usize {
        let log_ratio = if second { 9.0 } else { -9.0 };
        let mut tuner = CostTuner::<1>::new(log_ratio, 1.0, [0.0; COST_CLASSES], true);
        let mut probes = 0;
        for batch in 0..100 {
            let (first, mut traced) = (batch * packets, Vec::new());
            tuner.trace(0, first..first + packets, |_, slice| {
                probes += usize::from(slice.packets == (first..first + PROBE));
                traced.extend(slice.each());
            });
            assert!(traced.into_iter().eq(first..first + packets), "each once");
        }
        probes
    }

    #[test]
    fn probes_become_rare_while_one_kernel_wins() {
        for second in [false, true] {
            let some = probes(64, second);
            assert!((15..40).contains(&some), "{some}");
            assert_eq!(probes(MIN_PROBED - 1, second), 0);
        }
    }
}
