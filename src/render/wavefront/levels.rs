//! Bounces of bounces: the order in which waves are traced.
//!
//! The bounces of a wave wait in the queue of its level. They are traced slice by slice as waves of
//! the next level. Each slice is accumulated into the wave before the next is traced, mirror rays
//! before refracted ones. That gives the sum the order of the recursion: (local + Ks I_R) + Kt I_T.
//! The levels are a stack of their own, so that no depth overflows the thread's.

use super::aov_buffer::AovBuffer;
use super::bounce_queue::{BounceLevel, accumulate};
use super::ray_batch::{QueueSlice, RadianceX8};
use super::shadow_filter::ShadowFilter;
use super::trace_wavefront;
use super::wave_sizes::WaveSizes;
use super::wavefront_context::{Wave, WavefrontContext};
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_trace::packet::QueueColumns;

/// The levels of a renderer, each with the bounces of one wave.
pub(crate) struct Levels {
    sizes: WaveSizes,
    max_depth: usize,
    levels: Vec<BounceLevel>,
}

impl Levels {
    pub(crate) fn new(scene: &Scene, max_depth: u32, min_weight: f32) -> Levels {
        Levels {
            sizes: WaveSizes::of(scene, max_depth, min_weight),
            max_depth: max_depth as usize,
            levels: Vec::new(),
        }
    }

    /// Bounces after the primary ray.
    pub(crate) fn max_depth(&self) -> u32 {
        self.max_depth as u32
    }

    /// The columns of the queues of bounces.
    pub(crate) fn columns(&self) -> QueueColumns {
        self.sizes.columns
    }

    /// Most packets of a wave of camera rays.
    pub(crate) fn camera_packets(&self) -> usize {
        self.sizes.camera
    }

    /// The level of a wave of the given depth.
    fn level(&mut self, depth: usize) -> &mut BounceLevel {
        if self.levels.len() <= depth {
            self.levels.resize_with(depth + 1, BounceLevel::default);
        }
        &mut self.levels[depth]
    }

    /// The level of a wave of bounces, after the bounces of the wave above it.
    fn with_parent(&mut self, depth: usize) -> (&mut BounceLevel, &mut BounceLevel) {
        self.level(depth);
        let (above, from) = self.levels.split_at_mut(depth);
        (&mut above[depth - 1], &mut from[0])
    }
}

/// Traces a wave of camera rays and all their bounces, and adds up the radiance of the camera rays.
pub(crate) fn trace_waves(
    context: &mut WavefrontContext,
    scratch: &mut Bump,
    levels: &mut Levels,
    mut camera: Wave,
) {
    scratch.reset();
    let bounces = (levels.max_depth > 0).then_some(&mut levels.level(0).bounces);
    trace_wavefront(context, scratch, &mut camera, bounces);
    let mut depth = 0;
    loop {
        let most = levels.sizes.bounced;
        if levels.level(depth).bounces.advance(most) {
            depth += 1;
            scratch.reset();
            trace_bounces(context, scratch, levels, depth, &mut camera.shadow_filter);
        } else if depth > 0 {
            accumulate_bounces(levels, depth, &mut camera);
            depth -= 1;
        } else {
            return;
        }
    }
}

/// Traces the current slice of the bounces of the wave above as a wave of the given depth.
fn trace_bounces(
    context: &mut WavefrontContext,
    arena: &Bump,
    levels: &mut Levels,
    depth: usize,
    shadow_filter: &mut ShadowFilter,
) {
    let max_depth = levels.max_depth;
    let (above, level) = levels.with_parent(depth);
    let slice = above.bounces.slice();
    level.radiance.clear();
    level
        .radiance
        .resize(slice.packets.len(), RadianceX8::BLACK);
    let mut wave = Wave {
        shadow_filter: match depth {
            1 => shadow_filter.for_bounces(arena, &slice),
            _ => ShadowFilter::NONE,
        },
        rays: QueueSlice {
            queue: &slice.queue,
            packets: slice.packets,
        },
        radiance: &mut level.radiance,
        aovs: AovBuffer::default(),
    };
    let bounces = (depth < max_depth).then_some(&mut level.bounces);
    trace_wavefront(context, arena, &mut wave, bounces);
}

/// Adds the results of a wave of the given depth to the wave above.
fn accumulate_bounces(levels: &mut Levels, depth: usize, camera: &mut Wave) {
    let (above, level) = levels.with_parent(depth);
    let slice = above.bounces.slice();
    if depth > 1 {
        return accumulate(&slice, &level.radiance, &mut above.radiance);
    }
    camera.aovs.accumulate(&slice, &level.radiance);
    accumulate(&slice, &level.radiance, camera.radiance);
}
