//! Drawing: plotters on a grid finer than pixels, in colours that the page's style sheet chooses.

use maud::{Markup, PreEscaped, html};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Plotter units per pixel of the page. Plotters positions everything on whole numbers.
const SCALE: f64 = 4.0;

/// Plotters' backend divides font sizes by this.
const FONT_FACTOR: f64 = 1.24;

/// Drawing error; it cannot occur, as only text is written.
pub(super) type DrawError = DrawingAreaErrorKind<std::io::Error>;

/// Colours by purpose. The style sheet has a custom property of each name, for light and dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tint {
    Ink,
    Muted,
    Grid,
    /// Colours of engines, steps and families, by index.
    Series(usize),
}

/// The custom properties, in the order of the sentinel colours that stand for them while plotters
/// draws.
const PROPERTIES: [&str; 8] = ["ink", "muted", "grid", "s0", "s1", "s2", "s3", "s4"];
const SERIES: usize = 5;

impl Tint {
    fn sentinel(self) -> RGBColor {
        let number = match self {
            Tint::Ink => 0,
            Tint::Muted => 1,
            Tint::Grid => 2,
            Tint::Series(number) => 3 + number % SERIES,
        };
        RGBColor(1, 2, number as u8)
    }
}

/// Shapes of markers. They carry the same information as colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MarkerShape {
    Disc,
    Cross,
    Square,
    Triangle,
    Diamond,
}

impl MarkerShape {
    /// The shape that goes with [`Tint::Series`] of the same number.
    pub(super) fn of(number: usize) -> MarkerShape {
        const SHAPES: [MarkerShape; SERIES] = [
            MarkerShape::Disc,
            MarkerShape::Cross,
            MarkerShape::Square,
            MarkerShape::Triangle,
            MarkerShape::Diamond,
        ];
        SHAPES[number % SERIES]
    }
}

/// Alignment of a text relative to its point.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A point in pixels from the upper left corner.
pub(super) type Point = (f64, f64);

/// A canvas to draw on, in pixels of the page.
pub(super) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

/// A chart of a size in pixels. `label` describes its content for screen readers.
pub(super) fn draw(
    size: Point,
    label: &str,
    paint: impl FnOnce(&Canvas<'_>) -> Result<(), DrawError>,
) -> Markup {
    let (width, height) = grid(size);
    let mut text = String::new();
    let backend = SVGBackend::with_string(&mut text, (width.max(1) as u32, height.max(1) as u32));
    let area = backend.into_drawing_area();
    let canvas = Canvas { area };
    let painted = paint(&canvas).and_then(|()| canvas.area.present());
    drop(canvas);
    if painted.is_err() {
        return html! { p.note { "This chart could not be drawn." } };
    }
    html! {
        svg viewBox={ "0 0 " (width) " " (height) } width=(size.0) height=(size.1) role="img" aria-label=(label) {
            (PreEscaped(themed(&text)))
        }
    }
}

/// The output of plotters in the page's colours, without its outermost tag, its constant attributes
/// and line breaks. Plotters escapes quotation marks in labels, so that no label can be taken for
/// an attribute.
fn themed(svg: &str) -> String {
    let (_, inner) = svg.split_once('>').unwrap_or_default();
    let inner = inner.trim_end().trim_end_matches("</svg>");
    let mut text = inner.replace('\n', "");
    for plain in [" opacity=\"1\"", " font-family=\"sans-serif\""] {
        text = text.replace(plain, "");
    }
    for (number, property) in PROPERTIES.iter().enumerate() {
        let sentinel = format!("\"#0102{number:02X}\"");
        text = text.replace(&sentinel, &format!("\"var(--{property})\""));
    }
    text
}

fn grid((x, y): Point) -> (i32, i32) {
    ((x * SCALE).round() as i32, (y * SCALE).round() as i32)
}

fn stroke(tint: Tint, width: f64) -> ShapeStyle {
    let width = (width * SCALE).round().max(1.0) as u32;
    tint.sentinel().stroke_width(width)
}

impl Canvas<'_> {
    pub(super) fn line(&self, points: &[Point], tint: Tint, width: f64) -> Result<(), DrawError> {
        let points: Vec<_> = points.iter().map(|&p| grid(p)).collect();
        self.area
            .draw(&PathElement::new(points, stroke(tint, width)))
    }

    /// A text of `size` pixels, its middle at the height of the point.
    pub(super) fn text(
        &self,
        at: Point,
        anchor: Anchor,
        (tint, size): (Tint, f64),
        text: &str,
    ) -> Result<(), DrawError> {
        let horizontal = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let font = ("sans-serif", size * SCALE * FONT_FACTOR).into_font();
        let style = font.color(&tint.sentinel());
        let style = style.pos(Pos::new(horizontal, VPos::Center));
        self.area.draw(&Text::new(text.to_owned(), grid(at), style))
    }

    /// A marker of about `radius` pixels.
    pub(super) fn marker(
        &self,
        (x, y): Point,
        (tint, shape): (Tint, MarkerShape),
        radius: f64,
    ) -> Result<(), DrawError> {
        let filled = tint.sentinel().filled();
        let polygon = |corners: &[Point]| {
            let at = |&(dx, dy): &Point| grid((x + dx * radius, y + dy * radius));
            let corners: Vec<_> = corners.iter().map(at).collect();
            self.area.draw(&Polygon::new(corners, filled))
        };
        match shape {
            MarkerShape::Disc => {
                let radius = (radius * SCALE).round() as i32;
                self.area.draw(&Circle::new(grid((x, y)), radius, filled))
            }
            MarkerShape::Cross => {
                let arm = (radius * 0.85 * SCALE).round() as i32;
                let style = stroke(tint, 1.5);
                self.area.draw(&Cross::new(grid((x, y)), arm, style))
            }
            MarkerShape::Square => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            MarkerShape::Triangle => polygon(&[(0.0, -1.15), (1.1, 0.85), (-1.1, 0.85)]),
            MarkerShape::Diamond => polygon(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
        }
    }
}

/// An entry of a legend: marker and meaning.
pub(super) fn key(style: (Tint, MarkerShape), meaning: &str) -> Markup {
    let picture = draw((14.0, 14.0), meaning, |canvas| {
        canvas.marker((7.0, 7.0), style, 4.5)
    });
    html! { li { (picture) " " (meaning) } }
}
