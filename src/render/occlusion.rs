//! A wave of camera rays whose hits are as bright as the sky above them is open: trace, find the surfaces, send one ray from each.

use super::kept::Kept;
use super::wave::{Colors, Engine, RayView, surfaces};
use crate::shade::skyward;
use bumpalo::Bump;
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{LANES, LaneMask, Mask8, Vec3x8};

/// Traces a wave and writes to `colors`, which are black, 1 for rays whose hit sends a ray that meets nothing within `reach`, and the
/// background for those that hit nothing. `kept` receives what is to be known of them beside that.
pub(super) fn occlusion(
    engine: &mut Engine,
    arena: &mut Bump,
    rays: RayView,
    reach: f32,
    colors: &mut [Colors],
    mut kept: Option<&mut Kept>,
) {
    arena.reset();
    let arena = &*arena;
    let hits = arena.alloc_slice_fill_copy(rays.packets.len(), HitPacket::miss());
    let packets = rays.packets.clone();
    engine.traversal.closest(rays.queue, packets, hits);
    if let Some(kept) = &mut kept {
        kept.hits.copy_from_slice(hits);
    }
    let (surfaces, tints) = surfaces(arena, engine.scene, &rays, hits, colors);
    let mut queue = RayQueue::with_capacity(arena, surfaces.len() * LANES);
    for at in surfaces {
        let (org, dir) = skyward(at, rays.seeds(&at.ray), engine.sample);
        queue.push(at.active, org, dir, Vec3x8::splat(1.0, 1.0, 1.0), &at.ray);
    }
    engine.stats.rays.shadow += queue.len() as u64;
    let all = 0..queue.packets();
    let blocked = arena.alloc_slice_fill_copy(all.len(), 0);
    engine.traversal.occluded(&queue, all, reach, blocked);
    for (packet, &blocked) in blocked.iter().enumerate() {
        let (white, hit) = queue.payload(packet);
        let open = queue.active(packet) & !Mask8::from_bits(u32::from(blocked));
        for lane in open.lanes() {
            let ray = hit[lane] as usize;
            colors[ray / LANES].add(ray % LANES, [0, 1, 2].map(|c| white[c][lane]));
        }
    }
    if let Some(kept) = kept {
        kept.take(engine.scene, surfaces, tints, colors);
    }
}
