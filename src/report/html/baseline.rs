//! Changes from a baseline, in units of the oracle's rates.

use super::dots::{Dot, Line, dot_plot};
use super::number_format;
use super::tables::{cell, folded_table, table};
use super::view::{commit_text, day, threads_text};
use crate::baseline::BY_RAYS_HEAD;
use crate::{AUTO, BenchRecord, Changes, GroupChange, Grouping, RateChange};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// An earlier run, and the changes from it to the run of the page.
pub struct PageBaseline<'a> {
    /// The earlier run.
    pub record: &'a BenchRecord,
    /// The changes.
    pub changes: &'a Changes,
}

/// The section.
pub(super) fn section(baseline: &PageBaseline<'_>) -> Markup {
    let (record, changes) = (baseline.record, baseline.changes);
    html! {
        p {
            "Against the run of " (day(record)) " on " (record.machine.cpu) ", phalanx " (record.program.version)
            ", commit " code { (commit_text(&record.program)) } ". Rates are in units of the oracle's in the same scene and run, "
            "so that a slower day of the machine is no change. Intervals hold 95 %."
        }
        @if !changes.forced.is_empty() {
            p.note { "Compared nevertheless:" }
            ul.note { @for mismatch in &changes.forced { li { (mismatch) } } }
        }
        div.grid { @for threads in threads(changes) { (chart(changes, threads)) } }
        (group_table(changes))
        (row_table(changes))
    }
}

/// Thread counts of the changes, most first.
fn threads(changes: &Changes) -> Vec<u32> {
    let threads: BTreeSet<u32> = changes.rows.iter().map(|row| row.key.threads).collect();
    threads.into_iter().rev().collect()
}

/// Groups of one number of threads by kind of rays.
fn groups_of(changes: &Changes, on: u32) -> impl Iterator<Item = (&GroupChange, &str)> {
    changes
        .groups
        .iter()
        .filter_map(move |group| match &group.over {
            Grouping::Scenes { rays, threads } if *threads == on => Some((group, rays.as_str())),
            _ => None,
        })
}

fn chart(changes: &Changes, threads: u32) -> Markup {
    let ours = groups_of(changes, threads).filter(|(group, _)| group.kernel == AUTO);
    let line = |(group, rays): (&GroupChange, &str)| {
        let change = &group.change;
        Line {
            label: rays.to_owned(),
            group: String::new(),
            dots: vec![Dot {
                letter: String::new(),
                name: format!("{rays}: {}", change_words(change)),
                value: 1.0 + change.by,
                low: 1.0 + change.low,
                high: 1.0 + change.high,
                style: 0,
            }],
        }
    };
    let lines: Vec<Line> = ours.map(line).collect();
    if lines.is_empty() {
        return html! {};
    }
    let on = threads_text(threads);
    let label =
        format!("Change of auto by kind of rays on {on}; the table below holds the numbers.");
    html! {
        figure {
            figcaption { strong { "phalanx auto" } " against the baseline, " (on) }
            (dot_plot(&label, "times the baseline's rate", &lines, Some(1.0)))
        }
    }
}

fn change_words(change: &RateChange) -> String {
    let by = signed_percent(change.by);
    match change.is_known() {
        true => format!("{by} ({})", interval(change)),
        false => format!("{by} (too few samples for an interval)"),
    }
}

fn interval(change: &RateChange) -> String {
    match change.is_known() {
        true => format!(
            "{} to {}",
            signed_percent(change.low),
            signed_percent(change.high)
        ),
        false => number_format::NONE.to_owned(),
    }
}

/// A share as per cent with one decimal and its sign.
pub(super) fn signed_percent(share: f64) -> String {
    match share.is_finite() {
        true => crate::text::percent(share).replace(' ', "\u{202f}"),
        false => number_format::NONE.to_owned(),
    }
}

fn change_cells(change: &RateChange) -> [Markup; 2] {
    [cell(signed_percent(change.by)), cell(interval(change))]
}

fn group_table(changes: &Changes) -> Markup {
    let mut rows = Vec::new();
    for threads in threads(changes) {
        for (group, rays) in groups_of(changes, threads) {
            let mut cells = vec![cell(rays), cell(&group.kernel), cell(threads.to_string())];
            cells.push(cell(group.rows.to_string()));
            cells.extend(change_cells(&group.change));
            rows.push(cells);
        }
    }
    table(
        "Kernels by kind of rays, geometric means over scenes",
        &BY_RAYS_HEAD,
        2,
        rows,
    )
}

fn row_table(changes: &Changes) -> Markup {
    let mut sorted: Vec<_> = changes.rows.iter().collect();
    sorted.sort_by(|a, b| a.change.by.total_cmp(&b.change.by));
    let row = |row: &&crate::RowChange| {
        let key = &row.key;
        let mut cells = [&key.scene, &key.rays, &key.kernel].map(cell).to_vec();
        cells.push(cell(key.threads.to_string()));
        cells.extend([row.old, row.new].map(|rate| cell(number_format::measured(rate))));
        cells.extend(change_cells(&row.change));
        cells
    };
    let head = [
        "scene",
        "rays",
        "kernel",
        "threads",
        "then, Mrays/s",
        "now, Mrays/s",
        "change",
        "95 % interval",
    ];
    let rows = sorted.iter().map(row).collect();
    folded_table("Every rate, slower ones first", &head, 3, rows)
}
