//! Rates against the size of a scene.

use super::axis::{Axis, paint_axes};
use super::dots::WIDTH;
use super::svg::{MarkerShape, Point, Tint, draw, figure, line, marker, named, text};
use super::view::{RecordView, kind_text, threads_text};
use crate::numbers::{measured, short};
use crate::text::shortened;
use crate::{AUTO, SceneRecord};
use maud::{Markup, html};
use std::collections::BTreeMap;

/// A scene of a family and its rate.
type SizePoint<'a> = (&'a SceneRecord, f64);

/// The section; a note where the record has no data for it.
pub(super) fn section(view: &RecordView<'_>) -> Markup {
    let threads = view.threads.last().copied().unwrap_or(1);
    let charts = view.kinds.iter().filter_map(|kind| {
        let curves = family_curves(view, kind, threads);
        (!curves.is_empty()).then(|| size_chart(kind, &curves))
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

/// The scenes of each family with two sizes at least, smallest first; fastest at the largest size
/// first.
fn family_curves<'a>(view: &RecordView<'a>, kind: &str, threads: u32) -> Vec<Vec<SizePoint<'a>>> {
    let mut families: BTreeMap<&str, Vec<SizePoint<'a>>> = BTreeMap::new();
    for scene in view.record.scenes.iter().filter(|s| s.primitive_count > 0) {
        let rate = view.index.rate(AUTO, &scene.name, kind, threads);
        if let (Some(family), Some(rate)) = (&scene.family, rate) {
            families.entry(family).or_default().push((scene, rate));
        }
    }
    let mut curves: Vec<Vec<SizePoint<'a>>> = families.into_values().collect();
    for points in &mut curves {
        points.sort_by_key(|point| point.0.primitive_count);
        points.dedup_by_key(|point| point.0.primitive_count);
    }
    curves.retain(|points| points.len() > 1);
    curves.sort_by(|a, b| end_rate(b).total_cmp(&end_rate(a)));
    curves
}

fn point_name((scene, rate): SizePoint<'_>) -> String {
    let (primitives, rate) = (short(scene.primitive_count as f64), measured(rate));
    format!("{}, {primitives} primitives: {rate} Mrays/s", scene.name)
}

fn family<'a>(curve: &[SizePoint<'a>]) -> &'a str {
    let family = curve.first().and_then(|point| point.0.family.as_deref());
    family.unwrap_or_default()
}

/// Rate of the largest scene.
fn end_rate(curve: &[SizePoint<'_>]) -> f64 {
    curve.last().map_or(0.0, |point| point.1)
}

fn size_chart(kind: &str, curves: &[Vec<SizePoint<'_>>]) -> Markup {
    const LEFT: f64 = 38.0;
    const RIGHT: f64 = WIDTH - 92.0;
    // Every label needs its line of text.
    let floor = (14.0 * curves.len() as f64 + 20.0).max(200.0);
    let points = || curves.iter().flatten();
    let x = Axis::log(points().map(|p| p.0.primitive_count as f64), LEFT, RIGHT);
    let y = Axis::log(points().map(|p| p.1), floor, 12.0);
    let (Some(x), Some(y)) = (x, y) else {
        return html! {};
    };
    let label = format!(
        "{}: rate against number of primitives, a line for each family of scenes.",
        kind_text(kind)
    );
    let heights = curves.iter().map(|c| y.position(end_rate(c))).collect();
    let heights = apart(heights, 13.0, (12.0, floor));
    let content = html! {
        (paint_axes((&x, &y), "primitives", floor))
        @for (i, (curve, &height)) in curves.iter().zip(&heights).enumerate() {
            @let tint = Tint::Series([0, 2, 3, 4][i % 4]);
            @let points: Vec<Point> = curve.iter().map(|p| (x.position(p.0.primitive_count as f64), y.position(p.1))).collect();
            @let end = points.last().copied().unwrap_or_default();
            (line(&points, tint, 1.25))
            @for (point, scene) in points.iter().zip(curve) {
                (named(&point_name(*scene), marker(*point, (tint, MarkerShape::Disc), 2.8)))
            }
            (line(&[(end.0 + 3.0, end.1), (RIGHT + 12.0, height)], Tint::Grid, 1.0))
            (text((RIGHT + 15.0, height), "start", (tint, 11.0), &shortened(family(curve), 13)))
        }
    };
    figure(
        kind,
        ", Mrays/s",
        draw((WIDTH, floor + 40.0), &label, content),
    )
}

/// Heights for labels, moved as little as it takes to be `gap` apart and within `top` and `floor`.
/// In any order.
fn apart(ideal: Vec<f64>, gap: f64, (top, floor): (f64, f64)) -> Vec<f64> {
    let mut order: Vec<usize> = (0..ideal.len()).collect();
    order.sort_by(|a, b| ideal[*a].total_cmp(&ideal[*b]));
    let mut heights = ideal;
    let mut free = top;
    for &i in &order {
        heights[i] = heights[i].max(free);
        free = heights[i] + gap;
    }
    let mut free = floor;
    for &i in order.iter().rev() {
        heights[i] = heights[i].min(free);
        free = heights[i] - gap;
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stand_apart_in_their_order() {
        let heights = apart(vec![50.0, 50.0, 12.0, 99.0], 10.0, (10.0, 100.0));
        assert_eq!(heights, [50.0, 60.0, 12.0, 99.0]);
        let crowded = apart(vec![98.0, 97.0, 99.0], 10.0, (10.0, 100.0));
        assert_eq!(crowded, [90.0, 80.0, 100.0]);
    }
}
