//! Several records as a page: the machines, means, the ratios to other tracers, scenes, and the
//! differences from the first record.

use super::dots::{Dot, Line, dot_plot};
use super::rates::rate_name;
use super::svg::{MarkerShape, Tint, key};
use super::tables::{cell, folded_table, table};
use super::view::{commit_text, day, kind_text, threads_text};
use super::{number_format, summary};
use crate::comparison::{self, ComparisonTable};
use crate::{AUTO, BenchRecord, Estimate, MeanRates, RecordComparison, RecordIndex, quotable_line};
use maud::{Markup, html};

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
        ComparedRecords {
            comparison,
            records,
            best: records
                .iter()
                .map(|(_, r)| RecordIndex::of(&r.rows))
                .collect(),
            threads: comparison.means.iter().map(|mean| mean.threads).max(),
        }
    }

    /// Record by its index: letter, and what tells it from the others.
    fn name(&self, record: usize) -> String {
        let of = self.records[record].1;
        let label = &self.comparison.records[record].label;
        format!("{label}: {}, {}", of.machine.cpu, day(of))
    }

    fn legend(&self) -> Markup {
        html! {
            ul.legend {
                @for record in 0..self.records.len() {
                    (key((Tint::Series(record), MarkerShape::of(record)), &self.name(record)))
                }
            }
        }
    }

    /// A dot for each record that has a value.
    fn dots(&self, value: impl Fn(usize) -> Option<(Estimate, String)>) -> Vec<Dot> {
        let dot = |record: usize| {
            let (estimate, name) = value(record)?;
            Some(Dot {
                name: format!("{}: {name}", self.comparison.records[record].label),
                letter: self.comparison.records[record].label.clone(),
                value: estimate.median,
                low: estimate.low,
                high: estimate.high,
                style: record,
            })
        };
        (0..self.records.len()).filter_map(dot).collect()
    }
}

/// A value without an interval.
fn exact(value: f64) -> Estimate {
    Estimate {
        median: value,
        mad: 0.0,
        low: f64::NAN,
        high: f64::NAN,
    }
}

fn figure(title: &str, more: &str, caption: &str, lines: &[Line], mark: Option<f64>) -> Markup {
    if lines.iter().all(|line| line.dots.is_empty()) {
        return html! {};
    }
    let label = format!("{title}{more}, a dot for each record; the tables hold the numbers.");
    html! {
        figure {
            figcaption { strong { (title) } (more) }
            (dot_plot(&label, caption, lines, mark))
        }
    }
}

/// Tables of the comparison whose titles begin so.
fn tables_of(of: &ComparedRecords<'_>, start: &str) -> Markup {
    let tables = comparison::comparison_tables(of.comparison);
    let wanted = tables.iter().filter(|table| table.title.starts_with(start));
    html! { @for wanted in wanted { (page_table(wanted, table)) } }
}

type TableMaker = fn(&str, &[String], usize, Vec<Vec<Markup>>) -> Markup;

fn page_table(of: &ComparisonTable, make: TableMaker) -> Markup {
    let rows = of.rows.iter();
    let rows = rows.map(|row| row.iter().map(cell).collect()).collect();
    html! {
        (make(&of.title, &of.head, of.texts, rows))
        @if !of.note.is_empty() { p.note { (of.note) } }
    }
}

/// The line to quote of each record, and ranks.
pub(super) fn headline(of: &ComparedRecords<'_>) -> Markup {
    html! {
        @for (i, (_, record)) in of.records.iter().enumerate() {
            @if let Some(line) = quotable_line(record) { p { strong { (of.name(i)) } ", " (line) } }
        }
        (tables_of(of, "ranks"))
    }
}

/// The table of machines, a row for each record.
pub(super) fn machines(of: &ComparedRecords<'_>) -> Markup {
    let row = |(i, (name, record)): (usize, &(&str, &BenchRecord))| {
        let (machine, program) = (&record.machine, &record.program);
        let known = |text: Option<String>| cell(text.unwrap_or(number_format::NONE.to_owned()));
        vec![
            cell(&of.comparison.records[i].label),
            cell(&machine.cpu),
            cell(match machine.hypervisor.as_deref() {
                Some("") => "none",
                Some(name) => name,
                None => number_format::NONE,
            }),
            cell(program.isa_compiled.as_str()),
            html! { (program.version) " " code { (commit_text(program)) } },
            cell(record.run.quality.as_str()),
            cell(record.run.peers.join(", ")),
            cell(day(record)),
            cell(name),
            known(machine.cores.map(|cores| cores.to_string())),
            cell(machine.threads.to_string()),
            cell(summary::cache_text(machine).join(", ")),
            known(machine.memory_bytes.map(number_format::binary_bytes)),
        ]
    };
    let head = [
        "record",
        "CPU",
        "hypervisor",
        "built for",
        "phalanx",
        "trees",
        "peers",
        "day",
        "file",
        "cores",
        "hardware threads",
        "caches",
        "memory",
    ];
    let rows = of.records.iter().enumerate().map(row).collect();
    html! {
        (table("Machines and programs", &head, 9, rows))
        @for record in &of.comparison.records {
            @for remark in &record.remarks { p.note { (record.label) ": " (remark) } }
        }
    }
}

