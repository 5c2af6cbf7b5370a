//! A wave of camera rays whose hits are as bright as the sky above them is open. Traces the rays,
//! finds the surfaces, and sends one ray from each.

use super::aov_buffer::AovBuffer;
use super::wavefront::{QueueSlice, RadianceX8, WavefrontContext, add_unoccluded, group_hits};
use crate::shade::sample_ao_ray;
use bumpalo::Bump;
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{LANES, Vec3x8};

/// Traces a wave and writes to `radiance`, which is black before: 1 for rays whose hit sends a ray
/// that meets nothing within `ao_distance`, and the background for rays that hit nothing. `aovs`
/// receives the other outputs of the rays.
pub(super) fn ambient_occlusion(
    engine: &mut WavefrontContext,
    arena: &mut Bump,
    rays: QueueSlice,
    ao_distance: f32,
    radiance: &mut [RadianceX8],
    mut aovs: Option<&mut AovBuffer>,
) {
    arena.reset();
    let arena = &*arena;
    let hits = arena.alloc_slice_fill_copy(rays.packets.len(), HitPacket::miss());
    let packets = rays.packets.clone();
    engine.traversal.closest(rays.queue, packets, hits);
    if let Some(aovs) = &mut aovs {
        aovs.hits.copy_from_slice(hits);
    }
    let (groups, tints) = group_hits(arena, engine.scene, &rays, hits, radiance);
    let mut queue = RayQueue::with_capacity(arena, groups.len() * LANES);
    for at in groups {
        let (org, dir) = sample_ao_ray(at, rays.seeds(&at.ray), engine.sample);
        queue.push(at.active, org, dir, Vec3x8::splat(1.0, 1.0, 1.0), &at.ray);
    }
    engine.stats.rays.shadow += queue.len() as u64;
    let all = 0..queue.packets();
    let blocked = arena.alloc_slice_fill_copy(all.len(), 0);
    engine.traversal.occluded(&queue, all, ao_distance, blocked);
    add_unoccluded(&queue, blocked, radiance, |_| {});
    if let Some(aovs) = aovs {
        aovs.record_surfaces(engine.scene, groups, tints, radiance);
    }
}
