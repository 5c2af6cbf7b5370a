//! Axes: the mapping of numbers to positions, and the round numbers along them.

use super::number_format;
use super::svg::{Tint, line, text};
use maud::{Markup, html};

/// Numbers from `low` to `high` on positions from one to another, in pixels.
#[derive(Clone, Copy, Debug)]
struct AxisRange {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl AxisRange {
    /// The range of the finite numbers; none where there are none.
    fn over(numbers: impl IntoIterator<Item = f64>, from: f64, to: f64) -> Option<AxisRange> {
        let mut good = numbers.into_iter().filter(|n| n.is_finite());
        let first = good.next()?;
        let (low, high) = good.fold((first, first), |(low, high), n| (n.min(low), n.max(high)));
        Some(AxisRange {
            low,
            high,
            from,
            to,
        })
    }

    /// The position of a number; a number that has none is at the nearer end.
    fn at(&self, number: f64) -> f64 {
        let share = (number - self.low) / (self.high - self.low);
        let share = if share.is_nan() { 0.0 } else { share };
        self.from + share.clamp(0.0, 1.0) * (self.to - self.from)
    }
}

/// A logarithmic axis; its range is of natural logarithms.
#[derive(Clone, Debug)]
pub(super) struct LogAxis(AxisRange);

impl LogAxis {
    /// An axis that shows every positive finite value, with some room at both ends. None where
    /// there is no such value.
    pub(super) fn over(
        values: impl IntoIterator<Item = f64>,
        from: f64,
        to: f64,
    ) -> Option<LogAxis> {
        let mut range = AxisRange::over(values.into_iter().map(f64::ln), from, to)?;
        // At least a factor of two, so that noise does not fill the picture.
        let half = 0.54 * (range.high - range.low).max(2.0_f64.ln());
        let middle = 0.5 * (range.low + range.high);
        (range.low, range.high) = (middle - half, middle + half);
        Some(LogAxis(range))
    }

    /// The position of a value; a value that has none is at the nearer end.
    pub(super) fn at(&self, value: f64) -> f64 {
        self.0.at(value.ln())
    }

    /// The values at both ends.
    pub(super) fn ends(&self) -> (f64, f64) {
        (self.0.low.exp(), self.0.high.exp())
    }

    /// Round numbers along the axis and their texts. Their middles are at least `gap` pixels apart,
    /// and `letter` pixels more for each letter of the longer one.
    pub(super) fn ticks(&self, gap: f64, letter: f64) -> Vec<(f64, String)> {
        let wanted: [&[u32]; 5] = [
            &[
                10, 12, 14, 16, 18, 20, 25, 30, 35, 40, 45, 50, 60, 70, 80, 90,
            ],
            &[10, 15, 20, 30, 40, 50, 60, 80],
            &[10, 20, 50],
            &[10, 30],
            &[10],
        ];
        let fits = |ticks: &Vec<(f64, String)>| {
            let mut pairs = ticks.windows(2);
            pairs.all(|pair| are_apart(&pair[0], &pair[1], gap, letter))
        };
        let series = wanted.iter().map(|digits| self.ticks_of(digits));
        let mut series = series.filter(fits);
        match series.next() {
            Some(ticks) => ticks,
            None => self.sparse(gap, letter),
        }
    }

    /// Every n-th power of ten.
    fn sparse(&self, gap: f64, letter: f64) -> Vec<(f64, String)> {
        let mut kept: Vec<(f64, String)> = Vec::new();
        for tick in self.ticks_of(&[10]) {
            let last = kept.last();
            if last.is_none_or(|last| are_apart(last, &tick, gap, letter)) {
                kept.push(tick);
            }
        }
        kept
    }

    /// Multiples of powers of ten, by their first two digits.
    fn ticks_of(&self, digits: &[u32]) -> Vec<(f64, String)> {
        let (low, high) = self.ends();
        let numbers = (-13..=14).flat_map(|power| digits.iter().map(move |d| (*d, power)));
        // Parsed from text, because a product of tens is not the number that it prints as.
        let numbers = numbers.filter_map(|(d, power)| format!("{d}e{power}").parse::<f64>().ok());
        let inside = numbers.filter(|n| (low..=high).contains(n));
        inside
            .map(|n| (self.at(n), number_format::short(n)))
            .collect()
    }
}

/// Returns true if there is room between two labels.
fn are_apart(a: &(f64, String), b: &(f64, String), gap: f64, letter: f64) -> bool {
    let letters = a.1.chars().count().max(b.1.chars().count());
    (a.0 - b.0).abs() >= gap + letter * letters as f64
}

/// A linear axis.
#[derive(Clone, Debug)]
pub(super) struct LinearAxis(AxisRange);

impl LinearAxis {
    /// An axis that shows every finite value, with some room at both ends. None where there is no
    /// such value.
    pub(super) fn over(
        values: impl IntoIterator<Item = f64>,
        from: f64,
        to: f64,
    ) -> Option<LinearAxis> {
        let mut range = AxisRange::over(values, from, to)?;
        let room = 0.05 * (range.high - range.low).max(1e-3);
        (range.low, range.high) = (range.low - room, range.high + room);
        Some(LinearAxis(range))
    }

