//! Which of two kernels is faster, found out on the way.
//!
//! Rays that have parted go faster as packets in an open scene and on their own in a closed one; shadow rays as a beam or as
//! packets. Nothing that can be seen of the rays tells, and the answer is the machine's, too. So both are timed, now and
//! then, on batches that follow each other, and what was faster has the rest. Either gives the same bits.

use std::time::Duration;

/// Batches before the first comparison: both kernels' memory is cold.
const FIRST: u32 = 2;

/// Batches between two comparisons after the first, and at most: each time that the faster one stays the same, they are twice
/// as many. Two more are spent on each comparison, one by the slower kernel.
const OFTEN: u32 = 4;
const SELDOM: u32 = 128;

/// Share of a new comparison in what is believed.
const NEW: f32 = 0.5;

/// No comparison says more than this, natural logarithm: a thread that had to wait is not slow.
const MOST: f32 = 1.0;

/// A choice between two kernels, the first and the second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// Batches until the next comparison, and from that to the one after it.
    wait: u32,
    gap: u32,
    /// Logarithm of how many times as long the first takes as the second.
    lead: f32,
    /// What the first took for one ray, while the second is still to be timed.
    first: Option<f32>,
}

impl Choice {
    /// A choice that believes this of the logarithm of how many times as long the first takes as the second.
    pub(super) fn new(lead: f32) -> Choice {
        Choice {
            wait: FIRST,
            gap: OFTEN,
            lead,
            first: None,
        }
    }

    /// Whether the next batch is for the second kernel, and whether it is to be timed.
    pub(super) fn next(&self) -> (bool, bool) {
        match (self.wait, self.first) {
            (0, first) => (first.is_some(), true),
            _ => (self.lead > 0.0, false),
        }
    }

    /// The batch is done, of so many rays; `took` is its time, if it was to be timed.
    pub(super) fn done(&mut self, rays: usize, took: Option<Duration>) {
        let Some(took) = took else {
            self.wait = self.wait.saturating_sub(1);
            return;
        };
        let each = took.as_secs_f32() / rays.max(1) as f32;
        let Some(first) = self.first.take() else {
            self.first = Some(each);
            return;
        };
        // A clock that stands still says nothing.
        if first > 0.0 && each > 0.0 {
            let seen = (first / each).ln().clamp(-MOST, MOST);
            let before = self.lead;
            self.lead += (seen - self.lead) * NEW;
            let stays = (self.lead > 0.0) == (before > 0.0);
            self.gap = if stays {
                (2 * self.gap).min(SELDOM)
            } else {
                OFTEN
            };
        }
        self.wait = self.gap;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Batches that each kernel gets, of those that are not timed, if a ray takes it so long.
    fn shares(rounds: u32, nanoseconds: impl Fn(u32, bool) -> u64) -> [u32; 2] {
        let (mut choice, mut shares) = (Choice::new(0.0), [0, 0]);
        for round in 0..rounds {
            let (second, timed) = choice.next();
            let took = Duration::from_nanos(512 * nanoseconds(round, second));
            choice.done(512, timed.then_some(took));
            shares[usize::from(second)] += u32::from(!timed);
        }
        shares
    }

    #[test]
    fn the_faster_one_has_nearly_all() {
        let [first, second] = shares(320, |_, second| if second { 90 } else { 100 });
        assert!(first == FIRST && second > 290, "{first} {second}");
        let [first, second] = shares(320, |_, second| if second { 100 } else { 90 });
        assert!(first > 290 && second == 0, "{first} {second}");
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
        for late in 0..600 {
            let waits = |round: u32, second: bool| match second {
                true if round == late => 1_000_000,
                true => 80,
                false => 100,
            };
            let [first, second] = shares(3200, waits);
            assert!(first < 40, "{first} {second} after {late}");
        }
    }
}
