//! The changes as tables for the terminal, worst first.

use super::{
    Changes, CountDifference, CounterChange, GroupChange, Grouping, Normalisation, RateChange,
    Regression, RowChange,
};
use crate::text::{self, aligned, counted, percent, rate};

/// Most rows of a table: those that matter come first.
const MAX_ROWS: usize = 12;

/// Columns of the changes by kind of rays.
pub(crate) const BY_RAYS_HEAD: [&str; 6] = [
    "rays",
    "kernel",
    "threads",
    "scenes",
    "change",
    "95 % interval",
];
const BY_SCENE_HEAD: [&str; 6] = [
    "scene",
    "kernel",
    "threads",
    "rows",
    "change",
    "95 % interval",
];
const ROW_HEAD: [&str; 8] = [
    "scene",
    "kernel",
    "rays",
    "threads",
    "old Mrays/s",
    "new Mrays/s",
    "change",
    "95 % interval",
];

/// The changes as tables: kernels by kind of rays, the scenes and the rows that changed most for
/// the worse, then the rates that were not compared.
pub fn changes_table(changes: &Changes, threshold: f64) -> String {
    let mut groups: Vec<&GroupChange> = changes.groups.iter().collect();
    groups.sort_by(|a, b| a.change.by.total_cmp(&b.change.by));
    let (by_rays, by_scene): (Vec<&GroupChange>, Vec<&GroupChange>) = groups
        .into_iter()
        .partition(|g| matches!(g.over, Grouping::Scenes { .. }));
    let mut rows: Vec<&RowChange> = changes.rows.iter().collect();
    rows.sort_by(|a, b| a.change.by.total_cmp(&b.change.by));
    let of_groups = |head: [&str; 6], groups: Vec<&GroupChange>, shown: usize| {
        let cells: Vec<_> = groups.into_iter().take(shown).map(group_cells).collect();
        aligned(&head, &cells, 2)
    };
    let of_rows: Vec<_> = rows.into_iter().take(MAX_ROWS).map(cells).collect();
    [
        "Change of each kernel by kind of rays, geometric mean over scenes:\n",
        &of_groups(BY_RAYS_HEAD, by_rays, usize::MAX),
        "The scenes that changed most for the worse, geometric mean over kinds of rays:\n",
        &of_groups(BY_SCENE_HEAD, by_scene, MAX_ROWS),
        "The rows that changed most for the worse:\n",
        &aligned(&ROW_HEAD, &of_rows, 3),
        &summary(changes, threshold),
    ]
    .concat()
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

/// The regressions, worst first; a sentence where there are none.
pub fn regressions_table(regressions: &[Regression], threshold: f64) -> String {
    if regressions.is_empty() {
        let share = text::threshold(threshold);
        return format!("Nothing is slower by more than {share}.\n");
    }
    let by = |r: &Regression| match r {
        Regression::Group(group) => group.change.by,
        Regression::Row(row) => row.change.by,
    };
    let mut sorted = regressions.iter().collect::<Vec<_>>();
    sorted.sort_by(|a, b| by(a).total_cmp(&by(b)));
    let line = |r: &&Regression| match r {
        Regression::Row(row) => cells(row),
        Regression::Group(g) => {
            let (scene, rays, threads) = match &g.over {
                Grouping::Scenes { rays, threads } => ("all", rays.as_str(), threads.to_string()),
                Grouping::Rays { scene } => (scene.as_str(), "all", "any".to_owned()),
            };
            let mut cells = [scene, &g.kernel, rays, &threads, "", ""]
                .map(str::to_owned)
                .to_vec();
            cells.extend(change_cells(&g.change, g.normalised));
            cells
        }
    };
    aligned(&ROW_HEAD, &sorted.iter().map(line).collect::<Vec<_>>(), 3)
}

/// Counters that differ, in their given order.
pub fn counters_table(changes: &[CounterChange]) -> String {
    let head = ["scene", "kernel", "rays", "counter", "old", "new", "more"];
    let line = |c: &CounterChange| {
        let mut cells = vec![c.scene.clone(), c.kernel.clone(), c.rays.clone()];
        cells.extend(match c.difference {
            CountDifference::Count { counter, old, new } => {
                // One more of a million is a difference, too, so no percentages are shown.
                let more = i128::from(new) - i128::from(old);
                [
                    counter.to_owned(),
                    old.to_string(),
                    new.to_string(),
                    format!("{more:+}"),
                ]
            }
            CountDifference::OnlyOld => ["all", "counted", "–", ""].map(str::to_owned),
            CountDifference::OnlyNew => ["all", "–", "counted", ""].map(str::to_owned),
        });
        cells
    };
    aligned(&head, &changes.iter().map(line).collect::<Vec<_>>(), 4)
}

fn cells(row: &RowChange) -> Vec<String> {
    let key = &row.key;
    let mut cells = vec![key.scene.clone(), key.kernel.clone(), key.rays.clone()];
    cells.extend([key.threads.to_string(), rate(row.old), rate(row.new)]);
    cells.extend(change_cells(
        &row.change,
        row.normalised != Normalisation::No,
    ));
    cells
}

/// The change, with a star where the machine's own fluctuations are in it, and its interval.
fn change_cells(change: &RateChange, normalised: bool) -> [String; 2] {
    let star = if normalised { "" } else { " *" };
    let interval = match change.is_known() {
        true => format!("{} … {}", percent(change.low), percent(change.high)),
        false => "too few samples".to_owned(),
    };
    [percent(change.by) + star, interval]
}

fn summary(changes: &Changes, threshold: f64) -> String {
    let count =
        |is: &dyn Fn(&RateChange) -> bool| changes.rows.iter().filter(|r| is(&r.change)).count();
    let mut text = format!(
        "{} compared: {} slower and {} faster by more than {}, the whole interval.\n",
        counted(changes.rows.len(), "row"),
        count(&|c| c.slower_than(threshold)),
        count(&|c| c.faster_than(threshold)),
        text::threshold(threshold),
    );
    if changes
        .rows
        .iter()
        .any(|r| r.normalised == Normalisation::No)
    {
        text += "* not in units of the oracle's rate, which one of the runs lacks\n";
    }
    for (rows, what) in [
        (&changes.only_old, "only in the baseline"),
        (&changes.only_new, "only in this run"),
        (&changes.empty, "without samples"),
    ] {
        if let Some(first) = rows.first() {
            let (scene, rays, kernel, threads) =
                (&first.scene, &first.rays, &first.kernel, first.threads);
            let count = counted(rows.len(), "row");
            let threads = counted(threads as usize, "thread");
            text += &format!("{count} {what}, first {scene}, {rays}, {kernel}, {threads}\n");
        }
    }
    for mismatch in &changes.forced {
        text += &format!("compared nevertheless: {mismatch}\n");
    }
    text
}
