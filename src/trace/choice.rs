//! Which of two kernels is faster, found out on the way.
//!
//! Rays that have parted go faster as packets in an open scene and on their own in a closed one; shadow rays as a beam or as
//! packets. Nothing that can be seen of the rays tells, and the answer is the machine's, too. So now and then each kernel has
//! one half of a batch, and what took less time for a ray has those that follow. Halves of one batch and no whole ones: rays
//! that are far from each other may differ more than kernels do. Either gives the same bits.

use std::time::Duration;

/// Batches before the first trial: memory is cold.
const FIRST: u32 = 1;

/// Batches from one trial to the next: this times the logarithm of how many times as fast the faster kernel is. What is much
/// slower is tried seldom, what is nearly as fast costs nothing to try.
const PATIENCE: f32 = 64.0;

/// At least so many, and at most so many times the square of the trials so far: the first ones may mislead.
const OFTEN: u32 = 2;
const EARLY: u32 = 2;

/// Trials that count, about: older ones are forgotten.
const MEMORY: u32 = 8;

/// No trial says more than this, natural logarithm: a thread that had to wait is not slow.
const MOST: f32 = 1.0;

/// Packets of a batch that are worth a trial: the halves of fewer say little.
const WORTH: usize = 16;

/// A choice between two kernels, the first and the second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// Batches until the next trial.
    wait: u32,
    /// Trials so far, up to [`MEMORY`], what is believed from the beginning being one.
    trials: u32,
    /// Logarithm of how many times as long the first takes as the second.
    lead: f32,
    /// Whether the second kernel had the first half of the last trial: what comes first finds memory cold.
    second_led: bool,
}

/// Who traces a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// One of the two; true for the second.
    One(bool),
    /// Each one half, the second kernel the first half if true; [`Choice::learn`] is told what they took.
    Trial(bool),
}

impl Choice {
    /// A choice that believes this of the logarithm of how many times as long the first takes as the second.
    pub(super) fn new(lead: f32) -> Choice {
        Choice {
            wait: FIRST,
            trials: 1,
            lead,
            second_led: false,
        }
    }

    /// Who traces the next batch, of so many packets.
    pub(super) fn next(&mut self, packets: usize) -> Next {
        if self.wait > 0 || packets < WORTH {
            self.wait = self.wait.saturating_sub(1);
            return Next::One(self.lead > 0.0);
        }
        self.second_led = !self.second_led;
        Next::Trial(self.second_led)
    }

    /// What a ray took the first and the second kernel in a trial.
    pub(super) fn learn(&mut self, [first, second]: [f32; 2]) {
        self.trials = (self.trials + 1).min(MEMORY);
        // A clock that stands still says nothing.
        if first > 0.0 && second > 0.0 {
            let seen = (first / second).ln().clamp(-MOST, MOST);
            self.lead += (seen - self.lead) / self.trials as f32;
        }
        let most = EARLY * self.trials * self.trials;
        self.wait = ((PATIENCE * self.lead.abs()) as u32).clamp(OFTEN, most);
    }
}

/// Seconds for each of so many rays.
pub(super) fn each(took: Duration, rays: usize) -> f32 {
    took.as_secs_f32() / rays.max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halves of batches that each kernel gets, if a ray takes it so long in a half of a batch.
    fn shares(batches: u32, mut time: impl FnMut(u32, usize, bool) -> f32) -> [u32; 2] {
        let (mut choice, mut shares) = (Choice::new(0.0), [0, 0]);
        for batch in 0..batches {
            match choice.next(64) {
                Next::One(second) => shares[usize::from(second)] += 2,
                Next::Trial(second_leads) => {
                    let mut took = [0.0; 2];
                    for (half, second) in [second_leads, !second_leads].into_iter().enumerate() {
                        took[usize::from(second)] = time(batch, half, second);
                        shares[usize::from(second)] += 1;
                    }
                    choice.learn(took);
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

    #[test]
    fn small_batches_are_not_parted() {
        let mut choice = Choice::new(-0.2);
        for _ in 0..100 {
            assert_eq!(choice.next(WORTH - 1), Next::One(false));
        }
        assert_eq!(choice.next(WORTH), Next::Trial(true));
    }

    #[test]
    fn what_is_faster_may_change() {
        let turns = |batch: u32, _, second: bool| if second == (batch < 3200) { 0.8 } else { 1.0 };
        let [first, second] = shares(6400, turns);
        assert!(first > 5400 && second > 5400, "{first} {second}");
    }

    /// One wait is not believed for long, whenever it is.
    #[test]
    fn a_wait_does_not_matter() {
        let few = shares(3200, |_, _, second| if second { 0.8 } else { 1.0 })[0];
        for late in 0..600 {
            let waits = |batch: u32, _, second: bool| match second {
                true if batch == late => 1e4,
                true => 0.8,
                false => 1.0,
            };
            let [first, second] = shares(3200, waits);
            assert!(
                first < few + 120,
                "{first} {second} after {late}, else {few}"
            );
        }
    }

    /// What comes first in a trial takes longer, because memory is cold.
    #[test]
    fn neither_has_the_cold_half_always() {
        let cold = |_, half: usize, second: bool| {
            (if half == 0 { 1.5 } else { 1.0 }) * (if second { 1.0 } else { 1.15 })
        };
        let [first, second] = shares(2048, cold);
        assert!(second > 4 * first, "{first} {second}");
    }
}
