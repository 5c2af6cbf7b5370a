//! Rates by scene and kind of rays, with the peers next to them; then all of them again as tables.

use super::dots::{Dot, Line, dot_figure};
use super::svg::{legend, look};
use super::tables::{cell, folded};
use super::view::{RecordView, kind_text, row_name, threads_text};
use crate::numbers::{self, NONE, measured};
use crate::report_table::ReportTable;
use crate::{AUTO, Estimate, PHALANX, RateRow, is_peer};
use maud::{Markup, html};

/// The section; a note where no row has a rate.
pub(super) fn section(view: &RecordView<'_>) -> Markup {
    let threads = view.threads.split_last();
    let any = view.record.rows.iter().any(RateRow::has_rate);
    let Some((&most, fewer)) = threads.filter(|_| any) else {
        return html! { p.note { "The record has no rates." } };
    };
    html! {
        p {
            "Millions of rays a second, with the interval in which another run would be 9 times in 10, on "
            (threads_text(most)) ". The axis is logarithmic: equal distances are equal factors. "
            "Ours is the kernel " code { "auto" } ", which is what " code { "render" } " would use"
            @if view.index.has_peers() { "; a peer is shown by its best exact mode for each scene" }
            "."
        }
        (engines(view))
        (charts(view, most))
        @for threads in fewer.iter().rev() {
            (folded(&format!("Charts on {}", threads_text(*threads)), charts(view, *threads)))
        }
        h3 { "All rates" }
        p.note {
            "Mrays/s, below them where another run would be 9 times in 10. "
            @if view.index.has_peers() { "† marks a mode that answers too many rays otherwise to count as exact." }
        }
        @for kind in &view.kinds {
            @for &threads in view.threads.iter().rev() {
                (table(view, kind, threads).folded())
            }
        }
    }
}

/// Legend of colours and shapes.
fn engines(view: &RecordView<'_>) -> Markup {
    let engines = view.index.engines.iter().enumerate();
    let keys = engines.map(|(i, engine)| {
        let meaning = match *engine {
            PHALANX => "phalanx auto".to_owned(),
            peer if is_peer(peer) => format!("{peer}, best exact mode"),
            other => other.to_owned(),
        };
        (look(i), meaning)
    });
    legend(keys, html! {})
}

/// A chart for each kind with a line for each scene, or the other way round where there are few
/// scenes: few tall charts are read more easily than many flat ones.
fn charts(view: &RecordView<'_>, threads: u32) -> Markup {
    let by_scene = view.scenes.len() < view.kinds.len();
    let (charts, lines) =
        if by_scene { (&view.scenes, &view.kinds) } else { (&view.kinds, &view.scenes) };
    html! {
        div.grid {
            @for outer in charts {
                @let lines = lines.iter().map(|inner| if by_scene {
                    line(view, outer, inner, threads, inner)
                } else {
                    line(view, inner, outer, threads, &view.short_name(inner))
                });
                (chart(outer, &lines.collect::<Vec<_>>(), threads))
            }
        }
    }
}

fn chart(name: &str, lines: &[Line], threads: u32) -> Markup {
    let on = threads_text(threads);
    let label =
        format!("Dot plot: {name} on {on}, Mrays/s by engine; the tables below hold the numbers.");
    dot_figure((name, &format!(", {on}")), &label, ("Mrays/s", None), lines)
}

fn line(view: &RecordView<'_>, scene: &str, kind: &str, threads: u32, label: &str) -> Line {
    let engines = view.index.engines.iter().enumerate();
    let dots = engines.filter_map(|(style, engine)| {
        let entrant = if *engine == PHALANX { AUTO } else { engine };
        let row = view.index.get(entrant, scene, kind, threads)?;
        let name = format!("{engine} {}, {label}", row.kernel);
        Some(rate_dot(&name, style, row.mrays_per_s))
    });
    let family = view.scene(scene).and_then(|s| s.family.clone());
    Line {
        group: family.unwrap_or_default(),
        ..Line::new(label, dots)
    }
}

/// A dot whose name has its rate and interval.
pub(super) fn rate_dot(name: &str, style: usize, rate: Estimate) -> Dot {
    let values = [rate.low, rate.median, rate.high];
    let [low, median, high] = values.map(measured);
    let name = format!("{name}: {median} Mrays/s ({low}–{high})");
    Dot::new(name, style, values)
}

/// One kind on the given number of threads: a row per scene, a column per engine and kernel.
fn table(view: &RecordView<'_>, kind: &str, threads: u32) -> ReportTable<Markup> {
    let columns = columns(view, kind, threads);
    let rows = view.scenes.iter().filter_map(|scene| {
        let row = |(engine, kernel)| {
            view.index
                .by_key
                .get(&(*scene, kind, engine, kernel, threads))
        };
        let rows = columns.iter().map(|&column| row(column).copied());
        let rows: Vec<Option<&RateRow>> = rows.collect();
        let timed = rows.iter().flatten().map(|row| row.rays_timed).max()?;
        let mut cells = vec![row_name(scene), cell(numbers::count(timed))];
        let rate = |row: &Option<&RateRow>| row.map_or(cell(NONE), |row| rate_cell(row, timed));
        cells.extend(rows.iter().map(rate));
        Some(cells)
    });
    let title = format!("{}, {}, Mrays/s", kind_text(kind), threads_text(threads));
    let mut table = ReportTable::new(title, "scene | rays timed", 1);
    let names = columns
        .iter()
        .map(|(engine, kernel)| format!("{engine} {kernel}"));
    table.head.extend(names);
    table.with(rows)
}

/// Engines in their order, `auto` first among the kernels of ours.
fn columns<'a>(view: &RecordView<'a>, kind: &str, threads: u32) -> Vec<(&'a str, &'a str)> {
    let rows = view.record.rows.iter();
    let rows = rows.filter(|r| r.rays == kind && r.threads == threads);
    let columns = rows.map(|r| (r.engine.as_str(), r.kernel.as_str()));
    let mut columns: Vec<_> = columns.collect();
    columns.sort_by_key(|&(engine, kernel)| {
        let rank = view.index.engines.iter().position(|e| *e == engine);
        (rank, kernel != AUTO, kernel)
    });
    columns.dedup();
    columns
}

/// A rate with its interval, and its differences from the other columns: another kernel's samples,
/// fewer rays.
fn rate_cell(row: &RateRow, timed: u64) -> Markup {
    let rate = row.mrays_per_s;
    let inexact = is_peer(&row.engine) && !row.exact;
    html! {
        (measured(rate.median))
        @if inexact { "†" }
        @if row.rays_timed < timed { small { "of " (numbers::short(row.rays_timed as f64)) " rays" } }
        @if let Some(other) = &row.same_as { small { "= " (other) } }
        small { (measured(rate.low)) "–" (measured(rate.high)) }
    }
}