    /// The position of a value; a value that has none is at the nearer end.
    pub(super) fn at(&self, value: f64) -> f64 {
        self.0.at(value)
    }

    /// Some six round numbers along the axis, and their texts.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        const MOST: f64 = 6.0;
        let AxisRange { low, high, .. } = self.0;
        let numbers = (-6..=15).flat_map(|power| [1, 2, 5].map(|d| format!("{d}e{power}")));
        let mut steps = numbers.filter_map(|text| text.parse::<f64>().ok());
        let Some(step) = steps.find(|step| (high - low) / step <= MOST) else {
            return Vec::new();
        };
        let first = (low / step).ceil();
        let numbers = (0..=MOST as u32).map(|i| (first + f64::from(i)) * step);
        let inside = numbers.filter(|n| *n <= high);
        inside
            .map(|n| (self.at(n), number_format::step(n, step)))
            .collect()
    }
}

/// Colour and size of the texts along an axis.
pub(super) const TICK: (Tint, f64) = (Tint::Muted, 10.5);

/// The numbers of an axis below `floor` with a line up to `top` each, and the axis's caption.
pub(super) fn paint_axis(
    ticks: &[(f64, String)],
    (top, floor): (f64, f64),
    (middle, caption): (f64, &str),
) -> Markup {
    html! {
        @for (x, label) in ticks {
            (line(&[(*x, top), (*x, floor)], Tint::Grid, 1.0))
            (text((*x, floor + 10.0), "middle", TICK, label))
        }
        (text((middle, floor + 27.0), "middle", (Tint::Muted, 11.0), caption))
    }
}

/// Grid and labels of two logarithmic axes.
pub(super) fn paint_axes((x, y): (&LogAxis, &LogAxis), below: &str, floor: f64) -> Markup {
    let (left, right, top) = (x.0.from, x.0.to, y.0.to);
    html! {
        (paint_axis(&x.ticks(9.0, 6.0), (top, floor), (0.5 * (left + right), below)))
        @for (height, label) in y.ticks(18.0, 0.0) {
            (line(&[(left, height), (right, height)], Tint::Grid, 1.0))
            (text((left - 5.0, height), "end", TICK, &label))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_apart() {
        let axis = LogAxis::over([0.5, 60.0, f64::NAN, -1.0], 0.0, 240.0).unwrap();
        let ticks = axis.ticks(6.0, 6.0);
        let texts: Vec<&str> = ticks.iter().map(|t| t.1.as_str()).collect();
        assert_eq!(texts, ["0.5", "1", "2", "5", "10", "20", "50"]);
        let narrow = LogAxis::over([12.5], 0.0, 240.0).unwrap();
        let texts: Vec<String> = narrow.ticks(6.0, 6.0).into_iter().map(|t| t.1).collect();
        assert_eq!(texts, ["9", "10", "12", "14", "16", "18"]);
        assert!(axis.at(0.5) > 0.0 && axis.at(60.0) < 240.0);
        assert_eq!(axis.at(f64::NAN), 0.0);
        assert_eq!(axis.at(1e300), 240.0);
        let wide = LogAxis::over([1e-12, 1e15], 0.0, 100.0).unwrap();
        assert!(wide.ticks(30.0, 0.0).len() <= 4);
        assert!(LogAxis::over([f64::NAN, 0.0, -3.0], 0.0, 1.0).is_none());
    }

    #[test]
    fn linear_axes_have_few_round_numbers() {
        let texts = |low, high| {
            let axis = LinearAxis::over([low, high, f64::NAN], 0.0, 100.0).unwrap();
            let ticks = axis.ticks().into_iter();
            ticks.map(|t| t.1).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(texts(1.0, 2.0), "1.0 1.2 1.4 1.6 1.8 2.0");
        assert_eq!(texts(1.0, 64.0), "0 20 40 60");
        assert_eq!(
            texts(1.0, 4e9),
            "0 1000000000 2000000000 3000000000 4000000000"
        );
        assert!(LinearAxis::over([f64::INFINITY], 0.0, 1.0).is_none());
    }
}
