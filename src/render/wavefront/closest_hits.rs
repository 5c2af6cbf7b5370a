//! Closest hits of a wave's rays, and the radiance of those that escape.

use super::ray_batch::{QueueSlice, RadianceX8};
use super::wavefront_context::WavefrontContext;
use bumpalo::Bump;
use glam::Vec3;
use phalanx_trace::packet::{HitPacket, NO_PRIM};
use phalanx_trace::simd::{LANES, LaneMask, LaneU32, U32x8};

/// Finds the closest hit of every ray, or the next hit after its starting one.
pub(super) fn intersect_closest<'arena>(
    context: &mut WavefrontContext,
    arena: &'arena Bump,
    rays: &QueueSlice,
) -> &'arena mut [HitPacket] {
    let hits = arena.alloc_slice_fill_copy(rays.packets.len(), HitPacket::miss());
    let packets = rays.packets.clone();
    if rays.after.is_empty() {
        context.trace(|traversal| traversal.closest(rays.queue, packets, hits));
        return hits;
    }
    for (packet, hit) in hits.iter_mut().enumerate() {
        let (ray, active) = rays.packet(packet);
        let after = &rays.after[rays.packets.start + packet];
        *hit = context.traversal.next(&ray, active, after);
    }
    hits
}

/// Assigns the radiance of the surroundings to rays that hit nothing: of the environment, if these
/// rays see it, or else of the background, which may be black to those that have not `bounced`.
pub(super) fn handle_escaped_rays(
    context: &WavefrontContext,
    rays: &QueueSlice,
    bounced: bool,
    hits: &[HitPacket],
    radiance: &mut [RadianceX8],
) {
    let scene = context.scene;
    let integrator = &context.integrator;
    let background = if bounced || !integrator.hides_background {
        scene.background.to_array()
    } else {
        [0.0; 3]
    };
    let environment = scene.environment.as_ref();
    let environment = environment.filter(|environment| {
        bounced || (environment.is_background && integrator.shows_environment())
    });
    for (packet, (hit, radiance)) in hits.iter().zip(radiance).enumerate() {
        let escaped = rays.active(packet) & hit.prim_id.eq(U32x8::splat(NO_PRIM));
        if let Some(environment) = environment {
            let dir = rays.packet(packet).0.dir;
            for lane in escaped.lanes() {
                let dir = Vec3::new(dir.x.lane(lane), dir.y.lane(lane), dir.z.lane(lane));
                radiance.set(lane, environment.radiance(dir).to_array());
            }
            continue;
        }
        if escaped.bits() == 0xff {
            *radiance = RadianceX8(background.map(|c| [c; LANES]));
            continue;
        }
        for lane in escaped.lanes() {
            radiance.set(lane, background);
        }
    }
}
