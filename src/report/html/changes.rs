//! Changes from a baseline, in units of the oracle's rates.

use super::dots::{Dot, Line, dot_figure};
use super::view::{commit_text, day, threads_text};
use crate::comparison::{BY_RAYS_HEAD, worst_first};
use crate::numbers::{self, THIN, known, measured};
use crate::report_table::ReportTable;
use crate::{AUTO, BenchRecord, Changes, GroupChange, Grouping, RateChange};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// The section: the earlier run, and the changes from it to the run of the page.
pub(super) fn section(record: &BenchRecord, changes: &Changes) -> Markup {
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
        (group_table(changes).page())
        (row_table(changes).folded())
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
        let values = [change.low, change.by, change.high].map(|by| 1.0 + by);
        let name = format!("{rays}: {}", change_words(change));
        Line::new(rays, [Dot::new(name, 0, values)])
    };
    let lines: Vec<Line> = ours.map(line).collect();
    let on = threads_text(threads);
    let label =
        format!("Change of auto by kind of rays on {on}; the table below holds the numbers.");
    let more = format!(" against the baseline, {on}");
    let axis = ("times the baseline's rate", Some(1.0));
    dot_figure(("phalanx auto", &more), &label, axis, &lines)
}

fn change_words(change: &RateChange) -> String {
    let by = signed_percent(change.by);
    if change.is_known() {
        format!("{by} ({})", interval(change))
    } else {
        format!("{by} (too few samples for an interval)")
    }
}

fn interval(change: &RateChange) -> String {
    let [low, high] = [change.low, change.high].map(signed_percent);
    known(change.high, || format!("{low} to {high}"))
}

/// A share as per cent with one decimal and its sign.
pub(super) fn signed_percent(share: f64) -> String {
    known(share, || {
        numbers::signed_percent(share).replace(' ', &THIN.to_string())
    })
}

fn group_table(changes: &Changes) -> ReportTable {
    let mut rows = Vec::new();
    for threads in threads(changes) {
        for (group, rays) in groups_of(changes, threads) {
            let mut cells = vec![rays.to_owned(), group.kernel.clone(), threads.to_string()];
            cells.push(group.rows.to_string());
            cells.extend([signed_percent(group.change.by), interval(&group.change)]);
            rows.push(cells);
        }
    }
    let title = "Kernels by kind of rays, geometric means over scenes";
    ReportTable::new(title, BY_RAYS_HEAD, 2).with(rows)
}

fn row_table(changes: &Changes) -> ReportTable {
    let sorted = worst_first(&changes.rows, |row| row.change.by).into_iter();
    let rows = sorted.map(|row| {
        let key = &row.key;
        let mut cells = vec![key.scene.clone(), key.rays.clone(), key.kernel.clone()];
        cells.push(key.threads.to_string());
        cells.extend([row.old, row.new].map(measured));
        cells.extend([signed_percent(row.change.by), interval(&row.change)]);
        cells
    });
    let head = "scene | rays | kernel | threads | then, Mrays/s | now, Mrays/s | change | \
                95 % interval";
    ReportTable::new("Every rate, slower ones first", head, 3).with(rows)
}
