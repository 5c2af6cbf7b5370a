//! Dot plots: one line of the page per thing, one marker per engine, a logarithmic axis below and
//! above.

use super::axis::{LogAxis, TICK, paint_axis};
use super::svg::{MarkerShape, Point, Tint, draw, line, marker, named, text};
use crate::text::shortened;
use maud::{Markup, html};

/// A value with its interval.
#[derive(Clone, Debug)]
pub(super) struct Dot {
    /// Name and value in words, shown when the pointer is over the dot.
    pub(super) name: String,
    /// Letter beside the dot, where there is room; empty for none.
    pub(super) letter: String,
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
    let label = shortened(&line.label, LABEL_LENGTH);
    let middle = 0.5 * (line.dots.len() as f64 - 1.0);
    html! {
        (text((LABELS - 8.0, y), "end", (Tint::Ink, 11.0), &label))
        @for (letter, position) in letters(line, axis, y) {
            (text(position.0, position.1, (Tint::Muted, LETTER_SIZE), letter))
        }
        // Phalanx comes first and is painted last, on top.
        @for (k, dot) in line.dots.iter().enumerate().rev() {
            (paint_dot(dot, axis, y + DODGE * (k as f64 - middle)))
        }
    }
}

/// Size of letters beside dots, and the room that one takes, in pixels.
const LETTER_SIZE: f64 = 10.5;
const LETTER_ROOM: f64 = 13.0;

/// Letters of a line's dots, each with its position and its end there: to the right of the dot, or
/// to the left where another dot is in the way. Where both sides are taken there is none.
fn letters<'l>(line: &'l Line, axis: &LogAxis, y: f64) -> Vec<(&'l str, (Point, &'static str))> {
    let mut taken: Vec<(f64, f64)> = line
        .dots
        .iter()
        .map(|dot| (axis.at(dot.value) - 4.0, axis.at(dot.value) + 4.0))
        .collect();
    let mut all = Vec::new();
    for (i, dot) in line
        .dots
        .iter()
        .enumerate()
        .filter(|(_, dot)| !dot.letter.is_empty())
    {
        let x = axis.at(dot.value);
        let sides = [
            ((x + 4.5, x + LETTER_ROOM), x + 5.5, "start"),
            ((x - LETTER_ROOM, x - 4.5), x - 5.5, "end"),
        ];
        let is_free = |&((from, to), ..): &((f64, f64), f64, &str)| {
            let mut others = taken.iter().enumerate().filter(|(k, _)| *k != i);
            from > LABELS && to < WIDTH && others.all(|(_, other)| to < other.0 || other.1 < from)
        };
        if let Some((room, at, anchor)) = sides.into_iter().find(is_free) {
            taken.push(room);
            all.push((dot.letter.as_str(), ((at, y), anchor)));
        }
    }
    all
}

fn paint_dot(dot: &Dot, axis: &LogAxis, y: f64) -> Markup {
    let tint = Tint::Series(dot.style);
    let (low, high) = (axis.at(dot.low), axis.at(dot.high));
    let picture = html! {
        @if dot.low.is_finite() && dot.high.is_finite() && high - low > 0.5 {
            (line(&[(low, y), (high, y)], tint, 1.25))
        }
        (marker((axis.at(dot.value), y), (tint, MarkerShape::of(dot.style)), 3.2))
    };
    named(&dot.name, picture)
}
