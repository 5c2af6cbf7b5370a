//! The wavefront integrator: one whole wave of rays, stage by stage. [`trace_wavefront`] is the one
//! place that shows the order of the stages.
//!
//! | file | stage |
//! |---|---|
//! | `camera_rays` | a tile's camera rays, eight a packet |
//! | `closest_hits` | closest hits; the background or the sky for rays that escape |
//! | `coverage` | partly transparent surfaces: rays and light through them |
//! | `hit_grouping` | hits grouped by kind and material, eight surfaces at a time |
//! | `emission` | ambient light and emission |
//! | `terminator` | smooth surfaces above the hits, and the shadow rays beneath them |
//! | `shadow_rays` | lights, and the shadow rays that test them |
//! | `shadow_filter` | shadow rays saved by neighbouring samples |
//! | `secondary_rays` | mirror and refracted rays |
//! | `levels` | bounces as waves of their own, accumulated into the wave above |
//! | `ambient_occlusion` | the other integrator: the same wave with one ray to the sky per hit |
//!
//! The queues consist of `ray_batch` (slices of rays, radiance of eight) and `bounce_queue`. In
//! addition to radiance, a wave has the outputs of `aov_buffer`, and collects `fragments`.
//! `wave_sizes` bounds its memory.

mod ambient_occlusion;
mod aov_buffer;
mod bounce_queue;
mod camera_rays;
mod closest_hits;
mod coverage;
mod emission;
mod fragments;
mod hit_grouping;
mod levels;
mod ray_batch;
mod secondary_rays;
mod shadow_filter;
mod shadow_rays;
mod terminator;
mod wave_sizes;
mod wavefront_context;

pub(super) use ambient_occlusion::trace_ambient_occlusion;
pub(super) use aov_buffer::AovBuffer;
pub use camera_rays::push_camera_rays;
pub(super) use camera_rays::{block_of, pixel_of, push_block, push_samples};
pub(super) use fragments::{FragmentSink, RayFragment};
pub(super) use hit_grouping::group_hits;
pub(super) use levels::{Levels, trace_waves};
pub(super) use ray_batch::{QueueSlice, RadianceX8};
pub(super) use shadow_filter::{RefineRequest, ShadowFilter};
pub(super) use wave_sizes::CAMERA_RAYS;
pub use wave_sizes::WaveSizes;
pub(super) use wavefront_context::{Wave, WavefrontContext};

use bounce_queue::SecondaryQueues;
use bumpalo::Bump;
use closest_hits::{handle_escaped_rays, intersect_closest};
use coverage::{collect_fragments, group_seen_hits, pass_absent_surfaces, queue_passes};
use emission::add_ambient_and_emission;
use hit_grouping::HitGroups;
use secondary_rays::spawn_secondary_rays;
use shadow_rays::trace_shadow_rays;
use terminator::find_smooth_surfaces;

/// Traces a wave, writes the radiance of its rays without bounces, and queues their bounces and the
/// rays that continue through a surface, if any are allowed.
fn trace_wavefront(
    context: &mut WavefrontContext,
    arena: &Bump,
    wave: &mut Wave,
    queues: SecondaryQueues,
) {
    let Wave {
        rays,
        bounced,
        radiance,
        aovs,
        fragments,
        shadow_filter,
    } = wave;
    let hits = intersect_closest(context, arena, rays);
    let coverage = pass_absent_surfaces(context, arena, rays, hits);
    let surfaces = group_seen_hits(context, arena, rays, hits);
    let mut groups = HitGroups::new(arena, context.scene, surfaces, hits);
    if let Some(fragments) = fragments {
        collect_fragments(context, rays, hits, coverage, fragments);
    }
    handle_escaped_rays(context, rays, *bounced, hits, radiance);
    add_ambient_and_emission(&groups, coverage, radiance);
    groups.above = find_smooth_surfaces(context, arena, &groups);
    let visibility = shadow_filter.look_up(arena, groups.surfaces, hits);
    trace_shadow_rays(
        context, arena, rays, &groups, coverage, visibility, radiance,
    );
    aovs.record(context.scene, hits, &groups, radiance);
    if let Some(bounces) = queues.bounces {
        spawn_secondary_rays(context, arena, rays, &groups, coverage, bounces);
    }
    if let Some(passes) = queues.passes {
        queue_passes(context, rays, hits, coverage, passes);
    }
}
