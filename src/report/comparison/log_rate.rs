//! Change of a rate from one run to another, and its uncertainty.

use crate::RateRow;
use serde::Serialize;

/// The normal distribution's 97.5 % quantile.
const NORMAL: f64 = 1.959_963_984_540_054;

/// The normal distribution's 99.975 % quantile.
const NORMAL_9995: f64 = 3.480_756_404_346_242;

/// Minimum number of rounds from which the uncertainty of a rate can be estimated.
const MIN_ROUNDS: usize = 3;

/// Half width of a rate's interval in standard errors of one run's rate. The interval holds another
/// run's rate 9 times in 10 (the normal distribution's 95 % quantile, of a difference of two).
const REACH: f64 = 1.644_853_626_951_472_7 * std::f64::consts::SQRT_2;

/// A change of a rate as a share of it: -0.1 is 10 % slower.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RateChange {
    /// The change itself.
    pub by: f64,
    /// Lower end of the change's interval; -1 where nothing is known of it.
    pub low: f64,
    /// Upper end of that interval; infinite where nothing is known of it.
    pub high: f64,
}

impl RateChange {
    /// Returns true if the whole interval is slower than by the threshold, such as 0.08.
    pub fn slower_than(&self, threshold: f64) -> bool {
        self.high < -threshold
    }

    /// Returns true if the whole interval is slower, or faster, than by the threshold.
    pub fn exceeds(&self, threshold: f64) -> bool {
        self.slower_than(threshold) || self.low > threshold
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
    /// A logarithm with its variance.
    pub fn new(value: f64, variance: f64) -> LogRate {
        LogRate { value, variance }
    }

    /// Logarithm of a row's rate; `None` if the row has no positive rate.
    fn from_row(row: &RateRow) -> Option<LogRate> {
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
        Some(LogRate::from_row(new)?.over(LogRate::from_row(old)?))
    }

    /// The logarithm itself.
    pub fn value(self) -> f64 {
        self.value
    }

    /// Logarithm of the quotient by another rate's, which has a logarithm and a variance, too.
    pub fn beyond(self, value: f64, variance: f64) -> LogRate {
        LogRate {
            value: self.value - value,
            variance: self.variance + variance,
        }
    }

    /// Logarithm of the quotient.
    pub fn over(self, other: LogRate) -> LogRate {
        self.beyond(other.value, other.variance)
    }

    /// The change, with an interval that holds 95 of 100.
    pub fn change(self) -> RateChange {
        self.within(NORMAL * self.variance.sqrt())
    }

    /// The change, with an interval that holds 1999 of 2000.
    pub fn mostly(self) -> RateChange {
        self.within(NORMAL_9995 * self.variance.sqrt())
    }

    fn within(self, reach: f64) -> RateChange {
        let share = |log: f64| libm::exp(log) - 1.0;
        RateChange {
            by: share(self.value),
            low: share(self.value - reach),
            high: share(self.value + reach),
        }
    }
}
