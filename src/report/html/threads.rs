//! Rates against the number of threads.

use super::axis::Axis;
use super::dots::WIDTH;
use super::svg::{Tint, draw, figure, line, look, marker, named, text};
use super::view::{RecordView, threads_text};
use crate::numbers::{count, times};
use crate::report_table::ReportTable;
use crate::{AUTO, geometric_mean};
use maud::{Markup, html};

/// The speedup of a scene against the fewest threads.
struct Speedup<'a> {
    kind: &'a str,
    threads: u32,
    scene: &'a str,
    value: f64,
}

/// The section; a note where the record has no data for it.
pub(super) fn section(view: &RecordView<'_>) -> Markup {
    let Some((&base, more)) = view.threads.split_first() else {
        return html! { p.note { "The record has no rates." } };
    };
    let all = speedups(view, base, more);
    if all.is_empty() {
        let only = threads_text(base);
        return html! { p.note { "Rates were taken on " (only) " alone, so there is nothing to compare." } };
    }
    html! {
        p {
            "Speedup of " code { "auto" } " over " (threads_text(base)) ". Each small dot is a scene, the "
            "bar is the geometric mean; the rule is what as many times the threads could give at most."
        }
        div.grid {
            @for threads in more.iter().rev() { (strip(&all, base, *threads)) }
        }
        (speedup_table(&all, base).folded())
    }
}

/// All speedups, by kind and number of threads.
fn speedups<'a>(view: &RecordView<'a>, base: u32, more: &[u32]) -> Vec<Speedup<'a>> {
    let mut all = Vec::new();
    for &kind in &view.kinds {
        for &threads in more {
            all.extend(view.scenes.iter().filter_map(|&scene| {
                let rate = |threads| view.index.rate(AUTO, scene, kind, threads);
                let value = rate(threads)? / rate(base)?;
                Some(Speedup {
                    kind,
                    threads,
                    scene,
                    value,
                })
            }));
        }
    }
    all
}

const LEFT: f64 = 82.0;
const RIGHT: f64 = WIDTH - 14.0;
const TOP: f64 = 12.0;
const STEP: f64 = 24.0;

/// One line per kind, a dot per scene.
fn strip(all: &[Speedup<'_>], base: u32, threads: u32) -> Markup {
    let ideal = f64::from(threads) / f64::from(base.max(1));
    let kinds: Vec<_> = all.chunk_by(|a, b| a.kind == b.kind).collect();
    let is_on = |speedup: &&Speedup<'_>| speedup.threads == threads;
    let values = all.iter().filter(is_on).map(|speedup| speedup.value);
    let Some(axis) = Axis::linear(values.chain([1.0, ideal]), LEFT, RIGHT) else {
        return html! {};
    };
    let label = format!(
        "Speedup on {} against {}, by kind of rays; the table below holds the means.",
        threads_text(threads),
        threads_text(base)
    );
    let floor = TOP + STEP * kinds.len() as f64;
    let (top, ideal) = (TOP - 4.0, axis.position(ideal));
    let content = html! {
        (axis.paint(&axis.steps(), (top, floor), "times as fast"))
        (line(&[(ideal, top), (ideal, floor)], Tint::Ink, 1.0))
        @for (i, of_kind) in kinds.iter().enumerate() {
            @let y = TOP + STEP * (i as f64 + 0.5);
            (text((LEFT - 8.0, y), "end", (Tint::Ink, 11.0), of_kind[0].kind))
            (paint_strip(&axis, of_kind.iter().filter(is_on), y))
        }
    };
    let against = format!(" against {base}");
    let picture = draw((WIDTH, floor + 40.0), &label, content);
    figure(&threads_text(threads), &against, picture)
}

/// Scenes as dots in three tracks, so that few hide each other, and their geometric mean as a bar.
fn paint_strip<'s>(
    axis: &Axis,
    speedups: impl Iterator<Item = &'s Speedup<'s>> + Clone,
    y: f64,
) -> Markup {
    html! {
        @for (i, Speedup { scene, value, .. }) in speedups.clone().enumerate() {
            @let dot = marker((axis.position(*value), y + 4.0 * ((i % 3) as f64 - 1.0)), look(0), 2.0);
            (named(&format!("{scene}: {}", times(*value)), dot))
        }
        @if let Some(mean) = geometric_mean(speedups.map(|speedup| speedup.value)) {
            @let x = axis.position(mean);
            @let bar = line(&[(x, y - 9.0), (x, y + 9.0)], Tint::Ink, 2.5);
            (named(&format!("geometric mean: {}", times(mean)), bar))
        }
    }
}

fn speedup_table(all: &[Speedup<'_>], base: u32) -> ReportTable {
    let groups = all.chunk_by(|a, b| (a.kind, a.threads) == (b.kind, b.threads));
    let rows = groups.map(|group| {
        let values = || group.iter().map(|speedup| speedup.value);
        let mean = geometric_mean(values()).unwrap_or(f64::NAN);
        let least = values().fold(f64::INFINITY, f64::min);
        let most = values().fold(0.0, f64::max);
        let mut cells = vec![group[0].kind.to_owned(), group[0].threads.to_string()];
        cells.push(count(group.len() as u64));
        cells.extend([mean, least, most].map(times));
        cells
    });
    let head = "rays | threads | scenes | geometric mean | least | most";
    let title = format!("Speedup of auto over {}", threads_text(base));
    ReportTable::new(title, head, 1).with(rows)
}
