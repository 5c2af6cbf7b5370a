//! How rates change with threads, and with the size of a scene.

use super::axis::LogAxis;
use super::dots::WIDTH;
use super::svg::{Anchor, Canvas, Failure, Point, Shape, Tint, draw};
use super::tables::{Table, cell};
use super::view::{View, geometric_mean, threads_text};
use super::words;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// Both sections; each says so in a line where the record has nothing for it.
pub(super) fn sections(view: &View<'_>) -> Markup {
    html! {
        section #threads {
            h2 { "Scaling over threads" }
            (over_threads(view))
        }
        section #sizes {
            h2 { "Scaling over scene size" }
            (over_size(view))
        }
    }
}

/// Speedups of one kind: of every scene at every thread count, against the fewest threads.
struct Speedups<'a> {
    kind: &'a str,
    /// By thread count.
    of: BTreeMap<u32, Vec<f64>>,
}

fn over_threads(view: &View<'_>) -> Markup {
    let Some((&base, more)) = view.threads.split_first() else {
        return html! { p.note { "The record has no rates." } };
    };
    let kinds = view.kinds.iter().map(|kind| Speedups {
        kind,
        of: speedups(view, kind, base, more),
    });
    let kinds: Vec<Speedups<'_>> = kinds.filter(|k| !k.of.is_empty()).collect();
    if kinds.is_empty() {
        let only = threads_text(base);
        return html! { p.note { "Rates were taken on " (only) " alone, so there is nothing to compare." } };
    }
    html! {
        p {
            "Speedup of " code { "auto" } " over " (threads_text(base)) ". Each small dot is a scene, the "
            "bar is the geometric mean; the rule is what as many times the threads could give at most."
        }
        div.grid {
            @for threads in more.iter().rev() { (strip(&kinds, base, *threads)) }
        }
        (speedup_table(&kinds, base, more).folded())
    }
}

fn speedups(view: &View<'_>, kind: &str, base: u32, more: &[u32]) -> BTreeMap<u32, Vec<f64>> {
    let mut of: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for &threads in more {
        for scene in &view.scenes {
            let rate = |threads| Some(view.auto(scene, kind, threads)?.mrays_per_s.median);
            if let (Some(one), Some(all)) = (rate(base), rate(threads)) {
                of.entry(threads).or_default().push(all / one);
            }
        }
    }
    of
}

/// One line per kind, a dot per scene, on a linear axis from 0.
fn strip(kinds: &[Speedups<'_>], base: u32, threads: u32) -> Markup {
    const LEFT: f64 = 82.0;
    const STEP: f64 = 24.0;
    let ideal = f64::from(threads) / f64::from(base.max(1));
    let all = kinds.iter().filter_map(|k| k.of.get(&threads)).flatten();
    let most = all.copied().filter(|v| v.is_finite()).fold(ideal, f64::max) * 1.06;
    let at = |value: f64| LEFT + (WIDTH - 14.0 - LEFT) * (value / most).clamp(0.0, 1.0);
    let floor = 12.0 + STEP * kinds.len() as f64;
    let label = format!(
        "Speedup on {} against {}, by kind of rays; the table below holds the means.",
        threads_text(threads),
        threads_text(base)
    );
    let paint = |canvas: &Canvas<'_>| {
        for value in linear_ticks(most) {
            let x = at(value);
            canvas.line(&[(x, 8.0), (x, floor)], Tint::Grid, 1.0)?;
            let text = words::short(value);
            canvas.text(
                (x, floor + 10.0),
                Anchor::Middle,
                (Tint::Muted, 10.5),
                &text,
            )?;
        }
        let x = at(ideal);
        canvas.line(&[(x, 8.0), (x, floor)], Tint::Ink, 1.0)?;
        for (i, speedups) in kinds.iter().enumerate() {
            let y = 12.0 + STEP * (i as f64 + 0.5);
            canvas.text(
                (LEFT - 8.0, y),
                Anchor::End,
                (Tint::Ink, 11.0),
                speedups.kind,
            )?;
            let values = speedups.of.get(&threads).map_or(&[][..], Vec::as_slice);
            paint_strip(canvas, values, y, at)?;
        }
        let middle = 0.5 * (LEFT + WIDTH - 14.0);
        let name = "times as fast";
        canvas.text(
            (middle, floor + 27.0),
            Anchor::Middle,
            (Tint::Muted, 11.0),
            name,
        )
    };
    html! {
        figure {
            figcaption { strong { (threads_text(threads)) } " against " (base) }
            (draw((WIDTH, floor + 40.0), &label, paint))
        }
    }
}

