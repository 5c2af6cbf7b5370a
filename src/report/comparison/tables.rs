//! A comparison as tables: for the terminal, and in Markdown.

use super::log_rate::RateChange;
use super::rates::ComparedRate;
use super::{ComparedRecord, GroupChange, RecordComparison, Regressions};
use crate::PHALANX;
use crate::numbers::{self, counted, rate, signed_percent, threshold};
use crate::report_table::ReportTable;
use crate::text::{day, markdown, short_commit, short_name, wrapped};
use std::collections::BTreeSet;

/// Rates listed unless `--all` is given.
const MAX_RATES: usize = 24;

/// Longest name of a scene in a table, whose other columns take the rest of 80.
const SCENE_LENGTH: usize = 14;

/// The scenes of means and ranks.
const TRIANGLES: &str = " (scenes of triangles, if any)";

/// The tables of a comparison: ranks first, then means, then changes.
pub fn comparison_tables(comparison: &RecordComparison) -> Vec<ReportTable> {
    let mut tables = vec![ranks(comparison), means(comparison), ratios(comparison)];
    tables.push(changes(comparison, MAX_RATES));
    if comparison.all {
        tables.extend(every_rate(comparison));
    }
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// A comparison for a terminal of `width` columns.
pub fn comparison_text(comparison: &RecordComparison, width: usize) -> String {
    let mut text = String::from("records\n");
    for record in &comparison.records {
        text += &format!("  {}  {}\n", record.label, record.name);
        for line in record_lines(record) {
            text += &wrapped(&line, "     ", width);
        }
    }
    for table in comparison_tables(comparison) {
        text += &format!("\n{}", table.text(width));
    }
    for (i, line) in closing(comparison).iter().enumerate() {
        text += if i == 0 { "\n" } else { "" };
        text += &wrapped(line, "", width);
    }
    text
}

/// A comparison as Markdown.
pub fn comparison_markdown(comparison: &RecordComparison) -> String {
    let mut text = String::new();
    for record in &comparison.records {
        let (label, name) = (&record.label, markdown(&record.name));
        let facts = markdown(&record_lines(record).join("; "));
        text += &format!("- **{label}** {name}: {facts}\n");
    }
    for table in comparison_tables(comparison) {
        text += &table.markdown();
    }
    for line in closing(comparison) {
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
        let change = signed_percent(machine.by);
        format!("the machine itself: {change} against A; changes of rates are beyond that")
    }));
    lines.extend(record.remarks.clone());
    lines
}

fn ranks(comparison: &RecordComparison) -> ReportTable {
    let rows = comparison.ranks.iter().map(|rank| {
        vec![
            rank.rank.to_string(),
            comparison.records[rank.record].label.clone(),
            rank.engine.clone(),
            format!("{:.2}", rank.slowdown),
            rate(rank.mrays_per_s),
        ]
    });
    let (rates, scenes) = (
        counted(comparison.ranked_rates, "rate"),
        counted(comparison.ranked_scenes, "scene"),
    );
    let title = format!("ranks over {rates} of {scenes} that all of these have{TRIANGLES}");
    let mut table =
        ReportTable::new(title, "rank | record | tracer | slowdown | Mrays/s", 3).with(rows);
    table.note = "slowdown: geometric mean of the fastest rate of each measurement over this one; 1.00 is always the fastest. \
                  phalanx by its kernel auto, peers by their best exact mode of each measurement"
        .to_owned();
    table
}

fn means(comparison: &RecordComparison) -> ReportTable {
    let scenes = comparison
        .means
        .iter()
        .map(|mean| mean.scenes)
        .max()
        .unwrap_or(0);
    let scenes = counted(scenes, "scene");
    let title = format!("phalanx, Mrays/s, geometric means over {scenes}{TRIANGLES}");
    let rows = comparison.means.iter().map(|mean| {
        let mut cells = vec![mean.rays.clone(), mean.threads.to_string()];
        for (i, &mrays) in mean.mrays_per_s.iter().enumerate() {
            cells.push(rate(mrays));
            cells.extend((i > 0).then(|| signed_percent(mrays / mean.mrays_per_s[0] - 1.0)));
        }
        cells
    });
    with_changes(comparison, ReportTable::new(title, "rays | threads", 1)).with(rows)
}

fn ratios(comparison: &RecordComparison) -> ReportTable {
    let title =
        format!("{PHALANX} as a multiple of other tracers, means of each record{TRIANGLES}");
    let mut table = ReportTable::new(title, "tracer | threads", 1);
    table.names = 2;
    let labels = comparison.records.iter().map(|record| record.label.clone());
    table.head.extend(labels);
    table.with(comparison.ratios.iter().map(|ratios| {
        let mut cells = vec![ratios.engine.clone(), ratios.threads.to_string()];
        let ratio = |ratio: &Option<f64>| ratio.map_or("-".to_owned(), |r| format!("{r:.2}"));
        cells.extend(ratios.ratios.iter().map(ratio));
        cells
    }))
}

