//! The top of the page: what was measured on which machine, the headline, and the warnings.

use super::dots::{Dot, Line, dot_figure};
use super::svg::{legend, look};
use super::tables::cell;
use super::view::{RecordView, kind_text, threads_text};
use crate::numbers::{self, NONE, count, measured, page_counted, percent, seconds, times};
use crate::report_table::ReportTable;
use crate::text::listed;
use crate::{BenchRecord, Cache, Machine, ORACLE, PHALANX, RateRow, SpeedRatio, is_peer};
use maud::{Markup, html};
use std::collections::BTreeMap;

/// Intervals wider than this share of the median are worth a warning.
const WIDE: f64 = 0.15;

/// Facts of the run: machine, program, time.
pub(super) fn facts(record: &BenchRecord) -> Markup {
    let (program, machine, run) = (&record.program, &record.machine, &record.run);
    let revision = program.git_revision.as_deref().unwrap_or("not known");
    html! {
        dl.facts {
            dt { "Machine" } dd { (machine_text(record)) }
            @if let Some(kernel) = &machine.kernel { dt { "System" } dd { (kernel) } }
            dt { "Program" }
            dd {
                "phalanx " (program.version) ", commit " code { (revision) }
                @if program.git_dirty == Some(true) { ", with changes" }
                ", profile " (program.profile)
                ", compiled for " (program.isa_compiled)
                @if let Some(rustc) = &program.rustc { " by " (rustc) }
            }
            @if !run.peers.is_empty() { dt { "Peers" } dd { (listed(&run.peers)) } }
            dt { "Taken" }
            dd {
                (moment(&run.started)) ", in " (seconds(run.seconds)) "; " (run.size[0]) "×" (run.size[1]) " rays, "
                (page_counted(run.repeat as usize, "sample")) " a row, at least " (seconds(run.min_time)) " each"
                @if run.pinned { ", workers bound to cores" }
                ", trees of quality " (run.quality)
            }
            dt { "Command" } dd { code { "phalanx " (run.arguments.join(" ")) } }
        }
    }
}

/// A time in readable form; a text that is not a time stays as it is.
fn moment(started: &str) -> String {
    let parts = started.split_once('T');
    let utc = parts.and_then(|(day, time)| Some((day, time.strip_suffix('Z')?)));
    utc.map_or(started.to_owned(), |(day, time)| {
        let seconds: String = time.chars().take(8).collect();
        format!("{day} {seconds} UTC")
    })
}

fn machine_text(record: &BenchRecord) -> String {
    let machine = &record.machine;
    let mut parts = vec![match machine.cpu.as_str() {
        "" => "a CPU without a name".to_owned(),
        name => name.to_owned(),
    }];
    if let Some(cores) = machine.cores {
        parts.push(page_counted(cores as usize, "core"));
    }
    if machine.threads > 0 {
        parts.push(threads_text(machine.threads));
    }
    parts.extend(cache_text(machine));
    if let Some(bytes) = machine.memory_bytes {
        parts.push(format!("{} memory", numbers::binary_bytes(bytes)));
    }
    parts.join(", ")
}

/// Sizes of the caches of data, first level first.
pub(super) fn cache_text(machine: &Machine) -> Vec<String> {
    let caches = machine.caches.iter().filter(|c| c.kind != "instruction");
    let mut caches: Vec<_> = caches.collect();
    caches.sort_by_key(|c| c.level);
    let size = |c: &&Cache| format!("L{} {}", c.level, numbers::binary_bytes(c.bytes));
    caches.iter().map(size).collect()
}

/// Warnings; nothing where there are none.
pub(super) fn warnings(view: &RecordView<'_>) -> Markup {
    let mut warnings = about_the_run(view.record);
    warnings.extend(inexact(&view.record.rows));
    warnings.extend(wide_intervals(&view.record.rows));
    html! {
        @if !warnings.is_empty() {
            aside.warnings aria-labelledby="beware" {
                h2 #beware { "Beware" }
                ul { @for warning in &warnings { li { (warning) } } }
            }
        }
    }
}