/// A chart of our means by kind of rays: a dot for each record that has a value, which comes with
/// its words. Its title is followed by more, by the caption of the axis, and by the value to mark.
fn means_chart(
    of: &ComparedRecords<'_>,
    threads: u32,
    (more, caption, mark): (&str, &str, Option<f64>),
    value: impl Fn(&MeanRates, usize) -> Option<(f64, String)>,
) -> Markup {
    let means = of.comparison.means.iter();
    let lines = means
        .filter(|mean| mean.threads == threads)
        .map(|mean| Line {
            label: mean.rays.clone(),
            group: String::new(),
            dots: of.dots(|record| {
                let (value, words) = value(mean, record)?;
                Some((exact(value), format!("{}, {words}", mean.rays)))
            }),
        });
    let lines: Vec<Line> = lines.collect();
    figure("phalanx auto", more, caption, &lines, mark)
}

/// Geometric means by kind of rays.
pub(super) fn rates(of: &ComparedRecords<'_>) -> Markup {
    let mut threads: Vec<u32> = of
        .comparison
        .means
        .iter()
        .map(|mean| mean.threads)
        .collect();
    threads.sort_unstable();
    threads.dedup();
    let chart = |threads: u32| {
        let on = format!(", {}", threads_text(threads));
        let value = |mean: &MeanRates, record: usize| {
            let rate = *mean.mrays_per_s.get(record)?;
            let shown = number_format::measured(rate);
            Some((rate, format!("{shown} Mrays/s")))
        };
        means_chart(of, threads, (&on, "Mrays/s", None), value)
    };
    html! {
        @if threads.is_empty() { p.note { "The records have no rates in common." } }
        (of.legend())
        div.grid { @for threads in threads.iter().rev() { (chart(*threads)) } }
        (tables_of(of, "phalanx, Mrays/s"))
    }
}

/// Ratios to other tracers by kind of rays.
pub(super) fn ratios(of: &ComparedRecords<'_>) -> Markup {
    let mut engines: Vec<&str> = of
        .comparison
        .ratios
        .iter()
        .map(|r| r.engine.as_str())
        .collect();
    engines.dedup();
    let most = |record: usize| of.best[record].threads.last().copied();
    let chart = |engine: &str| {
        let lines = crate::kinds_frame_first().map(|kind| Line {
            label: kind.to_owned(),
            group: String::new(),
            dots: of.dots(|record| {
                let threads = most(record)?;
                let ratio = of.best[record].over(engine, kind, threads)?.mean;
                let (times, on) = (number_format::times(ratio), threads_text(threads));
                Some((exact(ratio), format!("{kind}, {times} as fast, {on}")))
            }),
        });
        let lines: Vec<Line> = lines.filter(|line| !line.dots.is_empty()).collect();
        let caption = format!("times as fast as {engine}");
        figure(
            &format!("against {engine}"),
            ", all threads",
            &caption,
            &lines,
            Some(1.0),
        )
    };
    html! {
        @if engines.is_empty() { p.note { "Neither the oracle nor a peer took part." } } @else {
            p { "How many times as fast as another tracer phalanx is on the same machine: geometric means over scenes, peers by their best exact mode." }
            (of.legend())
            div.grid { @for engine in &engines { (chart(engine)) } }
            (tables_of(of, "phalanx as a multiple"))
        }
    }
}

/// Rates in each scene that all records have.
pub(super) fn scenes(of: &ComparedRecords<'_>) -> Markup {
    let (Some(threads), Some(first)) = (of.threads, of.best.first()) else {
        return html! { p.note { "The records have no rates in common." } };
    };
    let chart = |kind: &str| {
        let row = |record: usize, scene| of.best[record].get(AUTO, scene, kind, threads);
        let shared = first.scenes.iter();
        let shared = shared.filter(|scene| (0..of.best.len()).all(|r| row(r, scene).is_some()));
        let lines = shared.map(|scene| {
            let plain = scene
                .strip_prefix("standard:")
                .unwrap_or(scene)
                .replace(':', " ");
            Line {
                group: plain.split(' ').next().unwrap_or_default().to_owned(),
                dots: of.dots(|record| {
                    let rate = row(record, scene)?.mrays_per_s;
                    Some((rate, rate_name(&plain, rate)))
                }),
                label: plain,
            }
        });
        let lines: Vec<Line> = lines.collect();
        let on = format!(", {}", threads_text(threads));
        figure(&kind_text(kind), &on, "Mrays/s", &lines, None)
    };
    html! {
        p { "Rates of " code { "auto" } " with the interval in which another run would be 9 times in 10." }
        (of.legend())
        div.grid { @for kind in &first.kinds { (chart(kind)) } }
    }
}

/// Differences from the first record.
pub(super) fn baseline(of: &ComparedRecords<'_>) -> Markup {
    let Some(first) = of.comparison.records.first() else {
        return html! {};
    };
    let chart = |threads: u32| {
        let on = format!(" over {}, {}", first.label, threads_text(threads));
        let value = |mean: &MeanRates, record: usize| {
            let change = mean.mrays_per_s.get(record).filter(|_| record > 0)? / mean.mrays_per_s[0];
            Some((change, super::baseline::signed_percent(change - 1.0)))
        };
        means_chart(
            of,
            threads,
            (&on, "times the baseline's rate", Some(1.0)),
            value,
        )
    };
    let differing = comparison::differing(of.comparison, usize::MAX);
    html! {
        p {
            "The baseline is " (of.name(0)) ". Where a record is of the same machine, changes are beyond the machine's own. Rates count as "
            "different where the whole 99.9 % interval of the difference is beyond " (number_format::percent(of.comparison.threshold)) "."
        }
        div.grid { @if let Some(threads) = of.threads { (chart(threads)) } }
        @if differing.rows.is_empty() {
            p.note { "No rate differs." }
        } @else {
            (page_table(&differing, folded_table))
        }
    }
}
