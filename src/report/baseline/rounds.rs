//! Samples of two engines, taken in rounds, and how much their ratio changed from one run to another.

use crate::report::Row;
use crate::report::statistics::{self, Draw, ENOUGH, interval, median};

/// Fewer rounds than this say nothing of how sure a change is.
const SAYS_SOMETHING: usize = 3;

/// A change of a rate as a share of it: -0.1 is 10 % slower.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The change itself.
    pub by: f64,
    /// Lower end of its 95 % interval; -1 where nothing is known of it.
    pub low: f64,
    /// Upper end; infinite where nothing is known of it.
    pub high: f64,
}

impl Change {
    /// Whether the whole interval says slower than by the threshold, such as 0.08.
    pub fn slower_than(&self, threshold: f64) -> bool {
        self.high < -threshold
    }

    /// Whether the whole interval says faster than by the threshold.
    pub fn faster_than(&self, threshold: f64) -> bool {
        self.low > threshold
    }

    /// Whether an interval is known.
    pub fn is_known(&self) -> bool {
        self.high.is_finite()
    }
}

/// One row's rates, in units of the oracle's where it has one.
pub(super) enum Rounds {
    /// One rate a round. What slowed the machine in a round slowed both engines, and their ratio does not show it.
    Together(Vec<f64>),
    /// Rates of ours, and the oracle's of other rounds.
    Apart(Vec<f64>, Vec<f64>),
}

impl Rounds {
    /// Of a row and the oracle's; `None` where no positive rate is left.
    pub fn of(row: &Row, oracle: Option<&Row>) -> Option<Rounds> {
        let rounds = match oracle {
            None => Rounds::Together(positive(&row.samples)),
            Some(oracle) if oracle.samples.len() == row.samples.len() => {
                let pairs = row.samples.iter().zip(&oracle.samples);
                Rounds::Together(positive(&pairs.map(|(a, b)| a / b).collect::<Vec<_>>()))
            }
            Some(oracle) => Rounds::Apart(positive(&row.samples), positive(&oracle.samples)),
        };
        (rounds.count() > 0).then_some(rounds)
    }

    /// Rounds, of the engine that has fewer.
    fn count(&self) -> usize {
        match self {
            Rounds::Together(rates) => rates.len(),
            Rounds::Apart(ours, oracle) => ours.len().min(oracle.len()),
        }
    }

    fn middle(&self) -> f64 {
        match self {
            Rounds::Together(rates) => median(&mut rates.clone()),
            Rounds::Apart(ours, oracle) => median(&mut ours.clone()) / median(&mut oracle.clone()),
        }
    }

    fn drawn(&self, draw: &mut Draw, room: &mut Vec<f64>) -> f64 {
        match self {
            Rounds::Together(rates) => draw.median_of(rates, room),
            Rounds::Apart(ours, oracle) => {
                draw.median_of(ours, room) / draw.median_of(oracle, room)
            }
        }
    }

    /// The least and the greatest that the middle could be.
    fn extremes(&self) -> (f64, f64) {
        let ends = |rates: &[f64]| {
            let least = rates.iter().copied().fold(f64::INFINITY, f64::min);
            (least, rates.iter().copied().fold(0.0, f64::max))
        };
        match self {
            Rounds::Together(rates) => ends(rates),
            Rounds::Apart(ours, oracle) => {
                let ((low, high), (least, most)) = (ends(ours), ends(oracle));
                (low / most, high / least)
            }
        }
    }

    fn seed(&self) -> u64 {
        match self {
            Rounds::Together(rates) => statistics::seed(rates),
            Rounds::Apart(ours, oracle) => statistics::seed(ours) ^ statistics::seed(oracle),
        }
    }
}

fn positive(rates: &[f64]) -> Vec<f64> {
    let usable = |rate: &f64| rate.is_finite() && *rate > 0.0;
    rates.iter().copied().filter(usable).collect()
}

/// The change from one run's rounds to another's, and the ratios new ÷ old of resamples.
pub(super) fn change(old: &Rounds, new: &Rounds) -> (Change, Vec<f64>) {
    let mut room = Vec::new();
    let seed = old.seed().rotate_left(1) ^ new.seed();
    let ratios = statistics::resamples(seed, |draw| {
        new.drawn(draw, &mut room) / old.drawn(draw, &mut room)
    });
    let (low, high) = match old.count().min(new.count()) {
        0..SAYS_SOMETHING => (0.0, f64::INFINITY),
        SAYS_SOMETHING..ENOUGH => {
            let ((old_low, old_high), (low, high)) = (old.extremes(), new.extremes());
            (low / old_high, high / old_low)
        }
        count => interval(&ratios, count),
    };
    let change = Change {
        by: new.middle() / old.middle() - 1.0,
        low: low - 1.0,
        high: high - 1.0,
    };
    (change, ratios)
}
