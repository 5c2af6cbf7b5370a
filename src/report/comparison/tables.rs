//! A comparison as tables: for the terminal, and in Markdown.

use super::log_rate::RateChange;
use super::rates::ComparedRate;
use super::{ComparedRecord, RecordComparison};
use crate::PHALANX;
use crate::numbers::{counted, rate, signed_percent, threshold};
use crate::report_table::ReportTable;
use crate::text::{day, markdown, short_commit, short_name, wrapped};
use std::collections::BTreeSet;

/// Most differing rates of a table that nobody asked to be whole.
const MAX_RATES: usize = 24;

/// Longest name of a scene in a table, whose other columns take the rest of 80.
const SCENE_LENGTH: usize = 14;

/// The scenes of means and ranks.
const OF_TRIANGLES: &str = " (scenes of triangles, if any)";

/// The tables of a comparison: ranks first, then means, then rates.
pub fn comparison_tables(of: &RecordComparison) -> Vec<ReportTable> {
    let mut tables = vec![ranks(of), means(of), ratios(of), kernels(of)];
    if of.all {
        tables.extend(every_rate(of))
    } else {
        tables.push(differing(of, MAX_RATES))
    }
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// A comparison for a terminal of `width` columns.
pub fn comparison_text(of: &RecordComparison, width: usize) -> String {
    let mut text = String::from("records\n");
    for record in &of.records {
        text += &format!("  {}  {}\n", record.label, record.name);
        for line in record_lines(record) {
            text += &wrapped(&line, "     ", width);
        }
    }
    for table in comparison_tables(of) {
        text += &format!("\n{}", table.text(width));
    }
    for (i, line) in closing(of).iter().enumerate() {
        text += if i == 0 { "\n" } else { "" };
        text += &wrapped(line, "", width);
    }
    text
}

/// A comparison as Markdown.
pub fn comparison_markdown(of: &RecordComparison) -> String {
    let mut text = String::new();
    for record in &of.records {
        let (label, name) = (&record.label, markdown(&record.name));
        let facts = markdown(&record_lines(record).join("; "));
        text += &format!("- **{label}** {name}: {facts}\n");
    }
    for table in comparison_tables(of) {
        text += &table.markdown();
    }
    for line in closing(of) {
        text += &format!("\n{}\n", markdown(&line));
    }
    text
}

/// Machine and program of a record, and its differences from the first.
fn record_lines(record: &ComparedRecord) -> Vec<String> {
    let threads = counted(record.threads as usize, "hardware thread");
    let machine = format!("{}, {threads}, built for {}", record.cpu, record.isa);
    let mut program = format!("phalanx {}", record.version);
    if let Some(commit) = &record.commit {
        program += &format!(" {}", short_commit(commit));
    }
    program += &format!(", {}", day(&record.started));
    program.extend(record.peers.iter().map(|peer| format!(", {peer}")));
    let mut lines = vec![machine, program];
    lines.extend(record.machine.map(|machine| {
        let by = signed_percent(machine.by);
        format!("the machine itself: {by} against A; changes of rates are beyond that")
    }));
    lines.extend(record.remarks.clone());
    lines
}

fn ranks(of: &RecordComparison) -> ReportTable {
    let rows = of.ranks.iter().map(|rank| {
        vec![
            rank.rank.to_string(),
            of.records[rank.record].label.clone(),
            rank.engine.clone(),
            format!("{:.2}", rank.slowdown),
            rate(rank.mrays_per_s),
        ]
    });
    let (rates, scenes) = (
        counted(of.ranked_rates, "rate"),
        counted(of.ranked_scenes, "scene"),
    );
    let title = format!("ranks over {rates} of {scenes} that all of these have{OF_TRIANGLES}");
    let mut table =
        ReportTable::new(title, "rank | record | tracer | slowdown | Mrays/s", 3).with(rows);
    table.note = "slowdown: geometric mean of the fastest rate of each measurement over this one; 1.00 is always the fastest. \
                  phalanx by its kernel auto, peers by their best exact mode of each measurement"
        .to_owned();
    table
}

fn means(of: &RecordComparison) -> ReportTable {
    let scenes = of.means.iter().map(|mean| mean.scenes).max().unwrap_or(0);
    let scenes = counted(scenes, "scene");
    let title = format!("phalanx, Mrays/s, geometric means over {scenes}{OF_TRIANGLES}");
    let rows = of.means.iter().map(|mean| {
        let mut cells = vec![mean.rays.clone(), mean.threads.to_string()];
        for (i, &mrays) in mean.mrays_per_s.iter().enumerate() {
            cells.push(rate(mrays));
            cells.extend((i > 0).then(|| signed_percent(mrays / mean.mrays_per_s[0] - 1.0)));
        }
        cells
    });
    with_changes(of, ReportTable::new(title, "rays | threads", 1)).with(rows)
}

fn ratios(of: &RecordComparison) -> ReportTable {
    let title =
        format!("{PHALANX} as a multiple of other tracers, means of each record{OF_TRIANGLES}");
    let mut table = ReportTable::new(title, "tracer | threads", 1);
    table.names = 2;
    let labels = of.records.iter().map(|record| record.label.clone());
    table.head.extend(labels);
    table.with(of.ratios.iter().map(|ratios| {
        let mut cells = vec![ratios.engine.clone(), ratios.threads.to_string()];
        let ratio = |ratio: &Option<f64>| ratio.map_or("-".to_owned(), |r| format!("{r:.2}"));
        cells.extend(ratios.ratios.iter().map(ratio));
        cells
    }))
}

/// The kernels that have changed as a whole.
fn kernels(of: &RecordComparison) -> ReportTable {
    let title = format!("{PHALANX}'s kernels that have changed as a whole, medians of their rates");
    let mut table = ReportTable::new(title, "record | kernel | threads | rates | change", 2);
    table.names = 3;
    table.with(of.kernels.iter().map(|change| {
        vec![
            of.records[change.record].label.clone(),
            change.kernel.clone(),
            change.threads.to_string(),
            change.rates.to_string(),
            change_text(&change.change),
        ]
    }))
}

/// The rates that differ most, `limit` of them at most.
pub(crate) fn differing(of: &RecordComparison, limit: usize) -> ReportTable {
    let mut title = differ(of, &of.differing.to_string(), "differ");
    if of.differing > limit {
        title += &format!("; the {limit} largest");
    }
    let table = ReportTable::new(title, "scene | rays | tracer | threads", 3);
    with_changes(of, table).with(of.rates.iter().take(limit).map(|compared| {
        let mut cells = vec![
            short_name(&compared.scene, SCENE_LENGTH),
            compared.rays.clone(),
            compared.engine.clone(),
            compared.threads.to_string(),
        ];
        cells.extend(rate_cells(compared));
        cells
    }))
}

/// Every rate, in a table for each scene and number of threads.
fn every_rate(of: &RecordComparison) -> Vec<ReportTable> {
    let group = |rate: &ComparedRate| (rate.scene.clone(), rate.threads);
    let groups: BTreeSet<(String, u32)> = of.rates.iter().map(group).collect();
    let row = |compared: &ComparedRate| {
        let kernel = compared.kernels.first().map_or("", String::as_str);
        let star = if compared.differs { " *" } else { "" };
        let tracer = format!("{} {kernel}{star}", compared.engine);
        let mut cells = vec![compared.rays.clone(), tracer];
        cells.extend(rate_cells(compared));
        cells
    };
    let table = |(scene, threads): (String, u32)| {
        let title = format!("{scene}, {}", counted(threads as usize, "thread"));
        let rates = of.rates.iter();
        let rates = rates.filter(|rate| (&rate.scene, rate.threads) == (&scene, threads));
        let table = ReportTable::new(title, "rays | tracer and kernel", 2);
        with_changes(of, table).with(rates.map(row))
    };
    groups.into_iter().map(table).collect()
}

/// The table, whose columns name its rows, with one for each record, and one for each difference
/// from the first.
fn with_changes(of: &RecordComparison, mut table: ReportTable) -> ReportTable {
    table.names = table.head.len();
    for (i, record) in of.records.iter().enumerate() {
        table.head.push(record.label.clone());
        if i > 0 {
            table.joined.push(table.head.len());
            table.head.push("change".to_owned());
        }
    }
    table
}

fn rate_cells(compared: &ComparedRate) -> Vec<String> {
    let changes = compared.changes.iter();
    let changes = changes.map(|change| Some(change_text(change)));
    let changes = [None].into_iter().chain(changes);
    let cells = compared.rates.iter().zip(changes);
    let cells = cells.flat_map(|(estimate, change)| [Some(rate(estimate.median)), change]);
    cells.flatten().collect()
}

/// A change with half its interval.
fn change_text(change: &RateChange) -> String {
    let by = signed_percent(change.by);
    let by = by.trim_end_matches(" %");
    if change.is_known() {
        format!("{by} ± {:.1} %", 50.0 * (change.high - change.low))
    } else {
        format!("{by} ±    ? %")
    }
}

/// A sentence about the number of rates that differ, with the verb's form for it.
fn differ(of: &RecordComparison, number: &str, verb: &str) -> String {
    let (rates, share) = (counted(of.compared, "rate"), threshold(of.threshold));
    format!("{number} of {rates} {verb} by more than {share}, the whole interval")
}

/// Remarks on rates that the tables do not list.
fn closing(of: &RecordComparison) -> Vec<String> {
    let mut lines = vec![match (of.all, of.differing) {
        (true, differing) => differ(of, &format!("* {differing}"), "differ"),
        (false, 0) => differ(of, "None", "differs"),
        (false, _) => "--all lists every rate of every kernel".to_owned(),
    }];
    if of.left_out > 0 {
        let rows = counted(of.left_out, "row");
        lines.push(format!(
            "left out: up to {rows} of a record that others lack"
        ));
    }
    lines
}
