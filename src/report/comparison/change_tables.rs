//! The changes as tables for the terminal, worst first.

use super::changes::{Changes, GroupChange, Grouping, Normalisation, RowChange};
use super::counters::{CountDifference, CounterChange};
use super::log_rate::RateChange;
use super::regressions::Regression;
use crate::numbers::{self, counted, rate, signed_percent};
use crate::report_table::ReportTable;

/// Maximum number of rows of a table: those that matter come first.
const MAX_ROWS: usize = 12;

/// Width of these tables, which are never broken.
const ANY: usize = usize::MAX;

/// Columns of the changes by kind of rays.
pub(crate) const BY_RAYS_HEAD: &str = "rays | kernel | threads | scenes | change | 95 % interval";
const BY_SCENE_HEAD: &str = "scene | kernel | threads | rows | change | 95 % interval";
const ROW_HEAD: &str =
    "scene | kernel | rays | threads | old Mrays/s | new Mrays/s | change | 95 % interval";

/// The changes as tables: kernels by kind of rays, the scenes and the rows that changed most for
/// the worse, then the rates that were not compared.
pub fn changes_table(changes: &Changes, threshold: f64) -> String {
    let groups = worst_first(&changes.groups, |group| group.change.by);
    let (by_rays, by_scene): (Vec<&GroupChange>, Vec<&GroupChange>) = groups
        .into_iter()
        .partition(|g| matches!(g.over, Grouping::Scenes { .. }));
    let rows = worst_first(&changes.rows, |row| row.change.by);
    let title = "Change of each kernel by kind of rays, geometric mean over scenes:";
    let by_rays = by_rays.into_iter().map(group_cells);
    let by_rays = ReportTable::new(title, BY_RAYS_HEAD, 2).with(by_rays);
    let title = "The scenes that changed most for the worse, geometric mean over kinds of rays:";
    let by_scene = by_scene.into_iter().take(MAX_ROWS).map(group_cells);
    let by_scene = ReportTable::new(title, BY_SCENE_HEAD, 2).with(by_scene);
    let title = "The rows that changed most for the worse:";
    let rows = rows.into_iter().take(MAX_ROWS).map(row_cells);
    let rows = ReportTable::new(title, ROW_HEAD, 3).with(rows);
    let tables = [by_rays, by_scene, rows].map(|table| table.text(ANY));
    tables.concat() + &summary(changes, threshold)
}

/// The items, slowest change first.
pub(crate) fn worst_first<T>(items: &[T], by: fn(&T) -> f64) -> Vec<&T> {
    let mut sorted: Vec<&T> = items.iter().collect();
    sorted.sort_by(|a, b| by(a).total_cmp(&by(b)));
    sorted
}

fn group_cells(group: &GroupChange) -> Vec<String> {
    let (over, threads) = match &group.over {
        Grouping::Scenes { rays, threads } => (rays.clone(), threads.to_string()),
        Grouping::Rays { scene } => (scene.clone(), "any".to_owned()),
    };
    let mut cells = vec![over, group.kernel.clone(), threads, group.rows.to_string()];
    cells.extend(change_cells(&group.change, group.normalised));
    cells
}

fn row_cells(row: &RowChange) -> Vec<String> {
    let key = &row.key;
    let mut cells = vec![key.scene.clone(), key.kernel.clone(), key.rays.clone()];
    cells.extend([key.threads.to_string(), rate(row.old), rate(row.new)]);
    let normalised = row.normalised != Normalisation::No;
    cells.extend(change_cells(&row.change, normalised));
    cells
}

/// The regressions, worst first; a sentence where there are none.
pub fn regressions_table(regressions: &[Regression], threshold: f64) -> String {
    if regressions.is_empty() {
        let share = numbers::threshold(threshold);
        return format!("Nothing is slower by more than {share}.\n");
    }
    let sorted = worst_first(regressions, |regression| match regression {
        Regression::Group(group) => group.change.by,
        Regression::Row(row) => row.change.by,
    });
    let cells = sorted.into_iter().map(|regression| match regression {
        Regression::Row(row) => row_cells(row),
        Regression::Group(g) => {
            let (scene, rays, threads) = match &g.over {
                Grouping::Scenes { rays, threads } => ("all", &**rays, &*threads.to_string()),
                Grouping::Rays { scene } => (&**scene, "all", "any"),
            };
            let cells = [scene, &g.kernel, rays, threads, "", ""].map(str::to_owned);
            let change = change_cells(&g.change, g.normalised);
            cells.into_iter().chain(change).collect()
        }
    });
    ReportTable::new("", ROW_HEAD, 3).with(cells).text(ANY)
}

/// Counters that differ, in their given order.
pub fn counters_table(changes: &[CounterChange]) -> String {
    let line = |c: &CounterChange| {
        let difference = match c.difference {
            CountDifference::Count { counter, old, new } => {
                // One more of a million is a difference, too, so no percentages are shown.
                let more = i128::from(new) - i128::from(old);
                [
                    counter,
                    &old.to_string(),
                    &new.to_string(),
                    &format!("{more:+}"),
                ]
                .map(str::to_owned)
            }
            CountDifference::OnlyOld => ["all", "counted", "–", ""].map(str::to_owned),
            CountDifference::OnlyNew => ["all", "–", "counted", ""].map(str::to_owned),
        };
        let name = [&c.scene, &c.kernel, &c.rays].map(String::clone);
        name.into_iter().chain(difference).collect()
    };
    let head = "scene | kernel | rays | counter | old | new | more";
    let table = ReportTable::new("", head, 4).with(changes.iter().map(line));
    table.text(ANY)
}

/// The change, with a star where the machine's own fluctuations are in it, and its interval.
fn change_cells(change: &RateChange, normalised: bool) -> [String; 2] {
    let star = if normalised { "" } else { " *" };
    let [by, low, high] = [change.by, change.low, change.high].map(signed_percent);
    let interval = if change.is_known() {
        format!("{low} … {high}")
    } else {
        "too few samples".to_owned()
    };
    [by + star, interval]
}

fn summary(changes: &Changes, threshold: f64) -> String {
    let rows = || changes.rows.iter();
    let mut text = format!(
        "{} compared: {} slower and {} faster by more than {}, the whole interval.\n",
        counted(changes.rows.len(), "row"),
        rows()
            .filter(|row| row.change.slower_than(threshold))
            .count(),
        rows()
            .filter(|row| row.change.faster_than(threshold))
            .count(),
        numbers::threshold(threshold),
    );
    if rows().any(|row| row.normalised == Normalisation::No) {
        text += "* not in units of the oracle's rate, which one of the runs lacks\n";
    }
    for (rows, what) in [
        (&changes.only_old, "only in the baseline"),
        (&changes.only_new, "only in this run"),
        (&changes.empty, "without samples"),
    ] {
        if let Some(first) = rows.first() {
            let (scene, rays, kernel) = (&first.scene, &first.rays, &first.kernel);
            let count = counted(rows.len(), "row");
            let threads = counted(first.threads as usize, "thread");
            text += &format!("{count} {what}, first {scene}, {rays}, {kernel}, {threads}\n");
        }
    }
    for mismatch in &changes.forced {
        text += &format!("compared nevertheless: {mismatch}\n");
    }
    text
}