fn about_the_run(record: &BenchRecord) -> Vec<String> {
    let (program, machine, run) = (&record.program, &record.machine, &record.run);
    let (profile, available, compiled) = (
        &program.profile,
        &program.isa_available,
        &program.isa_compiled,
    );
    let governor = machine.governor.as_ref().filter(|g| *g != "performance");
    let host = machine.hypervisor.as_ref().filter(|h| !h.is_empty());
    let warnings = [
        (program.git_dirty == Some(true)).then(|| {
            "The sources differed from the commit, so this build is not reproducible.".to_owned()
        }),
        (profile != "release").then(|| format!("Built with the profile {profile}, not release.")),
        (!available.is_empty() && compiled != available)
            .then(|| format!("The CPU has {available}, but the program was compiled for {compiled}.")),
        governor.map(|governor| format!("The frequency governor was {governor}, not performance: clocks may have changed during the run.")),
        host.map(|host| {
            format!("A virtual machine ({host}): its neighbours take part in what is measured.")
        }),
        run.partial.then(|| "The run was ended early: rates or samples are missing.".to_owned()),
        record.rows.iter().any(|r| !r.has_rate())
            .then(|| "Some rows hold no rate and are left out.".to_owned()),
    ];
    warnings.into_iter().flatten().collect()
}

/// A line for each mode of a peer whose results differ from ours, with the scene where most differ.
fn inexact(rows: &[RateRow]) -> Vec<String> {
    let mut modes: BTreeMap<(&str, &str), Vec<&RateRow>> = BTreeMap::new();
    for row in rows.iter().filter(|r| is_peer(&r.engine) && !r.exact) {
        let mode = modes.entry((&row.engine, &row.kernel));
        mode.or_default().push(row);
    }
    let lines = modes.into_iter().map(|((engine, kernel), rows)| {
        let difference = |row: &&&RateRow| row.difference.unwrap_or(f64::NAN);
        let worst = rows.iter().max_by(|a, b| difference(a).total_cmp(&difference(b)));
        let share = percent(worst.and_then(|r| r.difference).unwrap_or(f64::NAN));
        let where_most = worst.map(|r| format!("{}, {}", r.scene, r.rays)).unwrap_or_default();
        let number = page_counted(rows.len(), "row");
        format!("{engine} {kernel} is inexact in {number}: up to {share} of rays are answered otherwise ({where_most}). It does not count as a best mode there.")
    });
    lines.collect()
}

fn wide_intervals(rows: &[RateRow]) -> Option<String> {
    let rates = rows.iter().filter(|r| r.has_rate()).map(|r| r.mrays_per_s);
    let wide = rates.filter(|rate| rate.high - rate.low > WIDE * rate.median);
    let (wide, all, limit) = (wide.count(), page_counted(rows.len(), "row"), percent(WIDE));
    (wide > 0)
        .then(|| format!("The intervals of {wide} of {all} are wider than {limit} of the median."))
}

/// The headline: two sentences, charts and a table.
pub(super) fn headline(view: &RecordView<'_>) -> Markup {
    let Some((&most, fewer)) = view.threads.split_last() else {
        return html! { p.note { "The record has no rates." } };
    };
    let sentences = sentences(view, most);
    html! {
        @for sentence in &sentences { p.lead { (sentence) } }
        @if sentences.is_empty() {
            p.note { "Neither the oracle nor a peer took part, so there is nothing to compare with." }
        } @else {
            div.grid {
                @for &threads in view.threads.iter().rev() { (chart(view, threads)) }
                (ratio_table(view, most).page())
            }
            (engines(view))
            @for threads in fewer.iter().rev() { (ratio_table(view, *threads).folded()) }
        }
    }
}

