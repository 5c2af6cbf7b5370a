//! Dot plots: one line of the page per thing, one marker per engine, a logarithmic axis below and
//! above.

use super::axis::{LogAxis, TICK, paint_axis};
use super::number_format;
use super::svg::{MarkerShape, Tint, draw, line, marker, text};
use maud::{Markup, html};

/// A value with its interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dot {
    pub(super) value: f64,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Index of its colour and shape.
    pub(super) style: usize,
}

/// A line of the plot.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) label: String,
    /// Group of the line. Lines of one group are next to each other; a rule separates groups.
    pub(super) group: String,
    pub(super) dots: Vec<Dot>,
}

/// Sizes in pixels. The width is that of a narrow page, so that text has its own size there.
pub(super) const WIDTH: f64 = 360.0;
const LABELS: f64 = 114.0;
const RIGHT: f64 = WIDTH - 14.0;
/// Room for the labels of the upper axis, which only long plots have.
const TOP: [f64; 2] = [8.0, 24.0];
const LONG: usize = 20;
const STEP: f64 = 15.0;
const BOTTOM: f64 = 40.0;
/// Distance in pixels between engines of one line, so that none hides another.
const DODGE: f64 = 2.4;
/// Longest label, in characters that fit before the axis.
const LABEL_LENGTH: usize = 19;

/// A plot, or a note that there is nothing to show. `label` describes it for screen readers,
/// `caption` the axis; `mark` is a value with a rule of its own, such as 1 for ratios.
pub(super) fn dot_plot(label: &str, caption: &str, lines: &[Line], mark: Option<f64>) -> Markup {
    let dots = lines.iter().flat_map(|l| &l.dots);
    let values = dots.flat_map(|d| [d.value, d.low, d.high]).chain(mark);
    let Some(axis) = LogAxis::over(values, LABELS, RIGHT) else {
        return html! { p.note { "No rate to show." } };
    };
    let is_long = lines.len() > LONG;
    let top = TOP[usize::from(is_long)];
    let floor = top + STEP * lines.len() as f64 + 4.0;
    let ticks = axis.ticks(8.0, 6.0);
    let content = html! {
        (paint_axis(&ticks, (top - 4.0, floor), (0.5 * (LABELS + RIGHT), caption)))
        @if is_long {
            @for (x, label) in &ticks { (text((*x, top - 12.0), "middle", TICK, label)) }
        }
        @if let Some(x) = mark.map(|mark| axis.at(mark)) {
            (line(&[(x, top - 4.0), (x, floor)], Tint::Ink, 1.0))
        }
        @for (i, line) in lines.iter().enumerate() {
            (paint_line(line, &axis, top + STEP * i as f64))
            @if lines.get(i + 1).is_some_and(|next| next.group != line.group) {
                (rule(top + STEP * (i + 1) as f64))
            }
        }
    };
    draw((WIDTH, floor + BOTTOM), label, content)
}

/// A line between two groups.
fn rule(y: f64) -> Markup {
    line(&[(4.0, y), (RIGHT, y)], Tint::Grid, 1.0)
}

fn paint_line(line: &Line, axis: &LogAxis, top: f64) -> Markup {
    let y = top + 0.5 * STEP;
    let label = number_format::shortened(&line.label, LABEL_LENGTH);
    let middle = 0.5 * (line.dots.len() as f64 - 1.0);
    html! {
        (text((LABELS - 8.0, y), "end", (Tint::Ink, 11.0), &label))
        // Phalanx comes first and is painted last, on top.
        @for (k, dot) in line.dots.iter().enumerate().rev() {
            (paint_dot(dot, axis, y + DODGE * (k as f64 - middle)))
        }
    }
}

fn paint_dot(dot: &Dot, axis: &LogAxis, y: f64) -> Markup {
    let tint = Tint::Series(dot.style);
    let (low, high) = (axis.at(dot.low), axis.at(dot.high));
    html! {
        @if dot.low.is_finite() && dot.high.is_finite() && high - low > 0.5 {
            (line(&[(low, y), (high, y)], tint, 1.25))
        }
        (marker((axis.at(dot.value), y), (tint, MarkerShape::of(dot.style)), 3.2))
    }
}
