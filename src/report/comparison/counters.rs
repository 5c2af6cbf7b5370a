//! Comparison of the work counters of two runs. They are the same on every machine, or the work is
//! not the same.

use crate::report_table::ReportTable;
use crate::{BenchRecord, CountedWork, CounterRow};
use std::collections::{BTreeMap, BTreeSet};

/// A counter that has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CounterChange {
    /// Name of the scene.
    pub scene: String,
    /// Kind of rays.
    pub rays: String,
    /// Kernel.
    pub kernel: String,
    /// Kind of difference.
    pub difference: CountDifference,
}

/// A difference between counters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CountDifference {
    /// One counter is larger or smaller.
    Count {
        /// Name of the counter in the record.
        counter: &'static str,
        /// The baseline's count.
        old: u64,
        /// This run's count.
        new: u64,
    },
    /// Only the baseline counted this.
    OnlyOld,
    /// Only this run counted this.
    OnlyNew,
}

type CounterKey<'a> = (&'a str, &'a str, &'a str);

/// Every counter that differs, in the order of scenes, rays and kernels.
pub fn counters(old: &BenchRecord, new: &BenchRecord) -> Vec<CounterChange> {
    let (before, now) = (index(old), index(new));
    let keys: BTreeSet<CounterKey> = before.keys().chain(now.keys()).copied().collect();
    let changes = |key: CounterKey| {
        let differences = match (before.get(&key), now.get(&key)) {
            (Some(old), Some(new)) => count_differences(old, new),
            (Some(_), None) => vec![CountDifference::OnlyOld],
            _ => vec![CountDifference::OnlyNew],
        };
        let change = move |difference| CounterChange {
            scene: key.0.to_owned(),
            rays: key.1.to_owned(),
            kernel: key.2.to_owned(),
            difference,
        };
        differences.into_iter().map(change).collect::<Vec<_>>()
    };
    keys.into_iter().flat_map(changes).collect()
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
    table.text(usize::MAX)
}

fn count_differences(old: &CounterRow, new: &CounterRow) -> Vec<CountDifference> {
    let counts = counts(old).into_iter().zip(counts(new));
    let differing = counts.filter(|((_, old), (_, new))| old != new);
    let difference =
        differing.map(|((counter, old), (_, new))| CountDifference::Count { counter, old, new });
    difference.collect()
}

fn index(record: &BenchRecord) -> BTreeMap<CounterKey<'_>, &CounterRow> {
    let rows = record.counters.iter();
    rows.map(|row| ((&*row.scene, &*row.rays, &*row.kernel), row))
        .collect()
}

/// The counters by name. The destructuring pattern ensures that none is forgotten.
fn counts(row: &CounterRow) -> [(&'static str, u64); 8] {
    let CountedWork {
        packets,
        active_lanes,
        node_visits,
        box_tests,
        leaf_visits,
        prim_tests,
        bytes,
    } = row.work;
    [
        ("ray_count", row.ray_count),
        ("packets", packets),
        ("active_lanes", active_lanes),
        ("node_visits", node_visits),
        ("box_tests", box_tests),
        ("leaf_visits", leaf_visits),
        ("prim_tests", prim_tests),
        ("bytes", bytes),
    ]
}
