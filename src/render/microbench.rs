//! One stage of a wave in isolation, only for benchmarks. The stages after it need no memory of
//! their own: they are calls of `shade`, and pushes into queues.

use super::wavefront::{QueueSlice, group_hits};
use crate::shade::Surface;
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_trace::packet::{HitPacket, RayQueue};
use std::ops::Range;

/// Surfaces of hits, grouped by kind and material into batches of eight, as in a wave of some
/// packets of a queue. `hits` belong to those packets.
pub fn group_queue_hits<'arena>(
    arena: &'arena Bump,
    scene: &Scene,
    rays: &RayQueue,
    packets: Range<usize>,
    hits: &[HitPacket],
) -> &'arena [Surface] {
    let view = QueueSlice {
        queue: rays,
        packets,
        after: &[],
    };
    group_hits(arena, scene, &view, hits)
}
