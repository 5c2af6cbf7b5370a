//! Dot plots: one line of the page per thing, one marker per engine, a logarithmic axis below and
//! above.

use super::axis::LogAxis;
use super::number_format;
use super::svg::{Anchor, Canvas, DrawError, MarkerShape, Point, Tint, draw};
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

/// A dot plot.
pub(super) struct DotPlot<'a> {
    /// Description of the content, for screen readers.
    pub(super) label: &'a str,
    /// Caption of the axis.
    pub(super) axis: &'a str,
    pub(super) lines: &'a [Line],
    /// A value with a rule of its own, such as 1 for ratios.
    pub(super) mark: Option<f64>,
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

impl DotPlot<'_> {
    /// The chart, or a note that there is nothing to show.
    pub(super) fn markup(&self) -> Markup {
        let values = self.lines.iter().flat_map(|l| &l.dots);
        let values = values
            .flat_map(|d| [d.value, d.low, d.high])
            .chain(self.mark);
        let Some(axis) = LogAxis::over(values, LABELS, RIGHT) else {
            return html! { p.note { "No rate to show." } };
        };
        let size = (WIDTH, self.floor() + BOTTOM);
        draw(size, self.label, |canvas| {
            self.paint_axis(canvas, &axis)?;
            self.paint_lines(canvas, &axis)
        })
    }

    fn is_long(&self) -> bool {
        self.lines.len() > LONG
    }

    /// Vertical position of the first line.
    fn top(&self) -> f64 {
        TOP[usize::from(self.is_long())]
    }

    /// Vertical position of the lower axis.
    fn floor(&self) -> f64 {
        self.top() + STEP * self.lines.len() as f64 + 4.0
    }

    fn paint_axis(&self, canvas: &Canvas<'_>, axis: &LogAxis) -> Result<(), DrawError> {
        let (top, floor) = (self.top(), self.floor());
        for (x, text) in axis.ticks(8.0, 6.0) {
            canvas.line(&[(x, top - 4.0), (x, floor)], Tint::Grid, 1.0)?;
            let small = (Tint::Muted, 10.5);
            canvas.text((x, floor + 10.0), Anchor::Middle, small, &text)?;
            if self.is_long() {
                canvas.text((x, top - 12.0), Anchor::Middle, small, &text)?;
            }
        }
        if let Some(mark) = self.mark {
            let x = axis.at(mark);
            canvas.line(&[(x, top - 4.0), (x, floor)], Tint::Ink, 1.0)?;
        }
        let middle = 0.5 * (LABELS + RIGHT);
        canvas.text(
            (middle, floor + 27.0),
            Anchor::Middle,
            (Tint::Muted, 11.0),
            self.axis,
        )
    }

    fn paint_lines(&self, canvas: &Canvas<'_>, axis: &LogAxis) -> Result<(), DrawError> {
        let mut before: Option<&str> = None;
        for (i, line) in self.lines.iter().enumerate() {
            let top = self.top() + STEP * i as f64;
            if before.is_some_and(|group| group != line.group) {
                canvas.line(&[(4.0, top), (RIGHT, top)], Tint::Grid, 1.0)?;
            }
            before = Some(&line.group);
            let y = top + 0.5 * STEP;
            let label = number_format::shortened(&line.label, LABEL_LENGTH);
            canvas.text((LABELS - 8.0, y), Anchor::End, (Tint::Ink, 11.0), &label)?;
            // Ours comes first and is painted last, on top.
            let middle = 0.5 * (line.dots.len() as f64 - 1.0);
            for (k, dot) in line.dots.iter().enumerate().rev() {
                paint_dot(canvas, axis, y + DODGE * (k as f64 - middle), dot)?;
            }
        }
        Ok(())
    }
}

fn paint_dot(canvas: &Canvas<'_>, axis: &LogAxis, y: f64, dot: &Dot) -> Result<(), DrawError> {
    let tint = Tint::Series(dot.style);
    let (low, high) = (axis.at(dot.low), axis.at(dot.high));
    if dot.low.is_finite() && dot.high.is_finite() && high - low > 0.5 {
        let bar: [Point; 2] = [(low, y), (high, y)];
        canvas.line(&bar, tint, 1.25)?;
    }
    canvas.marker(
        (axis.at(dot.value), y),
        (tint, MarkerShape::of(dot.style)),
        3.2,
    )
}
