//! A comparison as tables: for the terminal, and in Markdown.

use super::{ComparedRate, ComparedRecord, RecordComparison};
use crate::text::{self, ColumnLayout, counted, fitted_table, percent, rate, wrapped};
use crate::{PHALANX, RateChange};
use std::collections::BTreeSet;

/// Most differing rates of a table that nobody asked to be whole.
const MAX_RATES: usize = 24;

/// Longest name of a scene in a table, whose other columns take the rest of 80.
const SCENE_LENGTH: usize = 14;

/// A table with its title.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparisonTable {
    /// Title, which says what the rows are.
    pub title: String,
    /// Names of the columns.
    pub head: Vec<String>,
    /// Number of columns of text, which are flush left.
    pub texts: usize,
    /// Number of columns that name a row.
    pub names: usize,
    /// Columns that belong to the column before them.
    pub joined: Vec<usize>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
    /// Explanation, in a line below.
    pub note: String,
}

/// The tables of a comparison: ranks first, then means, then rates.
pub fn comparison_tables(of: &RecordComparison) -> Vec<ComparisonTable> {
    let mut tables = vec![ranks(of), means(of), ratios(of)];
    tables.push(kernels(of));
    match of.all {
        true => tables.extend(every_rate(of)),
        false => tables.push(differing(of, MAX_RATES)),
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
        let head: Vec<&str> = table.head.iter().map(String::as_str).collect();
        text += "\n";
        text += &wrapped(&table.title, "", width);
        let layout = ColumnLayout {
            left: table.texts,
            names: table.names,
            joined: &table.joined,
        };
        text += &fitted_table(&head, &table.rows, layout, width);
        text += &wrapped(&table.note, "  ", width);
    }
    let closing = closing(of);
    if !closing.is_empty() {
        text += "\n";
    }
    text + &closing
        .iter()
        .map(|line| wrapped(line, "", width))
        .collect::<String>()
}

/// A comparison as Markdown.
pub fn comparison_markdown(of: &RecordComparison) -> String {
    let mut text = String::new();
    for record in &of.records {
        let facts = record_lines(record).join("; ");
        let name = text::markdown(&record.name);
        text += &format!(
            "- **{}** {name}: {}\n",
            record.label,
            text::markdown(&facts)
        );
    }
    for table in comparison_tables(of) {
        text += &format!("\n{}:\n\n", text::markdown(&table.title));
        text += &escaped_row(&table.head);
        let rule = |column| if column < table.texts { "---" } else { "---:" };
        let rules: Vec<&str> = (0..table.head.len()).map(rule).collect();
        text += &format!("|{}|\n", rules.join("|"));
        text += &table
            .rows
            .iter()
            .map(|row| escaped_row(row))
            .collect::<String>();
        if !table.note.is_empty() {
            text += &format!("\n{}\n", text::markdown(&table.note));
        }
    }
    let closing = closing(of)
        .into_iter()
        .map(|line| format!("\n{}\n", text::markdown(&line)));
    text + &closing.collect::<String>()
}

fn escaped_row(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| text::markdown(cell)).collect();
    text::markdown_row(&cells)
}

/// Machine and program of a record, and its differences from the first.
fn record_lines(record: &ComparedRecord) -> Vec<String> {
    let threads = counted(record.threads as usize, "hardware thread");
    let machine = format!("{}, {threads}, built for {}", record.cpu, record.isa);
    let mut program = format!("phalanx {}", record.version);
    if let Some(commit) = &record.commit {
        program += &format!(" {}", text::short_commit(commit));
    }
    program += &format!(", {}", text::day(&record.started));
    program.extend(record.peers.iter().map(|peer| format!(", {peer}")));
    let speed = record.machine.map(|machine| {
        let by = percent(machine.by);
        let by = by.trim_start();
        format!("the machine itself: {by} against A; changes of rates are beyond that")
    });
    let remarks = record.remarks.clone();
    [machine, program]
        .into_iter()
        .chain(speed)
        .chain(remarks)
        .collect()
}

