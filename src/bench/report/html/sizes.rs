//! Rates against the size of a scene.

use super::axis::{LogAxis, paint_axes};
use super::dots::WIDTH;
use super::number_format;
use super::svg::{Anchor, Canvas, MarkerShape, Point, Tint, draw};
use super::view::{RecordView, kind_text, threads_text};
use maud::{Markup, html};
use std::collections::BTreeMap;

/// The section; a note where the record has no data for it.
pub(super) fn section(view: &RecordView<'_>) -> Markup {
    html! {
        section #sizes {
            h2 { "Scaling over scene size" }
            (over_size(view))
        }
    }
}

/// A family's rates by number of primitives.
struct FamilyCurve<'a> {
    family: &'a str,
    points: Vec<(f64, f64)>,
}

fn over_size(view: &RecordView<'_>) -> Markup {
    let threads = view.most_threads().unwrap_or(1);
    let charts = view.kinds.iter().filter_map(|kind| {
        let courses = family_curves(view, kind, threads);
        (!courses.is_empty()).then(|| size_chart(kind, &courses))
    });
    let charts: Vec<Markup> = charts.collect();
    if charts.is_empty() {
        return html! { p.note { "No family of scenes was measured in two sizes, so there is nothing to compare." } };
    }
    html! {
        p {
            "Rate of " code { "auto" } " on " (threads_text(threads)) " against the number of primitives, a "
            "line for each family of scenes; colours only tell neighbours apart."
        }
        div.grid { @for chart in charts { (chart) } }
    }
}

/// Families with two sizes at least, fastest at the largest size first.
fn family_curves<'a>(view: &RecordView<'a>, kind: &str, threads: u32) -> Vec<FamilyCurve<'a>> {
    let mut families: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for scene in &view.record.scenes {
        let Some(family) = &scene.family else {
            continue;
        };
        let Some(row) = view.auto(&scene.name, kind, threads) else {
            continue;
        };
        if scene.primitive_count > 0 {
            let point = (scene.primitive_count as f64, row.mrays_per_s.median);
            families.entry(family).or_default().push(point);
        }
    }
    let courses = families.into_iter().map(|(family, mut points)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by_key(|p| p.0);
        FamilyCurve { family, points }
    });
    let mut courses: Vec<_> = courses.filter(|c| c.points.len() > 1).collect();
    courses.sort_by(|a, b| b.end().1.total_cmp(&a.end().1));
    courses
}

impl FamilyCurve<'_> {
    fn end(&self) -> Point {
        self.points.last().copied().unwrap_or_default()
    }
}

fn size_chart(kind: &str, courses: &[FamilyCurve<'_>]) -> Markup {
    const LEFT: f64 = 38.0;
    const RIGHT: f64 = WIDTH - 92.0;
    // Every label needs its line of text.
    let floor = (14.0 * courses.len() as f64 + 20.0).max(200.0);
    let points = || courses.iter().flat_map(|c| &c.points);
    let x = LogAxis::over(points().map(|p| p.0), LEFT, RIGHT);
    let y = LogAxis::over(points().map(|p| p.1), floor, 12.0);
    let (Some(x), Some(y)) = (x, y) else {
        return html! {};
    };
    let label = format!(
        "{}: rate against number of primitives, a line for each family of scenes.",
        kind_text(kind)
    );
    let paint = |canvas: &Canvas<'_>| {
        paint_axes(canvas, (&x, &y), "primitives", floor)?;
        let places = courses.iter().map(|c| y.at(c.end().1)).collect();
        let places = apart(places, 13.0, (12.0, floor));
        for (i, course) in courses.iter().enumerate() {
            let tint = Tint::Series([0, 2, 3, 4][i % 4]);
            let line: Vec<Point> = course
                .points
                .iter()
                .map(|p| (x.at(p.0), y.at(p.1)))
                .collect();
            canvas.line(&line, tint, 1.25)?;
            for place in &line {
                canvas.marker(*place, (tint, MarkerShape::Disc), 2.4)?;
            }
            let end = line.last().copied().unwrap_or_default();
            let beside = (RIGHT + 12.0, places[i]);
            canvas.line(&[(end.0 + 3.0, end.1), beside], Tint::Grid, 1.0)?;
            let name = number_format::shortened(course.family, 13);
            canvas.text(
                (RIGHT + 15.0, places[i]),
                Anchor::Start,
                (tint, 11.0),
                &name,
            )?;
        }
        Ok(())
    };
    html! {
        figure {
            figcaption { strong { (kind) } ", Mrays/s" }
            (draw((WIDTH, floor + 40.0), &label, paint))
        }
    }
}

/// Heights for labels, moved as little as it takes to be `gap` apart and within `top` and `floor`.
/// In any order.
fn apart(wanted: Vec<f64>, gap: f64, (top, floor): (f64, f64)) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|a, b| wanted[*a].total_cmp(&wanted[*b]));
    let mut places = wanted;
    let mut free = top;
    for &i in &order {
        places[i] = places[i].max(free);
        free = places[i] + gap;
    }
    let mut free = floor;
    for &i in order.iter().rev() {
        places[i] = places[i].min(free);
        free = places[i] - gap;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stand_apart_in_their_order() {
        let places = apart(vec![50.0, 50.0, 12.0, 99.0], 10.0, (10.0, 100.0));
        assert_eq!(places, [50.0, 60.0, 12.0, 99.0]);
        let crowded = apart(vec![98.0, 97.0, 99.0], 10.0, (10.0, 100.0));
        assert_eq!(crowded, [90.0, 80.0, 100.0]);
    }
}
