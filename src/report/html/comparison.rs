//! Several records as a page: the machines, means, the ratios to other tracers, scenes, and the
//! differences from the first record.

use super::dots::{Dot, Line, dot_figure};
use super::rates::rate_dot;
use super::summary::cache_text;
use super::svg::{legend, look};
use super::tables::cell;
use super::view::{day, kind_text, threads_text};
use crate::comparison::{changes, comparison_tables};
use crate::numbers::{self, NONE, THIN, known, measured, percent, times};
use crate::report_table::ReportTable;
use crate::text::commit;
use crate::{
    AUTO, BenchRecord, MeanRates, RecordComparison, RecordIndex, kinds_frame_first, quotable_line,
};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// The records of a page.
pub(super) struct ComparedRecords<'a> {
    comparison: &'a RecordComparison,
    records: &'a [(&'a str, &'a BenchRecord)],
    best: Vec<RecordIndex<'a>>,
    /// Largest number of threads that all records were measured on.
    threads: Option<u32>,
}

impl<'a> ComparedRecords<'a> {
    pub(super) fn new(
        records: &'a [(&'a str, &'a BenchRecord)],
        comparison: &'a RecordComparison,
    ) -> ComparedRecords<'a> {
        let index = |(_, r): &(_, &'a BenchRecord)| RecordIndex::new(&r.scenes, &r.rows);
        ComparedRecords {
            comparison,
            records,
            best: records.iter().map(index).collect(),
            threads: comparison.means.iter().map(|mean| mean.threads).max(),
        }
    }

    /// Record by its index: letter, and what tells it from the others.
    fn name(&self, record: usize) -> String {
        let label = &self.comparison.records[record].label;
        let record = self.records[record].1;
        format!("{label}: {}, {}", record.machine.cpu, day(record))
    }

    fn legend(&self) -> Markup {
        let keys = (0..self.records.len()).map(|record| (look(record), self.name(record)));
        legend(keys, html! {})
    }

    /// A dot for each record that has a value; `dot` makes it of its number.
    fn dots(&self, dot: impl Fn(usize) -> Option<Dot>) -> Vec<Dot> {
        let labels = self.comparison.records.iter().map(|record| &record.label);
        let dot = |(record, label): (usize, &String)| Some(dot(record)?.lettered(label));
        labels.enumerate().filter_map(dot).collect()
    }

    /// Tables of the comparison whose titles begin so.
    fn tables(&self, start: &str) -> Markup {
        let tables = comparison_tables(self.comparison);
        let chosen = tables.iter().filter(|table| table.title.starts_with(start));
        html! { @for table in chosen { (table.page()) } }
    }
}

/// A dot for a record's value without an interval.
fn exact(name: String, record: usize, value: f64) -> Dot {
    Dot::new(name, record, [f64::NAN, value, f64::NAN])
}

fn figure(title: &str, more: &str, axis: (&str, Option<f64>), lines: &[Line]) -> Markup {
    let label = format!("{title}{more}, a dot for each record; the tables hold the numbers.");
    dot_figure((title, more), &label, axis, lines)
}

/// The line to quote of each record, and ranks.
pub(super) fn headline(compared: &ComparedRecords<'_>) -> Markup {
    html! {
        @for (i, (_, record)) in compared.records.iter().enumerate() {
            @if let Some(line) = quotable_line(record) { p { strong { (compared.name(i)) } ", " (line) } }
        }
        (compared.tables("ranks"))
    }
}

/// The table of machines, a row for each record.
pub(super) fn machines(compared: &ComparedRecords<'_>) -> Markup {
    let or_none = |text: Option<String>| cell(text.unwrap_or(NONE.to_owned()));
    let row = |(i, (name, record)): (usize, &(&str, &BenchRecord))| {
        let (machine, program) = (&record.machine, &record.program);
        let commit = commit(program).unwrap_or("not known".to_owned());
        vec![
            cell(&compared.comparison.records[i].label),
            cell(&machine.cpu),
            cell(machine.hypervisor_words().unwrap_or(NONE)),
            cell(&program.isa_compiled),
            html! { (program.version) " " code { (commit) } },
            cell(&record.run.quality),
            cell(record.run.peers.join(", ")),
            cell(day(record)),
            cell(name),
            or_none(machine.cores.map(|cores| cores.to_string())),
            cell(machine.threads.to_string()),
            cell(cache_text(machine).join(", ")),
            or_none(machine.memory_bytes.map(numbers::binary_bytes)),
        ]
    };
    let head = "record | CPU | hypervisor | built for | phalanx | trees | peers | day | file | \
                cores | hardware threads | caches | memory";
    let table = ReportTable::new("Machines and programs", head, 9);
    html! {
        (table.with(compared.records.iter().enumerate().map(row)).page())
        @for record in &compared.comparison.records {
            @for remark in &record.remarks { p.note { (record.label) ": " (remark) } }
        }
    }
}

/// A chart of our means by kind of rays: a dot for each record that has a value, which comes with
/// its words. Its title is followed by more.
fn means_chart(
    compared: &ComparedRecords<'_>,
    threads: u32,
    (more, axis): (&str, (&str, Option<f64>)),
    value: impl Fn(&MeanRates, usize) -> Option<(f64, String)>,
) -> Markup {
    let means = compared.comparison.means.iter();
    let lines = means.filter(|mean| mean.threads == threads).map(|mean| {
        let dots = compared.dots(|record| {
            let (value, words) = value(mean, record)?;
            Some(exact(format!("{}, {words}", mean.rays), record, value))
        });
        Line::new(&mean.rays, dots)
    });
    figure("phalanx auto", more, axis, &lines.collect::<Vec<_>>())
}

