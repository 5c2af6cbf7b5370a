//! Closest hits of a wave's rays, and the radiance of those that escape.

use super::ray_batch::{QueueSlice, RadianceX8};
use super::wavefront_context::WavefrontContext;
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_trace::packet::{HitPacket, NO_PRIM};
use phalanx_trace::simd::{LANES, LaneMask, LaneU32, U32x8};

/// Finds the closest hit of every ray.
pub(super) fn intersect_closest<'arena>(
    context: &mut WavefrontContext,
    arena: &'arena Bump,
    rays: &QueueSlice,
) -> &'arena [HitPacket] {
    let hits = arena.alloc_slice_fill_copy(rays.packets.len(), HitPacket::miss());
    let packets = rays.packets.clone();
    context.traversal.closest(rays.queue, packets, hits);
    hits
}

/// Gives rays that hit nothing the background.
pub(super) fn handle_escaped_rays(
    scene: &Scene,
    rays: &QueueSlice,
    hits: &[HitPacket],
    radiance: &mut [RadianceX8],
) {
    let background = scene.background.to_array();
    for (packet, (hit, radiance)) in hits.iter().zip(radiance).enumerate() {
        let escaped = rays.active(packet) & hit.prim_id.eq(U32x8::splat(NO_PRIM));
        if escaped.bits() == 0xff {
            *radiance = RadianceX8(background.map(|c| [c; LANES]));
            continue;
        }
        for lane in escaped.lanes() {
            radiance.set(lane, background);
        }
    }
}
