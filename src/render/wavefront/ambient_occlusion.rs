//! Ambient occlusion for a wave of camera rays: traces the rays, finds the surfaces, and sends one
//! ray from each.

use super::closest_hits::{handle_escaped_rays, intersect_closest};
use super::coverage::{WaveCoverage, collect_fragments, group_seen_hits, pass_absent_surfaces};
use super::hit_grouping::HitGroups;
use super::shadow_rays::add_unoccluded;
use super::wavefront_context::{Wave, WavefrontContext};
use crate::shade::sample_ao_ray;
use bumpalo::Bump;
use phalanx_trace::packet::RayQueue;
use phalanx_trace::simd::{LANES, Vec3x8};

/// Traces a wave and writes its radiance, which must be black before: 1 for rays from whose hit the
/// secondary ray meets nothing within `ao_distance`, and the background for rays that hit nothing.
pub(crate) fn trace_ambient_occlusion(
    context: &mut WavefrontContext,
    arena: &mut Bump,
    wave: Wave,
    ao_distance: f32,
) {
    arena.reset();
    let arena = &*arena;
    let Wave {
        rays,
        bounced: _,
        radiance,
        mut aovs,
        mut fragments,
        shadow_filter: _,
    } = wave;
    let hits = intersect_closest(context, arena, &rays);
    pass_absent_surfaces(context, arena, &rays, hits);
    let surfaces = group_seen_hits(context, arena, &rays, hits);
    let groups = HitGroups::new(arena, context.scene, surfaces, hits);
    if let Some(fragments) = &mut fragments {
        collect_fragments(context, &rays, hits, WaveCoverage::WHOLE, fragments);
    }
    handle_escaped_rays(context, &rays, false, hits, radiance);
    let mut queue = RayQueue::with_capacity(arena, groups.surfaces.len() * LANES);
    for surface in groups.surfaces {
        let (org, dir) = sample_ao_ray(surface, rays.seeds(&surface.ray), context.sample);
        queue.push(
            surface.active,
            org,
            dir,
            Vec3x8::splat(1.0, 1.0, 1.0),
            &surface.ray,
        );
    }
    let blocked = arena.alloc_slice_fill_copy(queue.packets(), 0);
    add_unoccluded(
        context,
        &queue,
        None,
        ao_distance,
        blocked,
        radiance,
        |_, _| {},
    );
    aovs.record(context.scene, hits, &groups, radiance);
}
