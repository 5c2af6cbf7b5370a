//! Online choice of the faster of two kernels.
//!
//! Divergent rays are faster as packets in an open scene and as single rays in a closed one. Shadow
//! rays are faster as a beam or as packets. No property of the rays predicts it, and it also
//! depends on the machine. So now and then each kernel traces a part of a batch, and the one that
//! takes less time per ray traces the following batches. The trial uses parts of one batch instead
//! of whole batches, because distant rays may differ more than kernels do. Rays are divided into
//! classes, see [`super::coherence`], which are tuned separately, but measurements of one class
//! also adjust the others. Both kernels give the same bits.

use super::batch_slice::BatchSlice;
use crate::stopwatch::Stopwatch;
use std::ops::Range;

/// Time from one trial to the next, in units of a trial's time and of the logarithm of the kernels'
/// speed ratio. So a much slower kernel is rarely tried, and a trial of one that is nearly as fast
/// costs nothing. The interval is a time instead of a number of batches: if rays begin to take
/// longer, there is more to gain, and a trial is due sooner.
const TRIAL_INTERVAL: f32 = 64.0;

/// Bounds on the interval between trials, in units of one trial's time: at least `MIN_INTERVAL`, at
/// most `MAX_INTERVAL_GROWTH` · trials², because early measurements are noisy.
const MIN_INTERVAL: f32 = 2.0;
const MAX_INTERVAL_GROWTH: f32 = 2.0;

/// Approximate number of trials in the means: older ones are forgotten.
const HISTORY: u32 = 8;

/// Maximum change of the estimate by one trial, as a natural logarithm: a thread that had to wait
/// is not slow.
const MAX_LOG_STEP: f32 = 0.5;

/// Minimum size, in packets, of a batch for a trial: parts of smaller batches are too noisy.
const MIN_TRIAL_PACKETS: usize = 32;

/// A tuner of two kernels, the first and the second.
#[derive(Clone, Copy, Debug)]
pub(super) struct KernelTuner {
    /// Seconds of tracing until the next trial.
    until_trial: f32,
    /// Trials so far, up to [`HISTORY`]; the initial estimate counts as one.
    trials: u32,
    /// Mean time of a packet in trials so far, for each kernel; before the first trial, in any
    /// unit. Times are averaged and not their quotients: rays that take long matter more.
    mean_time: [f32; 2],
    trial_penalty: f32,
    /// True if the second kernel was timed first in the last trial: the first one timed finds the
    /// caches cold.
    second_led: bool,
}

/// Kernels that trace a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    /// One kernel; true for the second. Its time goes to [`KernelTuner::record_time`].
    One(bool),
    /// Both kernels, a part each; their times go to [`KernelTuner::record_trial`].
    Trial(Trial),
}

/// Order of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Trial {
    /// Kernel that was not used recently: true for the second. It first traces some rays untimed,
    /// because its nodes have left the nearest caches, and the few rays of a trial take no longer
    /// than fetching those.
    cold: bool,
    /// Kernel that is timed first: true for the second.
    leads: bool,
}

impl KernelTuner {
    /// A tuner with an initial estimate: the logarithm of the first kernel's time relative to the
    /// second's. `trial_penalty` is the slowdown of the second kernel's packets in a trial,
    /// relative to a complete batch.
    pub(super) fn new(log_ratio: f32, trial_penalty: f32) -> KernelTuner {
        KernelTuner {
            // After one batch: memory is cold.
            until_trial: f32::MIN_POSITIVE,
            trials: 1,
            mean_time: [0.5, -0.5].map(|half| (log_ratio * half).exp()),
            trial_penalty,
            second_led: false,
        }
    }

    /// Traces a batch by one of the two kernels, or in a trial by both. `by` is called with the
    /// kernel, true for the second, and the packets. `parts` makes the parts of a trial: one that
    /// is not timed, and one for each kernel. Rays like these are known to have a log ratio that is
    /// `bias` more than that of all rays. Returns true if the second kernel is the faster for them.
    pub(super) fn trace(
        &mut self,
        bias: f32,
        batch: Range<usize>,
        parts: impl Fn(Range<usize>) -> [BatchSlice; 3],
        mut trace: impl FnMut(bool, &BatchSlice),
    ) -> bool {
        let packets = batch.len();
        let mut timed = |second: bool, part: &BatchSlice| {
            let start = Stopwatch::start();
            trace(second, part);
            start.elapsed().as_secs_f32()
        };
        match self.next(packets, bias) {
            Next::One(second) => {
                let seconds = timed(second, &BatchSlice::all(batch));
                self.record_time(seconds);
            }
            Next::Trial(Trial { cold, leads }) => {
                let [untimed, first, last] = parts(batch);
                timed(cold, &untimed);
                let mut times = [0.0; 2];
                for (second, part) in [(leads, first), (!leads, last)] {
                    times[usize::from(second)] = timed(second, &part) / part.count() as f32;
                }
                self.record_trial([times[0] * (-bias).exp(), times[1]], packets);
            }
        }
        self.log_ratio() + bias > 0.0
    }

