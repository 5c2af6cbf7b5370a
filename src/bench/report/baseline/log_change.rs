//! How much a rate changed from one run to another, and how sure that is.

use crate::report::RateRow;
use crate::report::statistics::{NORMAL, student};

/// Fewer rounds than this say nothing of how sure a rate is.
const MIN_ROUNDS: usize = 3;

/// An interval of a rate holds another run's 9 times in 10: that many standard errors of one run's
/// rate lie between its middle and either end (the normal distribution's 95 % quantile, of a
/// difference of two).
const REACH: f64 = 1.644_853_626_951_472_7 * std::f64::consts::SQRT_2;

/// Degrees of freedom of a group's scatter at least: of fewer rows [`student`] knows nothing, and
/// such a group decides nothing (`judge.rs`).
const LEAST_FREE: usize = 3;

/// A change of a rate as a share of it: -0.1 is 10 % slower.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateChange {
    /// The change itself.
    pub by: f64,
    /// Lower end of its 95 % interval; -1 where nothing is known of it.
    pub low: f64,
    /// Upper end; infinite where nothing is known of it.
    pub high: f64,
}

impl RateChange {
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

/// The logarithm of a rate, or of a ratio of rates, and its variance; infinite where too few rounds
/// say nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LogRate {
    value: f64,
    variance: f64,
}

impl LogRate {
    /// Of one; exactly.
    pub const ONE: LogRate = LogRate {
        value: 0.0,
        variance: 0.0,
    };

    /// Of a row's rate; `None` where it has none that is positive.
    pub fn of(row: &RateRow) -> Option<LogRate> {
        let rate = row.mrays_per_s;
        let usable = rate.low > 0.0 && rate.median > 0.0 && rate.high.is_finite();
        let enough = row.samples.len() >= MIN_ROUNDS;
        let error = libm::log(rate.high / rate.low) / 2.0 / REACH;
        (usable && !row.samples.is_empty()).then(|| LogRate {
            value: libm::log(rate.median),
            variance: if enough { error * error } else { f64::INFINITY },
        })
    }

    /// Of the quotient.
    pub fn over(self, other: LogRate) -> LogRate {
        LogRate {
            value: self.value - other.value,
            variance: self.variance + other.variance,
        }
    }

    /// Of the geometric mean of rates with errors of their own; `None` where there are none.
    pub fn mean(all: &[LogRate]) -> Option<LogRate> {
        let count = all.len() as f64;
        (!all.is_empty()).then(|| LogRate {
            value: all.iter().map(|log| log.value).sum::<f64>() / count,
            variance: all.iter().map(|log| log.variance).sum::<f64>() / (count * count),
        })
    }

    /// Without its error.
    pub fn exactly(self) -> LogRate {
        LogRate {
            variance: 0.0,
            ..self
        }
    }

    /// As a change, with a normal distribution's interval.
    pub fn change(self) -> RateChange {
        self.within(NORMAL * self.variance.sqrt())
    }

    fn within(self, reach: f64) -> RateChange {
        let by = |log: f64| libm::exp(log) - 1.0;
        RateChange {
            by: by(self.value),
            low: by(self.value - reach),
            high: by(self.value + reach),
        }
    }
}

/// The geometric mean of some rows' changes, each in units of its yardstick, whose own errors come
/// on top.
///
/// Rows scatter by more than their own errors where a change does not do the same to all of them;
/// so it is by their scatter that the mean's error is judged, unless their own errors say more.
/// Where all are in units of the same rates, an error of those moves all rows alike and is in no
/// scatter.
pub(super) fn mean_change(rows: &[LogRate], yardsticks: &[LogRate], shared: bool) -> RateChange {
    let (Some(mean), Some(yardstick)) = (LogRate::mean(rows), LogRate::mean(yardsticks)) else {
        return LogRate::ONE.change();
    };
    let (count, free) = (
        rows.len() as f64,
        rows.len().saturating_sub(1).max(LEAST_FREE),
    );
    let off = rows.iter().map(|row| row.value - mean.value);
    let squares = off.map(|off| off * off);
    let scatter = squares.sum::<f64>() / free as f64 / count;
    // Of yardsticks that are each some row's own, the mean's variance is right; of one for all, it
    // is too small by their number.
    let common = yardstick.variance * if shared { count } else { 1.0 };
    let variance = f64::max(scatter, mean.variance) + common;
    LogRate { variance, ..mean }.within(student(free) * variance.sqrt())
}
