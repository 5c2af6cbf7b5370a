//! Rates against the number of threads.

use super::axis::Axis;
use super::dots::WIDTH;
use super::svg::{Tint, draw, figure, line, look, marker, named, text};
use super::view::{RecordView, threads_text};
use crate::geometric_mean;
use crate::numbers::{count, times};
use crate::report_table::ReportTable;
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
        (speedup_table(&kinds, base).folded())
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
    let Some(axis) = Axis::linear(all.chain(marks), LEFT, RIGHT) else {
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
        (axis.paint(&axis.steps(), (top, floor), "times as fast"))
        (line(&[(ideal, top), (ideal, floor)], Tint::Ink, 1.0))
        @for (i, speedups) in kinds.iter().enumerate() {
            @let y = TOP + STEP * (i as f64 + 0.5);
            (text((LEFT - 8.0, y), "end", (Tint::Ink, 11.0), speedups.kind))
            (paint_strip(&axis, speedups.of.get(&threads).map_or(&[], Vec::as_slice), y))
        }
    };
    let against = format!(" against {base}");
    let picture = draw((WIDTH, floor + 40.0), &label, content);
    figure(&threads_text(threads), &against, picture)
}

/// Scenes as dots in three tracks, so that few hide each other, and their geometric mean as a bar.
fn paint_strip(axis: &Axis, speedups: &[SceneSpeedup<'_>], y: f64) -> Markup {
    html! {
        @for (i, (scene, value)) in speedups.iter().enumerate() {
            @let dot = marker((axis.at(*value), y + 4.0 * ((i % 3) as f64 - 1.0)), look(0), 2.0);
            (named(&format!("{scene}: {}", times(*value)), dot))
        }
        @if let Some(mean) = geometric_mean(speedups.iter().map(|speedup| speedup.1)) {
            @let x = axis.at(mean);
            @let bar = line(&[(x, y - 9.0), (x, y + 9.0)], Tint::Ink, 2.5);
            (named(&format!("geometric mean: {}", times(mean)), bar))
        }
    }
}

fn speedup_table(kinds: &[Speedups<'_>], base: u32) -> ReportTable {
    let row = |kind: &str, threads: u32, speedups: &[SceneSpeedup<'_>]| {
        let values = || speedups.iter().map(|speedup| speedup.1);
        let ends = [values().reduce(f64::min), values().reduce(f64::max)];
        let mut cells = vec![kind.to_owned(), threads.to_string()];
        cells.push(count(speedups.len() as u64));
        let numbers = [geometric_mean(values())].into_iter().chain(ends);
        cells.extend(numbers.map(|value| times(value.unwrap_or(f64::NAN))));
        cells
    };
    let rows = kinds.iter().flat_map(|kind| {
        let of = kind.of.iter();
        of.map(|(threads, speedups)| row(kind.kind, *threads, speedups))
    });
    let head = "rays | threads | scenes | geometric mean | least | most";
    let title = format!("Speedup of auto over {}", threads_text(base));
    ReportTable::new(title, head, 1).with(rows)
}