    /// Logarithm of the first kernel's time relative to the second's.
    fn log_ratio(&self) -> f32 {
        (self.mean_time[0] / self.mean_time[1]).ln()
    }

    /// Chooses the kernels for the next batch, of the given number of packets.
    fn next(&mut self, packets: usize, bias: f32) -> Next {
        if self.until_trial > 0.0 || packets < MIN_TRIAL_PACKETS {
            return Next::One(self.log_ratio() + bias > 0.0);
        }
        self.second_led = !self.second_led;
        Next::Trial(Trial {
            cold: self.log_ratio() + bias <= 0.0,
            leads: self.second_led,
        })
    }

    /// Records the time of a batch without a trial, in seconds.
    fn record_time(&mut self, seconds: f32) {
        self.until_trial -= seconds;
    }

    /// Records the times per packet of the first and the second kernel, in seconds, in a trial of
    /// the given number of packets.
    fn record_trial(&mut self, [first, second]: [f32; 2], packets: usize) {
        let second = second / self.trial_penalty;
        // A stopped clock gives no measurement.
        if first > 0.0 && second > 0.0 {
            let [low, high] =
                [-MAX_LOG_STEP, MAX_LOG_STEP].map(|more| (self.log_ratio() + more).exp());
            let seen = [first.min(second * high), second.min(first / low)];
            if self.trials == 1 {
                // The initial estimate is scaled to the times of this trial.
                let middle = (seen[0] * seen[1]).sqrt();
                self.mean_time = self.mean_time.map(|times| times * middle);
            }
            self.trials = (self.trials + 1).min(HISTORY);
            for (times, seen) in self.mean_time.iter_mut().zip(seen) {
                *times += (seen - *times) / self.trials as f32;
            }
        }
        if self.trials == 1 {
            // The time of a trial is not known yet.
            self.until_trial = 0.0;
            return;
        }
        let most = MAX_INTERVAL_GROWTH * (self.trials * self.trials) as f32;
        // The means are used instead of this trial, in which a thread may have had to wait.
        let trial = (self.mean_time[0] + self.mean_time[1]) * 0.5 * packets as f32;
        self.until_trial =
            trial * (TRIAL_INTERVAL * self.log_ratio().abs()).clamp(MIN_INTERVAL, most);
    }
}

/// A tuner for each of several classes of rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct PerClassTuner<const N: usize>([KernelTuner; N]);

/// Share of a class's change that is applied to a class without trials; classes with more trials
/// change by less.
const CLASS_TRANSFER: f32 = 0.5;

impl<const N: usize> PerClassTuner<N> {
    /// Tuners with the initial estimates and the penalty of [`KernelTuner::new`].
    pub(super) fn new(log_ratios: [f32; N], trial_penalty: f32) -> PerClassTuner<N> {
        PerClassTuner(log_ratios.map(|ratio| KernelTuner::new(ratio, trial_penalty)))
    }

    /// Traces a batch of a class: see [`KernelTuner::trace`].
    pub(super) fn trace(
        &mut self,
        class: usize,
        bias: f32,
        batch: Range<usize>,
        parts: impl Fn(Range<usize>) -> [BatchSlice; 3],
        kernel: impl FnMut(bool, &BatchSlice),
    ) -> bool {
        self.shared(class, |tuner| tuner.trace(bias, batch, parts, kernel))
    }