/// Scenes as dots in three tracks, so that few hide each other, and their geometric mean as a bar.
fn paint_strip(
    canvas: &Canvas<'_>,
    values: &[f64],
    y: f64,
    at: impl Fn(f64) -> f64,
) -> Result<(), Failure> {
    for (i, value) in values.iter().enumerate() {
        let place = (at(*value), y + 4.0 * ((i % 3) as f64 - 1.0));
        canvas.marker(place, (Tint::Series(0), Shape::Disc), 2.0)?;
    }
    if let Some((mean, _)) = geometric_mean(values.iter().copied()) {
        let x = at(mean);
        canvas.line(&[(x, y - 9.0), (x, y + 9.0)], Tint::Ink, 2.5)?;
    }
    Ok(())
}

/// About five round numbers from 0 on.
fn linear_ticks(most: f64) -> impl Iterator<Item = f64> {
    let steps = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
    let step = steps
        .into_iter()
        .find(|s| most / s <= 6.0)
        .unwrap_or(most / 4.0);
    (0..7)
        .map(move |i| step * f64::from(i))
        .take_while(move |v| *v <= most)
}

fn speedup_table(kinds: &[Speedups<'_>], base: u32, more: &[u32]) -> Table {
    let mut rows = Vec::new();
    for speedups in kinds {
        for threads in more {
            let Some(values) = speedups.of.get(threads) else {
                continue;
            };
            let ends = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick);
            let text = |value: Option<f64>| cell(words::times(value.unwrap_or(f64::NAN)));
            rows.push(vec![
                cell(speedups.kind),
                cell(threads.to_string()),
                cell(words::count(values.len() as u64)),
                text(geometric_mean(values.iter().copied()).map(|m| m.0)),
                text(ends(f64::min)),
                text(ends(f64::max)),
            ]);
        }
    }
    let head = [
        "rays",
        "threads",
        "scenes",
        "geometric mean",
        "least",
        "most",
    ];
    Table {
        caption: format!("Speedup of auto over {}", threads_text(base)),
        head: head.map(str::to_owned).to_vec(),
        texts: 1,
        rows,
    }
}

/// A family's rates by number of primitives.
struct Course<'a> {
    family: &'a str,
    points: Vec<(f64, f64)>,
}

fn over_size(view: &View<'_>) -> Markup {
    let threads = view.most_threads().unwrap_or(1);
    let charts = view.kinds.iter().filter_map(|kind| {
        let courses = courses(view, kind, threads);
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
fn courses<'a>(view: &View<'a>, kind: &str, threads: u32) -> Vec<Course<'a>> {
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
        Course { family, points }
    });
    let mut courses: Vec<_> = courses.filter(|c| c.points.len() > 1).collect();
    courses.sort_by(|a, b| b.end().1.total_cmp(&a.end().1));
    courses
}

impl Course<'_> {
    fn end(&self) -> Point {
        self.points.last().copied().unwrap_or_default()
    }
}

fn size_chart(kind: &str, courses: &[Course<'_>]) -> Markup {
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
        "{kind} rays: rate against number of primitives, a line for each family of scenes."
    );
    let paint = |canvas: &Canvas<'_>| {
        paint_frame(canvas, (&x, &y), "primitives", floor)?;
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
                canvas.marker(*place, (tint, Shape::Disc), 2.4)?;
            }
            let end = line.last().copied().unwrap_or_default();
            let beside = (RIGHT + 12.0, places[i]);
            canvas.line(&[(end.0 + 3.0, end.1), beside], Tint::Grid, 1.0)?;
            let name = words::shortened(course.family, 13);
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

/// Grid and labels of two logarithmic axes.
pub(super) fn paint_frame(
    canvas: &Canvas<'_>,
    (x, y): (&LogAxis, &LogAxis),
    below: &str,
    floor: f64,
) -> Result<(), Failure> {
    let (left, right) = (x.at(x.ends().0), x.at(x.ends().1));
    let top = y.at(y.ends().1);
    let small = (Tint::Muted, 10.5);
    for (place, text) in x.ticks(30.0) {
        canvas.line(&[(place, top), (place, floor)], Tint::Grid, 1.0)?;
        canvas.text((place, floor + 10.0), Anchor::Middle, small, &text)?;
    }
    for (place, text) in y.ticks(18.0) {
        canvas.line(&[(left, place), (right, place)], Tint::Grid, 1.0)?;
        canvas.text((left - 5.0, place), Anchor::End, small, &text)?;
    }
    let middle = (0.5 * (left + right), floor + 27.0);
    canvas.text(middle, Anchor::Middle, (Tint::Muted, 11.0), below)
}

/// Heights for labels, moved as little as it takes to be `gap` apart and within `top` and `floor`. In any order.
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

    #[test]
    fn linear_axes_have_few_round_numbers() {
        assert_eq!(
            linear_ticks(2.1).collect::<Vec<_>>(),
            [0.0, 0.5, 1.0, 1.5, 2.0]
        );
        assert!(linear_ticks(1000.0).count() <= 7);
    }
}
