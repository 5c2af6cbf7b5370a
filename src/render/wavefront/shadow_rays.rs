//! Lights, and the shadow rays that test them.

use super::coverage::{WaveCoverage, visibility};
use super::hit_grouping::HitGroups;
use super::ray_batch::{QueueSlice, RadianceX8, add_lanes};
use super::shadow_filter::KnownLights;
use super::terminator::TerminatorRays;
use super::wavefront_context::WavefrontContext;
use crate::shade::ShadeLight;
use bumpalo::Bump;
use glam::Vec3;
use phalanx_trace::packet::RayQueue;
use phalanx_trace::simd::{LANES, LaneMask, Mask8, Vec3x8};

/// Adds each unoccluded light's term, in the order of the lights in the file. Nothing occludes a
/// light that casts no shadows.
pub(super) fn trace_shadow_rays(
    context: &mut WavefrontContext,
    arena: &Bump,
    rays: &QueueSlice,
    groups: &HitGroups,
    coverage: WaveCoverage,
    mut known: KnownLights,
    radiance: &mut [RadianceX8],
) {
    let scene = context.scene;
    let above = |k: usize| groups.above.get(k).and_then(Option::as_ref);
    let mut queue = RayQueue::with_capacity(arena, groups.surfaces.len() * LANES);
    let mut smooth = TerminatorRays::new(arena, groups);
    let blocked = arena.alloc_slice_fill_copy(groups.surfaces.len(), 0);
    for light in 0..scene.lights.len() {
        if context.is_stopped() {
            return;
        }
        queue.clear();
        smooth.clear();
        let shade_light = ShadeLight::of(scene, light);
        let one = shade_light.sample_position([0; LANES], context.sample);
        let casts_shadows = scene.lights.casts_shadows(light);
        let is_directional = scene.lights.directional[light];
        for (k, surface) in groups.surfaces.iter().enumerate() {
            let position = if shade_light.is_area() {
                shade_light.sample_position(rays.seeds(&surface.ray), context.sample)
            } else {
                one
            };
            let mut sample = shade_light.sample(position, &groups.material(k), surface, above(k));
            if let Some(share) = coverage.of(surface) {
                sample.weigh(share);
            }
            if !casts_shadows {
                let Vec3x8 { x, y, z } = sample.radiance;
                let carried = [x, y, z].map(|c| c.to_array());
                add_lanes(radiance, sample.needed, &surface.ray, &carried);
                continue;
            }
            let unknown = known.unknown(light, (k, surface), &sample, radiance);
            let mut flat = unknown;
            if let Some(above) = above(k) {
                smooth.push(
                    unknown & above.smooth,
                    &sample,
                    surface,
                    above,
                    is_directional,
                );
                flat = unknown & !above.smooth;
            }
            queue.push(flat, sample.org, sample.dir, sample.radiance, &surface.ray);
        }
        let tmax = if is_directional { f32::INFINITY } else { 1.0 };
        let mut record = |open, rays: &_| known.record_visible(light, open, rays);
        add_unoccluded(context, &queue, None, tmax, blocked, radiance, &mut record);
        let (facet, smooth) = (&smooth.facet, Some(&smooth));
        add_unoccluded(context, facet, smooth, tmax, blocked, radiance, record);
    }
}

/// Traces shadow rays, adds the radiance of rays that are not blocked before `tmax` to the hits
/// that sent them, and passes those lanes and the hits of a packet to `record`. If everything that
/// blocks a ray lets light through, or is a facet that a `smooth` surface spares, that share of the
/// radiance is added. `blocked` has room for one byte per packet: lanes as bits.
pub(super) fn add_unoccluded(
    context: &mut WavefrontContext,
    queue: &RayQueue,
    smooth: Option<&TerminatorRays>,
    tmax: f32,
    blocked: &mut [u8],
    radiance: &mut [RadianceX8],
    mut record: impl FnMut(Mask8, &[u32; LANES]),
) {
    if queue.is_empty() {
        return;
    }
    context.stats.rays.shadow += queue.len() as u64;
    let all = 0..queue.packets();
    let blocked = &mut blocked[..all.len()];
    context.trace(|traversal| traversal.occluded(queue, all, tmax, blocked));
    for (packet, &blocked) in blocked.iter().enumerate() {
        let (carried, hit) = queue.payload(packet);
        let blocked = queue.active(packet) & Mask8::from_bits(u32::from(blocked));
        let open = queue.active(packet) & !blocked;
        add_lanes(radiance, open, hit, carried);
        record(open, hit);
        if !blocked.any() {
            continue;
        }
        let (lit, passed) = match smooth {
            Some(smooth) => smooth.past_own_facets(context, packet, tmax, blocked),
            None if !context.has_clear_shadows => continue,
            None => (
                blocked,
                visibility(context, queue, packet, tmax, blocked, |_, _| false),
            ),
        };
        for lane in lit.lanes().filter(|&lane| passed[lane] != Vec3::ZERO) {
            let (ray, passed) = (hit[lane] as usize, passed[lane]);
            let rgb = [0, 1, 2].map(|c| carried[c][lane] * passed[c]);
            radiance[ray / LANES].add(ray % LANES, rgb);
            record(Mask8::from_bits(1 << lane), hit);
        }
    }
}
