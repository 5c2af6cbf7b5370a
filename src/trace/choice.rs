//! Which of two kernels is faster, found out on the way.
//!
//! Rays that have parted go faster as packets in an open scene and on their own in a closed one; shadow rays as a beam or as
//! packets. Nothing that can be seen of the rays tells, and the answer is the machine's, too. So batches are timed, and now and
//! then one is given to the kernel that seems slower, and compared with those before and after it. Either gives the same bits.

use std::time::Duration;

/// Batches before the first trial: memory is cold.
const FIRST: u32 = 2;

/// Batches from one trial to the next: this times the logarithm of how many times as fast the faster kernel is. What is much
/// slower is tried seldom, what is nearly as fast costs nothing to try.
const PATIENCE: f32 = 64.0;

/// At least so many, and at most so many times the square of the trials so far: the first ones may mislead.
const OFTEN: u32 = 2;
const EARLY: u32 = 3;

/// Trials that count, about: older ones are forgotten.
const MEMORY: u32 = 8;

/// No trial says more than this, natural logarithm: a thread that had to wait is not slow.
const MOST: f32 = 1.0;

/// A choice between two kernels, the first and the second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// Batches until the next trial.
    wait: u32,
    /// Trials so far, up to [`MEMORY`], what is believed from the beginning being one.
    trials: u32,
    /// Logarithm of how many times as long the first takes as the second.
    lead: f32,
    /// Logarithms of the time for a ray: in the last batch that was no trial, and in a trial since then.
    usual: Option<f32>,
    tried: Option<f32>,
}

impl Choice {
    /// A choice that believes this of the logarithm of how many times as long the first takes as the second.
    pub(super) fn new(lead: f32) -> Choice {
        Choice {
            wait: FIRST,
            trials: 1,
            lead,
            usual: None,
            tried: None,
        }
    }

    /// Whether the next batch is for the second kernel.
    pub(super) fn second(&self) -> bool {
        (self.lead > 0.0) != self.is_trial()
    }

    /// Whether the next batch is a trial of what seems slower.
    pub(super) fn is_trial(&self) -> bool {
        self.wait == 0
    }

    /// The batch is done: so many rays in this time.
    pub(super) fn done(&mut self, rays: usize, took: Duration) {
        let each = (took.as_secs_f32() / rays.max(1) as f32).ln();
        // A clock that stands still says nothing.
        let each = each.is_finite().then_some(each);
        if self.is_trial() {
            self.tried = each;
            self.wait = OFTEN;
            return;
        }
        self.wait -= 1;
        let turned = match (self.usual, self.tried.take(), each) {
            (Some(before), Some(tried), Some(after)) => self.learn(tried - 0.5 * (before + after)),
            _ => false,
        };
        // After a turn, what was usual was the other kernel's.
        self.usual = match turned {
            true => None,
            false => each.or(self.usual),
        };
    }

    /// A trial took so much longer than usual, as a logarithm; true if that changes the choice.
    fn learn(&mut self, longer: f32) -> bool {
        let seen = if self.lead > 0.0 { longer } else { -longer };
        self.trials = (self.trials + 1).min(MEMORY);
        let before = self.lead;
        self.lead += (seen.clamp(-MOST, MOST) - self.lead) / self.trials as f32;
        let most = EARLY * self.trials * self.trials;
        self.wait = ((PATIENCE * self.lead.abs()) as u32).clamp(OFTEN, most);
        (self.lead > 0.0) != (before > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Batches that each kernel gets, if a ray takes it so long.
    fn shares(rounds: u32, nanoseconds: impl Fn(u32, bool) -> u64) -> [u32; 2] {
        let (mut choice, mut shares) = (Choice::new(0.0), [0, 0]);
        for round in 0..rounds {
            let second = choice.second();
            let took = Duration::from_nanos(512 * nanoseconds(round, second));
            shares[usize::from(second)] += 1;
            choice.done(512, took);
        }
        shares
    }

    /// Twenty percent: one trial in about eleven batches.
    #[test]
    fn the_faster_one_has_nearly_all() {
        for slow in [120, 200, 1000] {
            let [first, second] = shares(1024, |_, second| if second { 100 } else { slow });
            assert!(first < 100 && first > 5, "{first} {second}");
            let [first, second] = shares(1024, |_, second| if second { slow } else { 100 });
            assert!(second < 100 && second > 5, "{first} {second}");
        }
    }

    #[test]
    fn what_is_faster_may_change() {
        let turns = |round: u32, second: bool| if second == (round < 3200) { 80 } else { 100 };
        let [first, second] = shares(6400, turns);
        assert!(first > 2700 && second > 2700, "{first} {second}");
    }

    /// One wait is not believed for long, whenever it is.
    #[test]
    fn a_wait_does_not_matter() {
        let few = shares(3200, |_, second| if second { 80 } else { 100 })[0];
        for late in 0..600 {
            let waits = |round: u32, second: bool| match second {
                true if round == late => 1_000_000,
                true => 80,
                false => 100,
            };
            let [first, second] = shares(3200, waits);
            assert!(
                first < few + 60,
                "{first} {second} after {late}, else {few}"
            );
        }
    }

    /// Batches of very different rays: what is faster by a third is found out all the same.
    #[test]
    fn batches_may_differ() {
        let mut state = 1u32;
        for _ in 0..50 {
            let factor: Vec<u64> = (0..256)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    50 + u64::from(state >> 16) % 100
                })
                .collect();
            let mixed =
                |round: u32, second: bool| factor[round as usize] * if second { 3 } else { 4 };
            let [first, second] = shares(256, mixed);
            assert!(second > 150, "{first} {second}");
        }
    }
}
