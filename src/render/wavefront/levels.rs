//! Bounces of bounces: the order in which waves are traced.
//!
//! The bounces of a wave wait in the queue of its level. They are traced slice by slice as waves of
//! the next level. Each slice is accumulated into the wave before the next is traced, first mirror
//! rays, then refracted ones, then those that continue through partly transparent surfaces. So the
//! order of the sum is that of the recursion: ((α·local + α·Ks I_R) + α·Kt I_T) + (1 − α) I_P. The
//! levels are a stack of their own, so that no depth overflows the thread's.

use super::aov_buffer::AovBuffer;
use super::bounce_queue::{BounceLevel, SecondaryQueues, WaitingRays, accumulate};
use super::ray_batch::{QueueSlice, RadianceX8};
use super::shadow_filter::ShadowFilter;
use super::trace_wavefront;
use super::wave_sizes::WaveSizes;
use super::wavefront_context::{Wave, WavefrontContext};
use bumpalo::Bump;
use phalanx_scene::{IntegratorSettings, MAX_PASSES, Scene};

/// The levels of a renderer, each with the bounces of one wave.
pub(crate) struct Levels {
    pub(crate) sizes: WaveSizes,
    max_depth: u32,
    levels: Vec<BounceLevel>,
}

impl Levels {
    pub(crate) fn new(scene: &Scene, settings: &IntegratorSettings) -> Levels {
        Levels {
            sizes: WaveSizes::of(scene, settings.max_depth, settings.min_weight),
            max_depth: settings.max_depth,
            levels: Vec::new(),
        }
    }

    /// A level of the stack; camera rays are level 0.
    fn level(&mut self, index: usize) -> &mut BounceLevel {
        if self.levels.len() <= index {
            self.levels.resize_with(index + 1, BounceLevel::default);
        }
        &mut self.levels[index]
    }

    /// The level of a wave, preceded by the level of the wave that sent it.
    fn with_parent(&mut self, index: usize) -> (&mut BounceLevel, &mut BounceLevel) {
        self.level(index);
        let (earlier, later) = self.levels.split_at_mut(index);
        (&mut earlier[index - 1], &mut later[0])
    }
}

impl BounceLevel {
    /// The queues that the wave of this level may fill; others are emptied.
    fn queues(&mut self, max_depth: u32) -> SecondaryQueues<'_> {
        let WaitingRays {
            bounces, passes, ..
        } = &mut self.waiting;
        bounces.clear();
        passes.clear();
        SecondaryQueues {
            bounces: (self.depth < max_depth).then_some(bounces),
            passes: (self.passed < MAX_PASSES).then_some(passes),
        }
    }
}

/// Traces a wave of camera rays and all their bounces, and adds up the radiance of the camera rays.
/// A stop is seen before each wave, because the bounces of one tile may take hours.
pub(crate) fn trace_waves(
    context: &mut WavefrontContext,
    scratch: &mut Bump,
    levels: &mut Levels,
    mut camera: Wave,
) {
    scratch.reset();
    let max_depth = levels.max_depth;
    let queues = levels.level(0).queues(max_depth);
    trace_wavefront(context, scratch, &mut camera, queues);
    let mut top = 0;
    while !context.is_stopped() {
        let most = levels.sizes.bounced;
        if levels.level(top).waiting.advance(most) {
            top += 1;
            scratch.reset();
            trace_slice(context, scratch, levels, top, &mut camera.shadow_filter);
        } else if top > 0 {
            accumulate_slice(levels, top, &mut camera);
            top -= 1;
        } else {
            return;
        }
    }
}

/// Traces the current slice of the wave above as a wave of its own.
fn trace_slice(
    context: &mut WavefrontContext,
    arena: &Bump,
    levels: &mut Levels,
    top: usize,
    shadow_filter: &mut ShadowFilter,
) {
    let max_depth = levels.max_depth;
    let (parent, level) = levels.with_parent(top);
    let passing = parent.waiting.passing;
    level.depth = parent.depth + u32::from(!passing);
    level.passed = parent.passed + u32::from(passing);
    let slice = parent.waiting.slice();
    let mut radiance = std::mem::take(&mut level.radiance);
    radiance.clear();
    radiance.resize(slice.packets.len(), RadianceX8::BLACK);
    let mut wave = Wave {
        shadow_filter: match top {
            1 => shadow_filter.for_bounces(arena, &slice),
            _ => ShadowFilter::NONE,
        },
        rays: QueueSlice {
            queue: &slice.queue,
            packets: slice.packets,
            after: slice.after,
        },
        bounced: level.depth > 0,
        radiance: &mut radiance,
        aovs: AovBuffer::default(),
        fragments: None,
    };
    trace_wavefront(context, arena, &mut wave, level.queues(max_depth));
    level.radiance = radiance;
}

/// Adds the results of a level's wave to the wave above.
fn accumulate_slice(levels: &mut Levels, top: usize, camera: &mut Wave) {
    let (parent, level) = levels.with_parent(top);
    let slice = parent.waiting.slice();
    if top > 1 {
        return accumulate(&slice, &level.radiance, &mut parent.radiance);
    }
    camera.aovs.accumulate(&slice, &level.radiance);
    accumulate(&slice, &level.radiance, camera.radiance);
}
