//! Dot plots: one line of the page per thing, one marker per engine, a logarithmic axis below and
//! above.

use super::axis::{Axis, TICK};
use super::svg::{Point, Tint, draw, figure, line, look, marker, named, text};
use crate::text::shortened;
use maud::{Markup, html};

/// A value with its interval.
#[derive(Clone, Debug)]
pub(super) struct Dot {
    /// Name and value in words, shown when the pointer is over the dot.
    name: String,
    /// Letter beside the dot, where there is room; empty for none.
    letter: String,
    value: f64,
    low: f64,
    high: f64,
    /// Index of its colour and shape.
    style: usize,
}

impl Dot {
    /// A value between its least and its greatest, without a letter.
    pub(super) fn new(name: String, style: usize, [low, value, high]: [f64; 3]) -> Dot {
        Dot {
            name,
            letter: String::new(),
            value,
            low,
            high,
            style,
        }
    }

    /// The dot of a record: its letter stands beside the dot and begins the name.
    pub(super) fn lettered(self, letter: &str) -> Dot {
        Dot {
            name: format!("{letter}: {}", self.name),
            letter: letter.to_owned(),
            ..self
        }
    }
}

/// A line of the plot.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) label: String,
    /// Group of the line. Lines of one group are next to each other; a rule separates groups.
    pub(super) group: String,
    pub(super) dots: Vec<Dot>,
}

impl Line {
    /// A line of no group.
    pub(super) fn new(label: &str, dots: impl IntoIterator<Item = Dot>) -> Line {
        Line {
            label: label.to_owned(),
            group: String::new(),
            dots: dots.into_iter().collect(),
        }
    }
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

/// A plot below its title; nothing where there are no dots. `label` describes it for screen
/// readers, `caption` the axis; `mark` is a value with a rule of its own, such as 1 for ratios.
pub(super) fn dot_figure(
    (title, more): (&str, &str),
    label: &str,
    (caption, mark): (&str, Option<f64>),
    lines: &[Line],
) -> Markup {
    if lines.iter().all(|line| line.dots.is_empty()) {
        html! {}
    } else {
        figure(title, more, dot_plot(label, caption, lines, mark))
    }
}

fn dot_plot(label: &str, caption: &str, lines: &[Line], mark: Option<f64>) -> Markup {
    let dots = lines.iter().flat_map(|l| &l.dots);
    let values = dots.flat_map(|d| [d.value, d.low, d.high]).chain(mark);
    let Some(axis) = Axis::log(values, LABELS, RIGHT) else {
        return html! { p.note { "No rate to show." } };
    };
    let is_long = lines.len() > LONG;
    let top = TOP[usize::from(is_long)];
    let floor = top + STEP * lines.len() as f64 + 4.0;
    let ticks = axis.ticks(8.0, 6.0);
    let content = html! {
        (axis.paint(&ticks, (top - 4.0, floor), caption))
        @if is_long {
            @for (x, label) in &ticks { (text((*x, top - 12.0), "middle", TICK, label)) }
        }
        @if let Some(x) = mark.map(|mark| axis.position(mark)) {
            (line(&[(x, top - 4.0), (x, floor)], Tint::Ink, 1.0))
        }
        @for (i, line_of_dots) in lines.iter().enumerate() {
            (paint_line(line_of_dots, &axis, top + STEP * i as f64))
            @if lines.get(i + 1).is_some_and(|next| next.group != line_of_dots.group) {
                @let y = top + STEP * (i + 1) as f64;
                (line(&[(4.0, y), (RIGHT, y)], Tint::Grid, 1.0))
            }
        }
    };
    draw((WIDTH, floor + BOTTOM), label, content)
}

fn paint_line(line: &Line, axis: &Axis, top: f64) -> Markup {
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
fn letters<'l>(line: &'l Line, axis: &Axis, y: f64) -> Vec<(&'l str, (Point, &'static str))> {
    let places = line.dots.iter().map(|dot| axis.position(dot.value));
    let mut taken: Vec<(f64, f64)> = places.map(|x| (x - 4.0, x + 4.0)).collect();
    let mut all = Vec::new();
    let has_letter = |(_, dot): &(usize, &Dot)| !dot.letter.is_empty();
    for (i, dot) in line.dots.iter().enumerate().filter(has_letter) {
        let x = axis.position(dot.value);
        let sides = [
            ((x + 4.5, x + LETTER_ROOM), x + 5.5, "start"),
            ((x - LETTER_ROOM, x - 4.5), x - 5.5, "end"),
        ];
        let is_free = |&((from, to), ..): &((f64, f64), f64, &str)| {
            let mut others = taken.iter().enumerate().filter(|(k, _)| *k != i);
            from > LABELS && to < WIDTH && others.all(|(_, other)| to < other.0 || other.1 < from)
        };
        if let Some((room, start, anchor)) = sides.into_iter().find(is_free) {
            taken.push(room);
            all.push((dot.letter.as_str(), ((start, y), anchor)));
        }
    }
    all
}

fn paint_dot(dot: &Dot, axis: &Axis, y: f64) -> Markup {
    let tint = Tint::Series(dot.style);
    let (low, high) = (axis.position(dot.low), axis.position(dot.high));
    let picture = html! {
        @if dot.low.is_finite() && dot.high.is_finite() && high - low > 0.5 {
            (line(&[(low, y), (high, y)], tint, 1.25))
        }
        (marker((axis.position(dot.value), y), look(dot.style), 3.2))
    };
    named(&dot.name, picture)
}