/// Geometric means by kind of rays.
pub(super) fn rates(compared: &ComparedRecords<'_>) -> Markup {
    let threads = compared.comparison.means.iter().map(|mean| mean.threads);
    let threads: BTreeSet<u32> = threads.collect();
    let chart = |threads: u32| {
        let on = format!(", {}", threads_text(threads));
        let value = |mean: &MeanRates, record: usize| {
            let rate = *mean.mrays_per_s.get(record)?;
            Some((rate, format!("{} Mrays/s", measured(rate))))
        };
        means_chart(compared, threads, (&on, ("Mrays/s", None)), value)
    };
    html! {
        @if threads.is_empty() { p.note { "The records have no rates in common." } }
        (compared.legend())
        div.grid { @for threads in threads.iter().rev() { (chart(*threads)) } }
        (compared.tables("phalanx, Mrays/s"))
    }
}

/// Ratios to other tracers by kind of rays.
pub(super) fn ratios(compared: &ComparedRecords<'_>) -> Markup {
    let engines = compared.comparison.ratios.iter().map(|r| &*r.engine);
    let engines: BTreeSet<&str> = engines.collect();
    let dot = |engine: &str, kind: &str, record: usize| {
        let threads = compared.best[record].threads.last().copied()?;
        let ratio = compared.best[record].over(engine, kind, threads)?.mean;
        let (times, on) = (times(ratio), threads_text(threads));
        Some(exact(
            format!("{kind}, {times} as fast, {on}"),
            record,
            ratio,
        ))
    };
    let chart = |engine: &str| {
        let lines = kinds_frame_first()
            .map(|kind| Line::new(kind, compared.dots(|record| dot(engine, kind, record))));
        let lines: Vec<Line> = lines.filter(|line| !line.dots.is_empty()).collect();
        let axis = format!("times as fast as {engine}");
        let title = format!("against {engine}");
        figure(&title, ", all threads", (&axis, Some(1.0)), &lines)
    };
    html! {
        @if engines.is_empty() { p.note { "Neither the oracle nor a peer took part." } } @else {
            p { "How many times as fast as another tracer phalanx is on the same machine: geometric means over scenes of triangles, or all where there are none; peers by their best exact mode." }
            (compared.legend())
            div.grid { @for engine in &engines { (chart(engine)) } }
            (compared.tables("phalanx as a multiple"))
        }
    }
}

/// Rates in each scene that all records have.
pub(super) fn scenes(compared: &ComparedRecords<'_>) -> Markup {
    let (Some(threads), Some(first)) = (compared.threads, compared.best.first()) else {
        return html! { p.note { "The records have no rates in common." } };
    };
    let chart = |kind: &str| {
        let row = |record: usize, scene| compared.best[record].get(AUTO, scene, kind, threads);
        let shared = first.scenes.iter();
        let shared =
            shared.filter(|scene| (0..compared.best.len()).all(|r| row(r, scene).is_some()));
        let lines = shared.map(|scene| {
            let plain = scene.strip_prefix("standard:").unwrap_or(scene);
            let plain = plain.replace(':', " ");
            let dot = |record| Some(rate_dot(&plain, record, row(record, scene)?.mrays_per_s));
            Line {
                group: plain.split(' ').next().unwrap_or_default().to_owned(),
                ..Line::new(&plain, compared.dots(dot))
            }
        });
        let on = format!(", {}", threads_text(threads));
        let lines: Vec<Line> = lines.collect();
        figure(&kind_text(kind), &on, ("Mrays/s", None), &lines)
    };
    html! {
        p { "Rates of " code { "auto" } " with the interval in which another run would be 9 times in 10." }
        (compared.legend())
        div.grid { @for kind in &first.kinds { (chart(kind)) } }
    }
}

/// Differences from the first record.
pub(super) fn baseline(compared: &ComparedRecords<'_>) -> Markup {
    let Some(first) = compared.comparison.records.first() else {
        return html! {};
    };
    let chart = |threads: u32| {
        let on = format!(" over {}, {}", first.label, threads_text(threads));
        let value = |mean: &MeanRates, record: usize| {
            let change = mean.mrays_per_s.get(record).filter(|_| record > 0)? / mean.mrays_per_s[0];
            Some((change, signed_percent(change - 1.0)))
        };
        let axis = ("times the baseline's rate", Some(1.0));
        means_chart(compared, threads, (&on, axis), value)
    };
    html! {
        p {
            "The baseline is " (compared.name(0)) ". Where a record is of the same machine, changes are beyond the machine's own. "
            "Intervals hold 99.95 %, those of a kernel as a whole 95 %."
        }
        div.grid { @if let Some(threads) = compared.threads { (chart(threads)) } }
        @let changes = changes(compared.comparison, usize::MAX);
        @if changes.rows.is_empty() { p.note { "Nothing differs by more than " (percent(compared.comparison.threshold)) "." } }
        (changes.page())
    }
}

/// A share as per cent with one decimal and its sign.
fn signed_percent(share: f64) -> String {
    known(share, || {
        numbers::signed_percent(share).replace(' ', &THIN.to_string())
    })
}
