//! Rates against the number of threads.

use super::axis::{LinearAxis, paint_axis};
use super::dots::WIDTH;
use super::number_format;
use super::svg::{MarkerShape, Tint, draw, line, marker, named, text};
use super::tables::{cell, folded_table};
use super::view::{RecordView, threads_text};
use crate::geometric_mean;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// A scene and its speedup.
type SceneSpeedup<'a> = (&'a str, f64);

/// Speedups of one kind: of every scene at every thread count, against the fewest threads.
struct Speedups<'a> {
    kind: &'a str,
    /// Scenes and their speedups, by thread count.
    of: BTreeMap<u32, Vec<SceneSpeedup<'a>>>,
}

/// The section; a note where the record has no data for it.
pub(super) fn section(view: &RecordView<'_>) -> Markup {
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
        (speedup_table(&kinds, base, more))
    }
}

fn speedups<'a>(
    view: &RecordView<'a>,
    kind: &str,
    base: u32,
    more: &[u32],
) -> BTreeMap<u32, Vec<SceneSpeedup<'a>>> {
    let mut of: BTreeMap<u32, Vec<SceneSpeedup<'a>>> = BTreeMap::new();
    for &threads in more {
        for scene in &view.scenes {
            let rate = |threads| Some(view.auto(scene, kind, threads)?.mrays_per_s.median);
            if let (Some(one), Some(all)) = (rate(base), rate(threads)) {
                of.entry(threads).or_default().push((*scene, all / one));
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
    let all = all.map(|speedup| speedup.1);
    let Some(axis) = LinearAxis::over(all.chain(marks), LEFT, RIGHT) else {
        return html! {};
    };
    let label = format!(
        "Speedup on {} against {}, by kind of rays; the table below holds the means.",
        threads_text(threads),
        threads_text(base)
    );
    let floor = TOP + STEP * kinds.len() as f64;
    let (top, ideal) = (TOP - 4.0, axis.at(ideal));
    let content = html! {
        (paint_axis(&axis.ticks(), (top, floor), (0.5 * (LEFT + RIGHT), "times as fast")))
        (line(&[(ideal, top), (ideal, floor)], Tint::Ink, 1.0))
        @for (i, speedups) in kinds.iter().enumerate() {
            @let y = TOP + STEP * (i as f64 + 0.5);
            (text((LEFT - 8.0, y), "end", (Tint::Ink, 11.0), speedups.kind))
            (paint_strip(&axis, speedups.of.get(&threads).map_or(&[], Vec::as_slice), y))
        }
    };
    html! {
        figure {
            figcaption { strong { (threads_text(threads)) } " against " (base) }
            (draw((WIDTH, floor + 40.0), &label, content))
        }
    }
}

/// Scenes as dots in three tracks, so that few hide each other, and their geometric mean as a bar.
fn paint_strip(axis: &LinearAxis, speedups: &[SceneSpeedup<'_>], y: f64) -> Markup {
    let disc = (Tint::Series(0), MarkerShape::Disc);
    html! {
        @for (i, (scene, value)) in speedups.iter().enumerate() {
            @let dot = marker((axis.at(*value), y + 4.0 * ((i % 3) as f64 - 1.0)), disc, 2.0);
            (named(&format!("{scene}: {}", number_format::times(*value)), dot))
        }
        @if let Some(mean) = geometric_mean(speedups.iter().map(|speedup| speedup.1)) {
            @let x = axis.at(mean);
            @let bar = line(&[(x, y - 9.0), (x, y + 9.0)], Tint::Ink, 2.5);
            (named(&format!("geometric mean: {}", number_format::times(mean)), bar))
        }
    }
}

fn speedup_table(kinds: &[Speedups<'_>], base: u32, more: &[u32]) -> Markup {
    let mut rows = Vec::new();
    for speedups in kinds {
        for threads in more {
            let Some(values) = speedups.of.get(threads) else {
                continue;
            };
            let values: Vec<f64> = values.iter().map(|speedup| speedup.1).collect();
            let ends = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick);
            let times = |value: Option<f64>| cell(number_format::times(value.unwrap_or(f64::NAN)));
            rows.push(vec![
                cell(speedups.kind),
                cell(threads.to_string()),
                cell(number_format::count(values.len() as u64)),
                times(geometric_mean(values.iter().copied())),
                times(ends(f64::min)),
                times(ends(f64::max)),
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
    let caption = format!("Speedup of auto over {}", threads_text(base));
    folded_table(&caption, &head, 1, rows)
}
