//! One stage of a wave alone, for benchmarks and for nothing else. The stages after it need no room of their own: they are
//! calls of `shade`, and pushes into queues.

use super::wave::{Colors, RayView, surfaces};
use crate::shade::Surface;
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_trace::packet::{HitPacket, RayQueue};
use std::ops::Range;

/// The surfaces of hits, grouped by kind and material into batches of eight, as a wave of some packets of a queue makes
/// them; `hits` are those packets'.
pub fn group<'arena>(
    arena: &'arena Bump,
    scene: &Scene,
    rays: &RayQueue,
    packets: Range<usize>,
    hits: &[HitPacket],
) -> &'arena [Surface] {
    let colors = arena.alloc_slice_fill_copy(packets.len(), Colors::BLACK);
    let view = RayView {
        queue: rays,
        packets,
    };
    surfaces(arena, scene, &view, hits, colors).0
}