fn sentences(view: &RecordView<'_>, threads: u32) -> Vec<String> {
    let sentence = |other: &str, ratio: &dyn Fn(&str) -> Option<SpeedRatio>| {
        let ratios = view.kinds.iter();
        let ratios = ratios.filter_map(|kind| Some((kind_text(kind), times(ratio(kind)?.mean))));
        let parts = ratios.enumerate().map(|(i, (kind, times))| match i {
            0 => format!("{times} as fast as {other} for {kind}"),
            _ => format!("{times} for {kind}"),
        });
        let parts: Vec<String> = parts.collect();
        let (on, speeds) = (threads_text(threads), listed(&parts));
        let scenes = view.index.averaged_words();
        (!parts.is_empty())
            .then(|| format!("On {on}, phalanx is {speeds} (geometric means over {scenes})."))
    };
    let best = sentence("the best exact peer", &|kind| {
        view.index.over_best_peer(kind, threads)
    });
    let oracle = sentence("its scalar oracle", &|kind| {
        view.index.over(ORACLE, kind, threads)
    });
    best.into_iter().chain(oracle).collect()
}

/// The engines that ours is compared with.
fn others<'a>(view: &RecordView<'a>) -> impl Iterator<Item = (usize, &'a str)> {
    let engines = view.index.engines.clone().into_iter().enumerate();
    engines.filter(|(_, engine)| *engine != PHALANX)
}

fn chart(view: &RecordView<'_>, threads: u32) -> Markup {
    let dot = |kind: &str, style: usize, engine: &str| {
        let ratio = view.index.over(engine, kind, threads)?;
        let values = [ratio.least, ratio.mean, ratio.most];
        let [least, mean, most] = values.map(times);
        let name = format!("{kind}: {mean} as fast as {engine} ({least} to {most} by scene)");
        Some(Dot::new(name, style, values))
    };
    let lines = view.kinds.iter().map(|kind| {
        let dots = others(view).filter_map(|(style, engine)| dot(kind, style, engine));
        Line::new(kind, dots)
    });
    let lines: Vec<Line> = lines.filter(|l| !l.dots.is_empty()).collect();
    let on = threads_text(threads);
    let label = format!(
        "How many times as fast as each other engine auto is, by kind of rays, on {on}; the table below holds the numbers."
    );
    let more = format!(" against others, {on}");
    let axis = ("times as fast as …", Some(1.0));
    dot_figure(("phalanx auto", &more), &label, axis, &lines)
}

fn engines(view: &RecordView<'_>) -> Markup {
    let keys = others(view).map(|(i, engine)| {
        let mode = if is_peer(engine) { ", best exact mode" } else { "" };
        (look(i), format!("against {engine}{mode}"))
    });
    let bars = html! { li { "bars reach from the least to the greatest of these scenes" } };
    legend(keys, bars)
}

fn ratio_table(view: &RecordView<'_>, threads: u32) -> ReportTable<Markup> {
    let index = &view.index;
    let peers = index.has_peers();
    let row = |kind: &&str| {
        let best = index.over_best_peer(kind, threads);
        let oracle = index.over(ORACLE, kind, threads);
        let scenes = best.iter().chain(&oracle).map(|r| r.scenes).max()?;
        let mut cells = vec![cell(kind)];
        cells.extend(peers.then(|| ratio_cell(best)));
        cells.extend([ratio_cell(oracle), cell(count(scenes as u64))]);
        Some(cells)
    };
    let head = if peers {
        "rays | over best exact peer | over oracle | scenes"
    } else {
        "rays | over oracle | scenes"
    };
    let (on, scenes) = (threads_text(threads), index.averaged_words());
    let title = format!("phalanx auto on {on}: mean over {scenes}, least and greatest");
    ReportTable::new(title, head, 1).with(view.kinds.iter().filter_map(row))
}

fn ratio_cell(ratio: Option<SpeedRatio>) -> Markup {
    let Some(ratio) = ratio else {
        return cell(NONE);
    };
    html! {
        (times(ratio.mean))
        small { (measured(ratio.least)) "–" (measured(ratio.most)) }
    }
}
