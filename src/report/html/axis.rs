//! Axes: the mapping of numbers to positions, and the round numbers along them.

use super::svg::{Tint, line, text};
use crate::numbers;
use maud::{Markup, html};

/// Numbers from `low` to `high` on positions from one to another, in pixels. On a logarithmic axis
/// `low` and `high` are natural logarithms.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    logarithmic: bool,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

/// A round number along an axis: its position and its text.
type Tick = (f64, String);

impl Axis {
    /// A logarithmic axis that shows every positive finite value, with some room at both ends. None
    /// if there is no such value.
    pub(super) fn log(values: impl IntoIterator<Item = f64>, from: f64, to: f64) -> Option<Axis> {
        let (low, high) = range(values.into_iter().map(f64::ln))?;
        // At least a factor of two, so that noise does not fill the picture.
        let half = 0.54 * (high - low).max(2.0_f64.ln());
        let middle = 0.5 * (low + high);
        Some(Axis {
            logarithmic: true,
            low: middle - half,
            high: middle + half,
            from,
            to,
        })
    }

    /// A linear axis that shows every finite value, with some room at both ends. None if there is
    /// no such value.
    pub(super) fn linear(
        values: impl IntoIterator<Item = f64>,
        from: f64,
        to: f64,
    ) -> Option<Axis> {
        let (low, high) = range(values)?;
        let room = 0.05 * (high - low).max(1e-3);
        Some(Axis {
            logarithmic: false,
            low: low - room,
            high: high + room,
            from,
            to,
        })
    }

    /// The position of a value; a value that has none is at the nearer end.
    pub(super) fn position(&self, value: f64) -> f64 {
        let number = if self.logarithmic { value.ln() } else { value };
        let share = (number - self.low) / (self.high - self.low);
        let share = if share.is_nan() { 0.0 } else { share };
        self.from + share.clamp(0.0, 1.0) * (self.to - self.from)
    }

    /// Round numbers along a logarithmic axis. Their middles are at least `gap` pixels apart, and
    /// `letter` pixels more for each letter of the longer one.
    pub(super) fn ticks(&self, gap: f64, letter: f64) -> Vec<Tick> {
        let series: [&[u32]; 5] = [
            &[
                10, 12, 14, 16, 18, 20, 25, 30, 35, 40, 45, 50, 60, 70, 80, 90,
            ],
            &[10, 15, 20, 30, 40, 50, 60, 80],
            &[10, 20, 50],
            &[10, 30],
            &[10],
        ];
        // Between two labels there must be room.
        let apart = |a: &Tick, b: &Tick| {
            let letters = a.1.chars().count().max(b.1.chars().count());
            (a.0 - b.0).abs() >= gap + letter * letters as f64
        };
        let fits = |ticks: &Vec<Tick>| ticks.windows(2).all(|pair| apart(&pair[0], &pair[1]));
        let mut ticks = series.iter().map(|digits| self.ticks_of(digits));
        ticks.find(fits).unwrap_or_else(|| {
            // Every n-th power of ten.
            let mut sparse: Vec<Tick> = Vec::new();
            for tick in self.ticks_of(&[10]) {
                if sparse.last().is_none_or(|last| apart(last, &tick)) {
                    sparse.push(tick);
                }
            }
            sparse
        })
    }

    /// Multiples of powers of ten, by their first two digits.
    fn ticks_of(&self, digits: &[u32]) -> Vec<Tick> {
        let (low, high) = (self.low.exp(), self.high.exp());
        let numbers = (-13..=14).flat_map(|power| digits.iter().map(move |d| (*d, power)));
        // Parsed from text, because a product of tens is not the number that it prints as.
        let numbers = numbers.filter_map(|(d, power)| format!("{d}e{power}").parse::<f64>().ok());
        let inside = numbers.filter(|n| (low..=high).contains(n));
        inside
            .map(|n| (self.position(n), numbers::short(n)))
            .collect()
    }