/// The changes: kernels first, then single rates, `limit` of them at most.
pub(crate) fn changes(comparison: &RecordComparison, limit: usize) -> ReportTable {
    let share = threshold(comparison.threshold);
    let groups = counted(comparison.groups.len(), "group");
    let rates = counted(comparison.compared, "single rate");
    let mut title = format!(
        "changes by more than {share}: {groups} of rates, and {} of {rates}",
        comparison.differing
    );
    let mut table_rows: Vec<Vec<String>> = comparison
        .groups
        .iter()
        .map(|group| group_cells(comparison, group))
        .collect();
    let mut note = "";
    if !comparison.all && comparison.differing > 0 {
        if comparison.differing > limit {
            title += &format!("; the {limit} largest");
        }
        note = SINGLE_RATE;
        let shown = comparison.rates.iter().take(limit);
        let changed = shown.flat_map(|rate| {
            let records = 1..=rate.changes.len();
            let exceeds = |i: &usize| rate.changes[i - 1].exceeds(comparison.threshold);
            let records = records.filter(exceeds);
            records.map(|record| change_cells(comparison, rate, record))
        });
        table_rows.extend(changed);
    }
    let mut table = change_table(title).with(table_rows);
    table.note = note.to_owned();
    table
}

/// Caution below changes of single rates.
const SINGLE_RATE: &str = "other load may slow a single rate for a whole run: believe it when a further run shows it, too";

/// The regressions that make `bench --fail-above` fail, or a sentence where there are none.
pub fn regressions_text(comparison: &RecordComparison, regressions: &Regressions) -> String {
    let share = threshold(comparison.threshold);
    if regressions.is_empty() {
        return format!("Nothing is slower by more than {share}.\n");
    }
    let groups = regressions.groups.iter();
    let rates = regressions.rates.iter();
    let cells = groups
        .map(|group| group_cells(comparison, group))
        .chain(rates.map(|rate| change_cells(comparison, rate, 1)));
    let title = format!("slower by more than {share}");
    change_table(title).with(cells).text(usize::MAX)
}

fn change_table(title: String) -> ReportTable {
    let head = "in | kernel | scene | rays | threads | Mrays/s | change";
    let mut table = ReportTable::new(title, head, 4);
    table.names = 5;
    table
}

fn group_cells(comparison: &RecordComparison, group: &GroupChange) -> Vec<String> {
    let all = || "all".to_owned();
    let scene = group.scene.as_ref();
    vec![
        comparison.records[group.record].label.clone(),
        group.kernel.clone(),
        scene.map_or_else(all, |scene| short_name(scene, SCENE_LENGTH)),
        group.rays.clone().unwrap_or_else(all),
        group.threads.to_string(),
        counted(group.rates, "rate"),
        change_text(&group.change),
    ]
}

/// Change of a rate from the first record to another.
fn change_cells(comparison: &RecordComparison, rate: &ComparedRate, record: usize) -> Vec<String> {
    let [old, new] = [0, record].map(|i| numbers::rate(rate.rates[i].median));
    vec![
        comparison.records[record].label.clone(),
        rate.tracer().to_owned(),
        short_name(&rate.scene, SCENE_LENGTH),
        rate.rays.clone(),
        rate.threads.to_string(),
        format!("{old} → {new}"),
        change_text(&rate.changes[record - 1]),
    ]
}

/// Every rate, in a table for each scene and number of threads.
fn every_rate(comparison: &RecordComparison) -> Vec<ReportTable> {
    let group = |rate: &ComparedRate| (rate.scene.clone(), rate.threads);
    let groups: BTreeSet<(String, u32)> = comparison.rates.iter().map(group).collect();
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
        let rates = comparison.rates.iter();
        let rates = rates.filter(|rate| (&rate.scene, rate.threads) == (&scene, threads));
        let table = ReportTable::new(title, "rays | tracer and kernel", 2);
        with_changes(comparison, table).with(rates.map(row))
    };
    groups.into_iter().map(table).collect()
}

/// The table, whose columns name its rows, with one for each record, and one for each difference
/// from the first.
fn with_changes(comparison: &RecordComparison, mut table: ReportTable) -> ReportTable {
    table.names = table.head.len();
    for (i, record) in comparison.records.iter().enumerate() {
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
    let percent = signed_percent(change.by);
    let percent = percent.trim_end_matches(" %");
    if change.is_known() {
        format!("{percent} ± {:.1} %", 50.0 * (change.high - change.low))
    } else {
        format!("{percent} ±    ? %")
    }
}

/// Remarks on rates that the tables do not list.
fn closing(comparison: &RecordComparison) -> Vec<String> {
    let (rates, share) = (
        counted(comparison.compared, "rate"),
        threshold(comparison.threshold),
    );
    let beyond = format!("of {rates} differs by more than {share}, the whole interval");
    let mut lines = vec![if comparison.differing == 0 {
        format!("None {beyond}")
    } else if comparison.all {
        format!(
            "* {} {}",
            comparison.differing,
            beyond.replacen("differs", "differ", 1)
        )
    } else {
        "--all lists every rate of every kernel".to_owned()
    }];
    if comparison.left_out > 0 {
        let rows = counted(comparison.left_out, "row");
        lines.push(format!(
            "left out: up to {rows} of a record that others lack"
        ));
    }
    lines
}
