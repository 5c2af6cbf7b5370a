//! Change of a rate from one run to another, and its uncertainty.

use crate::RateRow;
use crate::statistics::{NORMAL, NORMAL_999, student};
use serde::Serialize;

/// Minimum number of rounds from which the uncertainty of a rate can be estimated.
const MIN_ROUNDS: usize = 3;

/// Half width of a rate's interval in standard errors of one run's rate. The interval holds another
/// run's rate 9 times in 10 (the normal distribution's 95 % quantile, of a difference of two).
const REACH: f64 = 1.644_853_626_951_472_7 * std::f64::consts::SQRT_2;

/// Least degrees of freedom of a group's scatter. For fewer rows [`student`] has no value, and such
/// a group decides nothing (`regressions.rs`).
const LEAST_FREE: usize = 3;

/// A change of a rate as a share of it: -0.1 is 10 % slower.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RateChange {
    /// The change itself.
    pub by: f64,
    /// Lower end of the change's 95 % interval; -1 where nothing is known of it.
    pub low: f64,
    /// Upper end of that interval; infinite where nothing is known of it.
    pub high: f64,
}

impl RateChange {
    /// Returns true if the whole interval is slower than by the threshold, such as 0.08.
    pub fn slower_than(&self, threshold: f64) -> bool {
        self.high < -threshold
    }

    /// Returns true if the whole interval is faster than by the threshold.
    pub fn faster_than(&self, threshold: f64) -> bool {
        self.low > threshold
    }

    /// Returns true if the whole interval is slower, or faster, than by the threshold.
    pub fn exceeds(&self, threshold: f64) -> bool {
        self.slower_than(threshold) || self.faster_than(threshold)
    }

    /// Returns true if the interval is known.
    pub fn is_known(&self) -> bool {
        self.high.is_finite()
    }
}

/// The logarithm of a rate, or of a ratio of rates, and its variance. The variance is infinite
/// where there are too few rounds to estimate it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LogRate {
    value: f64,
    variance: f64,
}

impl LogRate {
    /// Logarithm of one, which is exact.
    pub const ONE: LogRate = LogRate {
        value: 0.0,
        variance: 0.0,
    };

    /// A logarithm with its variance.
    pub fn new(value: f64, variance: f64) -> LogRate {
        LogRate { value, variance }
    }

    /// Logarithm of a row's rate; `None` if the row has no positive rate.
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

    /// Logarithm of the quotient of a later row's rate and an earlier one's; `None` if one of them
    /// has no positive rate.
    pub fn change_between(old: &RateRow, new: &RateRow) -> Option<LogRate> {
        Some(LogRate::of(new)?.over(LogRate::of(old)?))
    }

    /// Logarithm of the quotient.
    pub fn over(self, other: LogRate) -> LogRate {
        LogRate {
            value: self.value - other.value,
            variance: self.variance + other.variance,
        }
    }

    /// Logarithm of the geometric mean of rates with errors of their own; `None` if there are none.
    pub fn mean(all: &[LogRate]) -> Option<LogRate> {
        let count = all.len() as f64;
        (!all.is_empty()).then(|| LogRate {
            value: all.iter().map(|log| log.value).sum::<f64>() / count,
            variance: all.iter().map(|log| log.variance).sum::<f64>() / (count * count),
        })
    }

    /// The same value without its error.
    pub fn exactly(self) -> LogRate {
        LogRate {
            variance: 0.0,
            ..self
        }
    }

    /// The change, with the interval of a normal distribution.
    pub fn change(self) -> RateChange {
        self.within(NORMAL * self.variance.sqrt())
    }

    /// The change, with an interval that holds 999 of 1000.
    pub fn mostly(self) -> RateChange {
        self.within(NORMAL_999 * self.variance.sqrt())
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

/// The geometric mean of some rows' changes, each in units of its yardstick. The errors of the
/// yardsticks come on top.
///
/// Rows scatter by more than their own errors where a change does not affect all of them alike. So
/// the mean's error is estimated from their scatter, unless their own errors are larger. Where all
/// rows are in units of the same rates, an error of those rates moves all rows alike and is not in
/// the scatter.
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
    // If each row has its own yardstick, the mean's variance is right. If all rows share one, it is
    // too small by a factor of their number.
    let common = yardstick.variance * if shared { count } else { 1.0 };
    let variance = f64::max(scatter, mean.variance) + common;
    LogRate { variance, ..mean }.within(student(free) * variance.sqrt())
}
