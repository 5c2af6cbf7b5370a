//! Rates against the number of threads.

use super::axis::LinearAxis;
use super::dots::WIDTH;
use super::number_format;
use super::svg::{Anchor, Canvas, DrawError, MarkerShape, Tint, draw};
use super::tables::{HtmlTable, cell};
use super::view::{RecordView, geometric_mean, threads_text};
use maud::{Markup, html};
use std::collections::BTreeMap;

/// The section; a note where the record has no data for it.
pub(super) fn section(view: &RecordView<'_>) -> Markup {
    html! {
        section #threads {
            h2 { "Scaling over threads" }
            (over_threads(view))
        }
    }
}

/// Speedups of one kind: of every scene at every thread count, against the fewest threads.
struct Speedups<'a> {
    kind: &'a str,
    /// Speedups of all scenes, by thread count.
    of: BTreeMap<u32, Vec<f64>>,
}

fn over_threads(view: &RecordView<'_>) -> Markup {
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

fn speedups(view: &RecordView<'_>, kind: &str, base: u32, more: &[u32]) -> BTreeMap<u32, Vec<f64>> {
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

const LEFT: f64 = 82.0;
const RIGHT: f64 = WIDTH - 14.0;
const TOP: f64 = 12.0;
const STEP: f64 = 24.0;

/// One line per kind, a dot per scene.
fn strip(kinds: &[Speedups<'_>], base: u32, threads: u32) -> Markup {
    let ideal = f64::from(threads) / f64::from(base.max(1));
    let all = kinds.iter().filter_map(|k| k.of.get(&threads)).flatten();
    let marks = [1.0, ideal];
    let Some(axis) = LinearAxis::over(all.copied().chain(marks), LEFT, RIGHT) else {
        return html! {};
    };
    let label = format!(
        "Speedup on {} against {}, by kind of rays; the table below holds the means.",
        threads_text(threads),
        threads_text(base)
    );
    let floor = TOP + STEP * kinds.len() as f64;
    let paint = |canvas: &Canvas<'_>| {
        paint_scale(canvas, &axis, ideal, floor)?;
        for (i, speedups) in kinds.iter().enumerate() {
            let y = TOP + STEP * (i as f64 + 0.5);
            let name = (LEFT - 8.0, y);
            canvas.text(name, Anchor::End, (Tint::Ink, 11.0), speedups.kind)?;
            let values = speedups.of.get(&threads).map_or(&[][..], Vec::as_slice);
            paint_strip(canvas, &axis, values, y)?;
        }
        Ok(())
    };
    html! {
        figure {
            figcaption { strong { (threads_text(threads)) } " against " (base) }
            (draw((WIDTH, floor + 40.0), &label, paint))
        }
    }
}

/// The lower axis, and a rule at the ideal speedup.
fn paint_scale(
    canvas: &Canvas<'_>,
    axis: &LinearAxis,
    ideal: f64,
    floor: f64,
) -> Result<(), DrawError> {
    for (x, text) in axis.ticks() {
        canvas.line(&[(x, TOP - 4.0), (x, floor)], Tint::Grid, 1.0)?;
        let below = (x, floor + 10.0);
        canvas.text(below, Anchor::Middle, (Tint::Muted, 10.5), &text)?;
    }
    let x = axis.at(ideal);
    canvas.line(&[(x, TOP - 4.0), (x, floor)], Tint::Ink, 1.0)?;
    let middle = (0.5 * (LEFT + RIGHT), floor + 27.0);
    canvas.text(middle, Anchor::Middle, (Tint::Muted, 11.0), "times as fast")
}

/// Scenes as dots in three tracks, so that few hide each other, and their geometric mean as a bar.
fn paint_strip(
    canvas: &Canvas<'_>,
    axis: &LinearAxis,
    values: &[f64],
    y: f64,
) -> Result<(), DrawError> {
    for (i, value) in values.iter().enumerate() {
        let place = (axis.at(*value), y + 4.0 * ((i % 3) as f64 - 1.0));
        canvas.marker(place, (Tint::Series(0), MarkerShape::Disc), 2.0)?;
    }
    if let Some((mean, _)) = geometric_mean(values.iter().copied()) {
        let x = axis.at(mean);
        canvas.line(&[(x, y - 9.0), (x, y + 9.0)], Tint::Ink, 2.5)?;
    }
    Ok(())
}

fn speedup_table(kinds: &[Speedups<'_>], base: u32, more: &[u32]) -> HtmlTable {
    let mut rows = Vec::new();
    for speedups in kinds {
        for threads in more {
            let Some(values) = speedups.of.get(threads) else {
                continue;
            };
            let ends = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick);
            let text = |value: Option<f64>| cell(number_format::times(value.unwrap_or(f64::NAN)));
            rows.push(vec![
                cell(speedups.kind),
                cell(threads.to_string()),
                cell(number_format::count(values.len() as u64)),
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
    HtmlTable {
        caption: format!("Speedup of auto over {}", threads_text(base)),
        head: head.map(str::to_owned).to_vec(),
        texts: 1,
        rows,
    }
}
