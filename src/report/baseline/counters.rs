//! Comparison of the work counters of two runs. They are the same on every machine, or the work is
//! not the same.

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
    let mut found = Vec::new();
    for key in keys {
        let mut tell = |difference| {
            found.push(CounterChange {
                scene: key.0.to_owned(),
                rays: key.1.to_owned(),
                kernel: key.2.to_owned(),
                difference,
            });
        };
        match (before.get(&key), now.get(&key)) {
            (Some(old), Some(new)) => counts(old)
                .into_iter()
                .zip(counts(new))
                .filter(|((_, old), (_, new))| old != new)
                .for_each(|((counter, old), (_, new))| {
                    tell(CountDifference::Count { counter, old, new })
                }),
            (Some(_), None) => tell(CountDifference::OnlyOld),
            _ => tell(CountDifference::OnlyNew),
        }
    }
    found
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
