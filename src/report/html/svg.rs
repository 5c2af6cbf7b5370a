//! Charts as SVG, in colours that the page's style sheet chooses.

use maud::{Markup, html};

/// Colours by purpose. The style sheet has a custom property for each, for light and dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tint {
    Ink,
    Muted,
    Grid,
    /// Colours of engines, steps and families, by index.
    Series(usize),
}

/// Number of colours of [`Tint::Series`].
const SERIES: usize = 5;

impl Tint {
    fn property(self) -> String {
        match self {
            Tint::Ink => "var(--ink)".to_owned(),
            Tint::Muted => "var(--muted)".to_owned(),
            Tint::Grid => "var(--grid)".to_owned(),
            Tint::Series(number) => format!("var(--s{})", number % SERIES),
        }
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

/// Colour and shape of markers.
pub(super) type MarkerStyle = (Tint, MarkerShape);

/// The look of engines and records by index.
pub(super) fn look(number: usize) -> MarkerStyle {
    use MarkerShape::*;
    let shapes = [Disc, Cross, Square, Triangle, Diamond];
    (Tint::Series(number), shapes[number % shapes.len()])
}

/// A point in pixels from the upper left corner.
pub(super) type Point = (f64, f64);

/// A chart of a size in pixels. `label` describes its content for screen readers.
pub(super) fn draw((width, height): Point, label: &str, content: Markup) -> Markup {
    html! {
        svg viewBox={ "0 0 " (width) " " (height) } width=(width) height=(height) role="img" aria-label=(label) {
            (content)
        }
    }
}

/// A position to a quarter of a pixel, which is short to write and fine enough for eyes.
fn rounded(position: f64) -> f64 {
    (position * 4.0).round() / 4.0
}

fn point_list(points: &[Point]) -> String {
    let point = |&(x, y): &Point| format!("{},{}", rounded(x), rounded(y));
    points.iter().map(point).collect::<Vec<_>>().join(" ")
}

/// A line through some points.
pub(super) fn line(points: &[Point], tint: Tint, width: f64) -> Markup {
    html! { polyline points=(point_list(points)) fill="none" stroke=(tint.property()) stroke-width=(width) {} }
}

/// A text of `size` pixels, its middle at the height of the point; `anchor` is the end of the text
/// that is there: `start`, `middle` or `end`.
pub(super) fn text((x, y): Point, anchor: &str, (tint, size): (Tint, f64), text: &str) -> Markup {
    html! {
        text x=(rounded(x)) y=(rounded(y)) dy="0.5ex" text-anchor=(anchor) font-size=(size) fill=(tint.property()) {
            (text)
        }
    }
}

/// A marker of about `radius` pixels.
pub(super) fn marker((x, y): Point, (tint, shape): MarkerStyle, radius: f64) -> Markup {
    let around = |corners: &[Point]| -> Vec<Point> {
        let corner = |&(dx, dy): &Point| (x + dx * radius, y + dy * radius);
        corners.iter().map(corner).collect()
    };
    let polygon = |corners: &[Point]| {
        html! { polygon points=(point_list(&around(corners))) fill=(tint.property()) {} }
    };
    match shape {
        MarkerShape::Disc => html! {
            circle cx=(rounded(x)) cy=(rounded(y)) r=(rounded(radius)) fill=(tint.property()) {}
        },
        MarkerShape::Cross => html! {
            (line(&around(&[(-0.85, -0.85), (0.85, 0.85)]), tint, 1.5))
            (line(&around(&[(-0.85, 0.85), (0.85, -0.85)]), tint, 1.5))
            // The pointer would have to be on a line otherwise.
            circle cx=(rounded(x)) cy=(rounded(y)) r=(rounded(radius)) fill="none" pointer-events="all" {}
        },
        MarkerShape::Square => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
        MarkerShape::Triangle => polygon(&[(0.0, -1.15), (1.1, 0.85), (-1.1, 0.85)]),
        MarkerShape::Diamond => polygon(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
    }
}

/// Part of a chart that shows its name when the pointer is over it.
pub(super) fn named(name: &str, content: Markup) -> Markup {
    html! { g { title { (name) } (content) } }
}

/// A picture below its title.
pub(super) fn figure(title: &str, more: &str, picture: Markup) -> Markup {
    html! { figure { figcaption { strong { (title) } (more) } (picture) } }
}

/// Markers with their meanings, then more list items.
pub(super) fn legend(
    keys: impl IntoIterator<Item = (MarkerStyle, String)>,
    more: Markup,
) -> Markup {
    html! {
        ul.legend {
            @for (look, meaning) in keys {
                @let picture = draw((14.0, 14.0), &meaning, marker((7.0, 7.0), look, 4.5));
                li { (picture) " " (meaning) }
            }
            (more)
        }
    }
}
