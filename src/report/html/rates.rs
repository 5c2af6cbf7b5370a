//! Rates by scene and kind of rays, with the peers next to them; then all of them again as tables.

use super::dots::{Dot, Line, dot_plot};
use super::number_format;
use super::svg::{MarkerShape, Tint, key};
use super::tables::{cell, folded, folded_table};
use super::view::{RecordView, kind_text, row_name, threads_text};
use crate::{AUTO, Estimate, PHALANX, RateRow, is_peer};
use maud::{Markup, html};
use std::collections::BTreeMap;

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
        (legend(view))
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
            @for threads in view.threads_from_most() {
                (table(view, kind, threads))
            }
        }
    }
}

/// Legend of colours and shapes.
pub(super) fn legend(view: &RecordView<'_>) -> Markup {
    html! {
        ul.legend {
            @for (i, engine) in view.index.engines.iter().enumerate() {
                @let meaning = match *engine {
                    PHALANX => "phalanx auto".to_owned(),
                    peer if is_peer(peer) => format!("{peer}, best exact mode"),
                    other => other.to_owned(),
                };
                (key((Tint::Series(i), MarkerShape::of(i)), &meaning))
            }
        }
    }
}

/// A chart for each kind with a line for each scene, or the other way round where there are few
/// scenes: few tall charts are read more easily than many flat ones.
fn charts(view: &RecordView<'_>, threads: u32) -> Markup {
    let by_scene = view.scenes.len() < view.kinds.len();
    let (charts, lines) = match by_scene {
        true => (&view.scenes, &view.kinds),
        false => (&view.kinds, &view.scenes),
    };
    html! {
        div.grid {
            @for outer in charts {
                @let lines = lines.iter().map(|inner| match by_scene {
                    true => line(view, outer, inner, threads, inner),
                    false => line(view, inner, outer, threads, &view.short_name(inner)),
                });
                (chart(outer, &lines.collect::<Vec<_>>(), threads))
            }
        }
    }
}

fn chart(name: &str, lines: &[Line], threads: u32) -> Markup {
    if lines.iter().all(|l| l.dots.is_empty()) {
        return html! {};
    }
    let label = format!(
        "Dot plot: {name} on {}, Mrays/s by engine; the tables below hold the numbers.",
        threads_text(threads)
    );
    html! {
        figure {
            figcaption { strong { (name) } ", " (threads_text(threads)) }
            (dot_plot(&label, "Mrays/s", lines, None))
        }
    }
}

fn line(view: &RecordView<'_>, scene: &str, kind: &str, threads: u32, label: &str) -> Line {
    let engines = view.index.engines.iter().enumerate();
    let dots = engines.filter_map(|(style, engine)| {
        let entrant = if *engine == PHALANX { AUTO } else { engine };
        let row = view.index.get(entrant, scene, kind, threads)?;
        let rate = row.mrays_per_s;
        Some(Dot {
            letter: String::new(),
            name: rate_name(&format!("{engine} {}, {label}", row.kernel), rate),
            value: rate.median,
            low: rate.low,
            high: rate.high,
            style,
        })
    });
    let family = view.scene(scene).and_then(|s| s.family.clone());
    Line {
        label: label.to_owned(),
        group: family.unwrap_or_default(),
        dots: dots.collect(),
    }
}

/// Name of a dot, with its rate and interval.
pub(super) fn rate_name(name: &str, rate: Estimate) -> String {
    let [median, low, high] = [rate.median, rate.low, rate.high].map(number_format::measured);
    format!("{name}: {median} Mrays/s ({low}–{high})")
}

/// One kind on the given number of threads: a row per scene, a column per engine and kernel.
fn table(view: &RecordView<'_>, kind: &str, threads: u32) -> Markup {
    let columns = columns(view, kind, threads);
    let mut by_scene: BTreeMap<&str, BTreeMap<(&str, &str), &RateRow>> = BTreeMap::new();
    let rows = view.record.rows.iter();
    for row in rows.filter(|row| row.rays == kind && row.threads == threads) {
        let of_scene = by_scene.entry(&row.scene).or_default();
        of_scene.insert((&row.engine, &row.kernel), row);
    }
    let rows =
        view.scenes.iter().filter_map(|scene| {
            let of_scene = by_scene.get(scene)?;
            let timed = of_scene.values().map(|row| row.rays_timed).max()?;
            let mut cells = vec![row_name(scene), cell(number_format::count(timed))];
            let rates = columns.iter().map(|column| of_scene.get(column));
            cells.extend(rates.map(|row| {
                row.map_or_else(|| cell(number_format::NONE), |row| rate_cell(row, timed))
            }));
            Some(cells)
        });
    let mut head = vec!["scene".to_owned(), "rays timed".to_owned()];
    head.extend(
        columns
            .iter()
            .map(|(engine, kernel)| format!("{engine} {kernel}")),
    );
    let caption = format!("{}, {}, Mrays/s", kind_text(kind), threads_text(threads));
    folded_table(&caption, &head, 1, rows.collect())
}

/// Engines in their order, `auto` first among the kernels of ours.
fn columns<'a>(view: &RecordView<'a>, kind: &str, threads: u32) -> Vec<(&'a str, &'a str)> {
    let rows = view.record.rows.iter();
    let rows = rows.filter(|r| r.rays == kind && r.threads == threads);
    let mut columns: Vec<_> = rows
        .map(|r| (r.engine.as_str(), r.kernel.as_str()))
        .collect();
    columns.sort_by_key(|&(engine, kernel)| {
        let rank = view.index.engines.iter().position(|e| *e == engine);
        (rank, kernel != "auto", kernel)
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
        (number_format::measured(rate.median))
        @if inexact { "†" }
        @if row.rays_timed < timed { small { "of " (number_format::short(row.rays_timed as f64)) " rays" } }
        @if let Some(other) = &row.same_as { small { "= " (other) } }
        small { (number_format::measured(rate.low)) "–" (number_format::measured(rate.high)) }
    }
}
