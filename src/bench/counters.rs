//! Counted work: one pass of every kernel over every set, on one thread and without a clock.

use super::workload::Workload;
use phalanx_report::{CountedWork, CounterRow, QueryKind};
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::HitPacket;
use phalanx_trace::{CountingTraversal, Kernel, TraversalStats};

/// Counts the work of a kernel on a set of rays.
pub(super) fn count_work(
    scene: &str,
    bvh: &Bvh,
    kernel: Kernel,
    workload: &Workload,
) -> CounterRow {
    let mut traversal = CountingTraversal::new(bvh, kernel);
    let (queue, all) = (&workload.set.queue, 0..workload.packets());
    match workload.kind().query() {
        QueryKind::Closest => {
            let mut hits = vec![HitPacket::miss(); all.len()];
            traversal.closest(queue, all, &mut hits);
        }
        QueryKind::Occluded => {
            let mut blocked = vec![0; all.len()];
            traversal.occluded(queue, all, workload.set.tmax, &mut blocked);
        }
    }
    CounterRow {
        scene: scene.to_owned(),
        rays: workload.kind().name().to_owned(),
        kernel: kernel.name().to_owned(),
        ray_count: workload.rays() as u64,
        work: counted(traversal.stats()),
    }
}

/// The counts in the form of a record.
fn counted(stats: TraversalStats) -> CountedWork {
    let TraversalStats {
        packets,
        active_lanes,
        node_visits,
        box_tests,
        leaf_visits,
        prim_tests,
        bytes,
    } = stats;
    CountedWork {
        packets,
        active_lanes,
        node_visits,
        box_tests,
        leaf_visits,
        prim_tests,
        bytes,
    }
}
