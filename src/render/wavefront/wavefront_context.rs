//! State shared by all waves of a worker, and the inputs and outputs of a single wave.

use super::aov_buffer::AovBuffer;
use super::fragments::FragmentSink;
use super::ray_batch::{QueueSlice, RadianceX8};
use super::shadow_filter::ShadowFilter;
use crate::stats::RenderStats;
use phalanx_scene::{IntegratorSettings, MatteIds, Scene};
use phalanx_trace::Traversal;
use phalanx_trace::packet::QueueColumns;
use phalanx_trace::simd::{F32x8, Lanes, Mask8, Vec3x8};
use phalanx_trace::stopwatch::Stopwatch;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Shared state of all waves.
pub(crate) struct WavefrontContext<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) traversal: Traversal<'a>,
    pub(crate) stats: RenderStats,
    /// Time that the rays of whole waves took to trace.
    pub(crate) tracing: Duration,
    /// Index of the camera ray of each pixel that the wave follows.
    pub(crate) sample: u32,
    pub(crate) integrator: IntegratorSettings,
    /// True if the scene has partly transparent surfaces.
    pub(crate) has_coverage: bool,
    /// True if some material is invisible from behind.
    pub(crate) has_unseen_backs: bool,
    /// True if light may pass through some surface: see [`Scene::has_clear_shadows`].
    pub(crate) has_clear_shadows: bool,
    /// Identifiers of the surfaces that camera rays see, if an AOV needs these surfaces.
    pub(crate) mattes: Option<&'a MatteIds>,
    /// The columns of the queues of bounces.
    pub(crate) columns: QueueColumns,
    /// Set if nobody wants the rays' radiance any more.
    pub(crate) stop: &'a AtomicBool,
}

impl<'a> WavefrontContext<'a> {
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.load(Relaxed)
    }

    /// Traces rays, and adds the time that it takes.
    pub(super) fn trace(&mut self, trace: impl FnOnce(&mut Traversal<'a>)) {
        let start = Stopwatch::start();
        trace(&mut self.traversal);
        self.tracing += start.elapsed();
    }
}

/// One wave: its rays, and the outputs that it fills.
pub(crate) struct Wave<'w, 'arena> {
    pub(crate) rays: QueueSlice<'w, 'arena>,
    /// True if the rays have been mirrored or refracted, so that they see the sky.
    pub(crate) bounced: bool,
    /// Radiance of the rays, packet by packet.
    pub(crate) radiance: &'w mut [RadianceX8],
    /// The rays' other outputs.
    pub(crate) aovs: AovBuffer<'w>,
    /// Collects the surfaces that camera rays see, if an AOV needs them.
    pub(crate) fragments: Option<FragmentSink<'w>>,
    pub(crate) shadow_filter: ShadowFilter<'w>,
}

/// Lanes whose share is at least `min_weight` in some component. NaN counts as less.
pub(super) fn is_worth_tracing(min_weight: f32, share: Vec3x8) -> Mask8 {
    let least = F32x8::splat(min_weight);
    share.x.abs().ge(least) | share.y.abs().ge(least) | share.z.abs().ge(least)
}