    /// Updates one class, and raises the others' log ratios by a share of its change.
    fn shared<R>(&mut self, class: usize, record: impl FnOnce(&mut KernelTuner) -> R) -> R {
        let before = self.0[class].mean_time;
        let answer = record(&mut self.0[class]);
        if self.0[class].mean_time == before {
            return answer;
        }
        let more = self.0[class].log_ratio() - (before[0] / before[1]).ln();
        for (k, other) in self.0.iter_mut().enumerate() {
            if k != class {
                other.mean_time[0] *= (more * CLASS_TRANSFER / other.trials as f32).exp();
            }
        }
        answer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of halves of batches that each kernel traces, if a ray takes the time `time` in a
    /// half of a batch.
    fn shares(batches: u32, mut time: impl FnMut(u32, usize, bool) -> f32) -> [u32; 2] {
        let (mut choice, mut shares) = (KernelTuner::new(0.0, 1.0), [0, 0]);
        for batch in 0..batches {
            match choice.next(64, 0.0) {
                Next::One(second) => {
                    shares[usize::from(second)] += 2;
                    choice.record_time([0, 1].map(|half| time(batch, half, second)).iter().sum());
                }
                Next::Trial(Trial { leads, .. }) => {
                    let mut times = [0.0; 2];
                    for (half, second) in [leads, !leads].into_iter().enumerate() {
                        times[usize::from(second)] = time(batch, half, second);
                        shares[usize::from(second)] += 1;
                    }
                    choice.record_trial(times, 2);
                }
            }
        }
        shares
    }

    #[test]
    fn the_faster_one_has_nearly_all() {
        for slow in [1.2, 2.0, 10.0] {
            let [first, second] = shares(1024, |_, _, second| if second { 1.0 } else { slow });
            assert!(first < 120 && first > 5, "{first} {second}");
            let [first, second] = shares(1024, |_, _, second| if second { slow } else { 1.0 });
            assert!(second < 120 && second > 5, "{first} {second}");
        }
    }

    /// Checks that a small beam in a trial is not taken as a measure of a full one.
    #[test]
    fn a_part_is_not_held_against_the_second() {
        for (trial_penalty, second) in [(1.25, true), (1.0, false)] {
            let mut choice = KernelTuner::new(0.0, trial_penalty);
            for _ in 0..10 {
                choice.record_trial([1.0, 1.15], 64);
            }
            assert_eq!(choice.next(64, 0.0), Next::One(second));
        }
    }

    #[test]
    fn trials_of_a_class_adjust_the_others_until_they_have_their_own() {
        let mut choices = PerClassTuner::new([-0.2, -0.9, -0.1], 1.0);
        let second = |choices: &PerClassTuner<3>| choices.0.map(|choice| choice.log_ratio() > 0.0);
        assert_eq!(second(&choices), [false; 3]);
        // The second kernel is three times as fast for the first class, and so it may be for the
        // third.
        choices.shared(0, |choice| choice.record_trial([3.0, 1.0], 64));
        choices.shared(0, |choice| choice.record_trial([3.0, 1.0], 64));
        assert_eq!(second(&choices), [true, false, true]);
        // It is not, and the first class hardly changes.
        choices.shared(2, |choice| choice.record_trial([1.0, 3.0], 64));
        choices.shared(2, |choice| choice.record_trial([1.0, 3.0], 64));
        assert_eq!(second(&choices), [true, false, false]);
        // Each class waits for its own trial.
        choices.0[0].record_time(1e9);
        assert!(matches!(choices.0[0].next(64, 0.0), Next::Trial(_)));
        assert_eq!(choices.0[2].next(64, 0.0), Next::One(false));
    }

    #[test]
    fn small_batches_are_not_parted() {
        let mut choice = KernelTuner::new(-0.2, 1.0);
        for _ in 0..100 {
            assert_eq!(choice.next(MIN_TRIAL_PACKETS - 1, 0.0), Next::One(false));
            choice.record_time(1.0);
        }
        let trial = Trial {
            cold: true,
            leads: true,
        };
        assert_eq!(choice.next(MIN_TRIAL_PACKETS, 0.0), Next::Trial(trial));
    }

    #[test]
    fn what_is_faster_may_change() {
        let turns = |batch: u32, _, second: bool| if second == (batch < 3200) { 0.8 } else { 1.0 };
        let [first, second] = shares(6400, turns);
        assert!(first > 5400 && second > 5400, "{first} {second}");
    }

    /// Checks that rays that take no time do not matter: here most batches are of such rays, and
    /// the first kernel is faster for them.
    #[test]
    fn what_takes_long_decides() {
        let cheap = |batch: u32| batch / 64 % 4 != 3;
        let time = |batch, _, second| match (cheap(batch), second) {
            (true, false) => 0.01,
            (true, true) => 0.02,
            (false, false) => 1.5,
            (false, true) => 1.0,
        };
        let [first, second] = shares(3200, time);
        assert!(second > 8 * first, "{first} {second}");
    }

    /// Checks that one wait does not change the choice for long, whenever it occurs.
    #[test]
    fn a_wait_does_not_matter() {
        let few = shares(3200, |_, _, second| if second { 0.8 } else { 1.0 })[0];
        for late in 0..600 {
            let waits = |batch: u32, _, second: bool| {
                if !second {
                    1.0
                } else if batch == late {
                    1e4
                } else {
                    0.8
                }
            };
            let [first, second] = shares(3200, waits);
            assert!(
                first < few + 120,
                "{first} {second} after {late}, else {few}"
            );
        }
    }

    /// Checks that each kernel is timed first in turn: the first one takes longer, because memory
    /// is cold.
    #[test]
    fn neither_has_the_cold_half_always() {
        let cold = |_, half: usize, second: bool| {
            (if half == 0 { 1.5 } else { 1.0 }) * (if second { 1.0 } else { 1.15 })
        };
        let [first, second] = shares(2048, cold);
        assert!(second > 4 * first, "{first} {second}");
    }
}
