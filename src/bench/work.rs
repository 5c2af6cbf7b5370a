//! Work, counted: one pass of every kernel over every set, on one thread and without a clock.

use super::kind;
use super::subject::Question;
use crate::report::{CounterRow, WorkRecord};
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::HitPacket;
use phalanx_trace::{Kernel, Traversal};

/// What a kernel does for a set of rays.
pub(super) fn count(scene: &str, bvh: &Bvh, kernel: Kernel, question: &Question) -> CounterRow {
    let mut traversal = Traversal::counting(bvh, kernel);
    let (queue, all) = (&question.set.queue, 0..question.packets());
    match question.kind().question() {
        kind::Question::Closest => {
            let mut hits = vec![HitPacket::miss(); all.len()];
            traversal.closest(queue, all, &mut hits);
        }
        kind::Question::Occluded => {
            let mut blocked = vec![0; all.len()];
            traversal.occluded(queue, all, question.set.tmax, &mut blocked);
        }
    }
    let work = traversal.stats();
    CounterRow {
        scene: scene.to_owned(),
        rays: question.kind().name().to_owned(),
        kernel: kernel.name().to_owned(),
        ray_count: question.rays() as u64,
        work: WorkRecord {
            packets: work.packets,
            active_lanes: work.active_lanes,
            node_visits: work.node_visits,
            box_tests: work.box_tests,
            leaf_visits: work.leaf_visits,
            prim_tests: work.prim_tests,
            bytes: work.bytes,
        },
    }
}