fn ranks(of: &RecordComparison) -> ComparisonTable {
    let row = |rank: &super::EngineRank| {
        vec![
            rank.rank.to_string(),
            of.records[rank.record].label.clone(),
            rank.engine.clone(),
            format!("{:.2}", rank.slowdown),
            rate(rank.mrays_per_s),
        ]
    };
    let (rates, scenes) = (
        counted(of.ranked_rates, "rate"),
        counted(of.ranked_scenes, "scene"),
    );
    ComparisonTable {
        title: format!("ranks over {rates} of {scenes} that all of these have"),
        head: heads(&["rank", "record", "tracer", "slowdown", "Mrays/s"]),
        texts: 3,
        names: 3,
        joined: Vec::new(),
        rows: of.ranks.iter().map(row).collect(),
        note: "slowdown: geometric mean of the fastest rate of each measurement over this one; 1.00 is always the fastest. \
               phalanx by its kernel auto, peers by their best exact mode of each measurement"
            .to_owned(),
    }
}

fn means(of: &RecordComparison) -> ComparisonTable {
    let (head, joined) = with_changes(of, &["rays", "threads"]);
    let row = |mean: &super::MeanRates| {
        let mut cells = vec![mean.rays.clone(), mean.threads.to_string()];
        for (i, &mrays) in mean.mrays_per_s.iter().enumerate() {
            cells.push(rate(mrays));
            cells.extend((i > 0).then(|| percent(mrays / mean.mrays_per_s[0] - 1.0)));
        }
        cells
    };
    let scenes: BTreeSet<usize> = of.means.iter().map(|mean| mean.scenes).collect();
    let scenes = scenes.last().copied().unwrap_or(0);
    ComparisonTable {
        title: format!(
            "phalanx, Mrays/s, geometric means over {}",
            counted(scenes, "scene")
        ),
        head,
        texts: 1,
        names: 2,
        joined,
        rows: of.means.iter().map(row).collect(),
        note: String::new(),
    }
}

fn ratios(of: &RecordComparison) -> ComparisonTable {
    let mut head = heads(&["tracer", "threads"]);
    head.extend(of.records.iter().map(|record| record.label.clone()));
    let row = |ratios: &super::MeanRatios| {
        let mut cells = vec![ratios.engine.clone(), ratios.threads.to_string()];
        let ratio = |ratio: &Option<f64>| ratio.map_or("-".to_owned(), |r| format!("{r:.2}"));
        cells.extend(ratios.ratios.iter().map(ratio));
        cells
    };
    ComparisonTable {
        title: format!("{PHALANX} as a multiple of other tracers, geometric means of each record"),
        head,
        texts: 1,
        names: 2,
        joined: Vec::new(),
        rows: of.ratios.iter().map(row).collect(),
        note: String::new(),
    }
}

/// The kernels that have changed as a whole.
fn kernels(of: &RecordComparison) -> ComparisonTable {
    let row = |change: &super::KernelChange| {
        vec![
            of.records[change.record].label.clone(),
            change.kernel.clone(),
            change.threads.to_string(),
            change.rates.to_string(),
            change_text(&change.change),
        ]
    };
    ComparisonTable {
        title: format!("{PHALANX}'s kernels that have changed as a whole, medians of their rates"),
        head: heads(&["record", "kernel", "threads", "rates", "change"]),
        texts: 2,
        names: 3,
        rows: of.kernels.iter().map(row).collect(),
        ..ComparisonTable::default()
    }
}