    /// Some six round numbers along a linear axis.
    pub(super) fn steps(&self) -> Vec<Tick> {
        const MOST: f64 = 6.0;
        let numbers = (-6..=15).flat_map(|power| [1, 2, 5].map(|d| format!("{d}e{power}")));
        let mut steps = numbers.filter_map(|text| text.parse::<f64>().ok());
        let Some(step) = steps.find(|step| (self.high - self.low) / step <= MOST) else {
            return Vec::new();
        };
        let first = (self.low / step).ceil();
        let numbers = (0..=MOST as u32).map(|i| (first + f64::from(i)) * step);
        let inside = numbers.filter(|n| *n <= self.high);
        let ticks = inside.map(|n| (self.position(n), numbers::step(n, step)));
        ticks.collect()
    }

    /// The numbers of an axis below `floor` with a line up to `top` each, and the axis's caption.
    pub(super) fn paint(&self, ticks: &[Tick], (top, floor): (f64, f64), caption: &str) -> Markup {
        let middle = 0.5 * (self.from + self.to);
        html! {
            @for (x, label) in ticks {
                (line(&[(*x, top), (*x, floor)], Tint::Grid, 1.0))
                (text((*x, floor + 10.0), "middle", TICK, label))
            }
            (text((middle, floor + 27.0), "middle", (Tint::Muted, 11.0), caption))
        }
    }
}

/// The range of the finite numbers; none if there are none.
fn range(numbers: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let good = numbers.into_iter().filter(|n| n.is_finite());
    let ends = good.map(|n| (n, n));
    ends.reduce(|(low, high), (n, _)| (n.min(low), n.max(high)))
}

/// Colour and size of the texts along an axis.
pub(super) const TICK: (Tint, f64) = (Tint::Muted, 10.5);

/// Grid and labels of two logarithmic axes.
pub(super) fn paint_axes((x, y): (&Axis, &Axis), below: &str, floor: f64) -> Markup {
    html! {
        (x.paint(&x.ticks(9.0, 6.0), (y.to, floor), below))
        @for (height, label) in y.ticks(18.0, 0.0) {
            (line(&[(x.from, height), (x.to, height)], Tint::Grid, 1.0))
            (text((x.from - 5.0, height), "end", TICK, &label))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_apart() {
        let axis = Axis::log([0.5, 60.0, f64::NAN, -1.0], 0.0, 240.0).unwrap();
        let ticks = axis.ticks(6.0, 6.0);
        let texts: Vec<&str> = ticks.iter().map(|t| t.1.as_str()).collect();
        assert_eq!(texts, ["0.5", "1", "2", "5", "10", "20", "50"]);
        let narrow = Axis::log([12.5], 0.0, 240.0).unwrap();
        let texts: Vec<String> = narrow.ticks(6.0, 6.0).into_iter().map(|t| t.1).collect();
        assert_eq!(texts, ["9", "10", "12", "14", "16", "18"]);
        assert!(axis.position(0.5) > 0.0 && axis.position(60.0) < 240.0);
        assert_eq!(axis.position(f64::NAN), 0.0);
        assert_eq!(axis.position(1e300), 240.0);
        let wide = Axis::log([1e-12, 1e15], 0.0, 100.0).unwrap();
        assert!(wide.ticks(30.0, 0.0).len() <= 4);
        assert!(Axis::log([f64::NAN, 0.0, -3.0], 0.0, 1.0).is_none());
    }

    #[test]
    fn linear_axes_have_few_round_numbers() {
        let texts = |low, high| {
            let axis = Axis::linear([low, high, f64::NAN], 0.0, 100.0).unwrap();
            let ticks = axis.steps().into_iter();
            ticks.map(|t| t.1).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(texts(1.0, 2.0), "1.0 1.2 1.4 1.6 1.8 2.0");
        assert_eq!(texts(1.0, 64.0), "0 20 40 60");
        assert_eq!(
            texts(1.0, 4e9),
            "0 1000000000 2000000000 3000000000 4000000000"
        );
        assert!(Axis::linear([f64::INFINITY], 0.0, 1.0).is_none());
    }
}