/// The rates that differ most, `limit` of them at most.
pub(crate) fn differing(of: &RecordComparison, limit: usize) -> ComparisonTable {
    let (head, joined) = with_changes(of, &["scene", "rays", "tracer", "threads"]);
    let row = |compared: &ComparedRate| {
        let mut cells = vec![
            text::short_name(&compared.scene, SCENE_LENGTH),
            compared.rays.clone(),
            compared.engine.clone(),
            compared.threads.to_string(),
        ];
        cells.extend(rate_cells(compared));
        cells
    };
    let mut title = format!(
        "{} of {} differ by more than {}, the whole interval",
        of.differing,
        counted(of.compared, "rate"),
        text::threshold(of.threshold)
    );
    if of.differing > limit {
        title += &format!("; the {limit} largest");
    }
    ComparisonTable {
        title,
        head,
        texts: 3,
        names: 4,
        joined,
        rows: of.rates.iter().take(limit).map(row).collect(),
        note: String::new(),
    }
}

/// Every rate, in a table for each scene and number of threads.
fn every_rate(of: &RecordComparison) -> Vec<ComparisonTable> {
    let groups: BTreeSet<(&str, u32)> = of
        .rates
        .iter()
        .map(|rate| (rate.scene.as_str(), rate.threads))
        .collect();
    let table = |(scene, threads): (&str, u32)| {
        let (head, joined) = with_changes(of, &["rays", "tracer and kernel"]);
        let rates = of.rates.iter();
        let rates = rates.filter(|rate| (rate.scene.as_str(), rate.threads) == (scene, threads));
        let row = |compared: &ComparedRate| {
            let kernel = compared.kernels.first().map_or("", String::as_str);
            let star = if compared.differs { " *" } else { "" };
            let tracer = format!("{} {kernel}{star}", compared.engine);
            let mut cells = vec![compared.rays.clone(), tracer];
            cells.extend(rate_cells(compared));
            cells
        };
        ComparisonTable {
            title: format!("{scene}, {}", counted(threads as usize, "thread")),
            head,
            texts: 2,
            names: 2,
            joined,
            rows: rates.map(row).collect(),
            note: String::new(),
        }
    };
    groups.into_iter().map(table).collect()
}

/// Columns after the first ones: one for each record, and one for each difference from the first.
/// Also the indices of the latter.
fn with_changes(of: &RecordComparison, first: &[&str]) -> (Vec<String>, Vec<usize>) {
    let (mut head, mut changes) = (heads(first), Vec::new());
    for (i, record) in of.records.iter().enumerate() {
        head.push(record.label.clone());
        if i > 0 {
            changes.push(head.len());
            head.push("change".to_owned());
        }
    }
    (head, changes)
}

fn rate_cells(compared: &ComparedRate) -> Vec<String> {
    let mut cells = Vec::new();
    for (i, estimate) in compared.rates.iter().enumerate() {
        cells.push(rate(estimate.median));
        let change = i.checked_sub(1).and_then(|i| compared.changes.get(i));
        cells.extend(change.map(change_text));
    }
    cells
}

/// A change with half its interval.
fn change_text(change: &RateChange) -> String {
    let by = percent(change.by);
    let by = by.trim_end_matches(" %");
    match change.is_known() {
        true => format!("{by} ± {:.1} %", 50.0 * (change.high - change.low)),
        false => format!("{by} ±    ? %"),
    }
}

/// Remarks on rates that the tables do not list.
fn closing(of: &RecordComparison) -> Vec<String> {
    let mut lines = Vec::new();
    match (of.all, of.differing) {
        (true, differing) => lines.push(format!(
            "* {differing} of {} differ by more than {}, the whole interval",
            counted(of.compared, "rate"),
            text::threshold(of.threshold)
        )),
        (false, 0) => lines.push(format!(
            "None of {} differs by more than {}, the whole interval",
            counted(of.compared, "rate"),
            text::threshold(of.threshold)
        )),
        (false, _) => lines.push("--all lists every rate of every kernel".to_owned()),
    }
    if of.left_out > 0 {
        let rows = counted(of.left_out, "row");
        lines.push(format!(
            "left out: up to {rows} of a record that others lack"
        ));
    }
    lines
}

fn heads(names: &[&str]) -> Vec<String> {
    names.iter().map(ToString::to_string).collect()
}
