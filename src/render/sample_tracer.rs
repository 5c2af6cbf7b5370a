//! Traces camera rays, from their generation to their radiance, for the code that selects them.

use super::frame::Settings;
use super::stats::RenderStats;
use super::traced_samples::TracedSamples;
use super::wavefront::{
    AovBuffer, FragmentSink, Levels, QueueSlice, RadianceX8, RayFragment, ShadowFilter, Wave,
    WavefrontContext, trace_ambient_occlusion, trace_waves,
};
use super::workers::NEVER_SET;
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_scene::camera::Camera;
use phalanx_scene::film::{Aov, Aovs};
use phalanx_scene::sampling::Sampling;
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::{RayQueue, packets_for};
use phalanx_trace::simd::LANES;
use phalanx_trace::{PacketTracer, Traversal};
use std::time::Duration;

/// Traces camera rays and all rays that follow from them.
pub(super) struct SampleTracer<'a> {
    pub(super) camera: &'a Camera,
    pub(super) sampling: Sampling,
    pub(super) aovs: Aovs,
    /// Tracer that counts nodes, if an AOV needs their count.
    counter: Option<PacketTracer<'a>>,
    pub(super) context: WavefrontContext<'a>,
    /// True if rays have seeds.
    pub(super) seeded: bool,
    /// Memory that lives as long as a group of camera rays that are traced together. `scratch`
    /// lives as long as one wave of them.
    tile_arena: Bump,
    scratch: Bump,
    levels: Levels,
    /// Surfaces that the rays of a group see, if an AOV needs them.
    fragments: Vec<RayFragment>,
}

impl<'a> SampleTracer<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        bvh: &'a Bvh,
        camera: &'a Camera,
        settings: &Settings,
    ) -> Self {
        let integrator = settings.integrator_settings(scene);
        let levels = Levels::new(scene, &integrator);
        SampleTracer {
            camera,
            sampling: settings.sampling,
            aovs: settings.aovs,
            counter: settings.aovs.has(Aov::Cost).then(|| PacketTracer::new(bvh)),
            context: WavefrontContext {
                scene,
                traversal: Traversal::new(bvh, settings.kernel),
                stats: RenderStats::default(),
                tracing: Duration::ZERO,
                sample: 0,
                integrator,
                has_coverage: scene.has_coverage(),
                has_unseen_backs: scene.has_unseen_backs(),
                has_clear_shadows: scene.has_clear_shadows(),
                mattes: None,
                columns: levels.sizes.columns,
                stop: &NEVER_SET,
            },
            seeded: scene.is_stochastic() || integrator.ao_distance.is_some(),
            tile_arena: Bump::new(),
            scratch: Bump::new(),
            levels,
            fragments: Vec::new(),
        }
    }

    /// The work since the tracer was made.
    pub(super) fn stats(&self) -> RenderStats {
        RenderStats {
            packets: self.context.traversal.stats().packets,
            ..self.context.stats
        }
    }

    /// The time that tracing rays took since the tracer was made, without shading.
    pub(super) fn tracing(&self) -> Duration {
        self.context.tracing
    }

    /// Traces up to `capacity` camera rays, which `generate` adds to the queue. If rays have seeds,
    /// all are the `sample`-th of their pixels. The first rays of pixels also give hits, if these
    /// are recorded.
    pub(super) fn trace(
        &mut self,
        capacity: usize,
        sample: u32,
        record_hits: bool,
        shadow_filter: ShadowFilter,
        generate: impl FnOnce(&mut RayQueue),
    ) -> TracedSamples<'_, 'a> {
        // The filter knows lights as visible or hidden, which light through a surface is neither
        // of.
        let mut shadow_filter =
            if self.context.has_clear_shadows { ShadowFilter::NONE } else { shadow_filter };
        self.tile_arena.reset();
        let arena = &self.tile_arena;
        let mut rays = RayQueue::seeded(arena, capacity, self.seeded);
        generate(&mut rays);
        self.context.sample = sample;
        self.context.stats.rays.primary += rays.len() as u64;
        let packets = packets_for(rays.len());
        let radiance = arena.alloc_slice_fill_copy(packets, RadianceX8::BLACK);
        let first = sample == 0 && (record_hits || self.aovs.of_surface());
        let mut aovs = AovBuffer::new(arena, packets, self.aovs, first);
        self.fragments.clear();
        let most = self.levels.sizes.camera;
        for start in (0..packets).step_by(most) {
            if self.context.is_stopped() {
                break;
            }
            let part = start..packets.min(start + most);
            let collects = self.context.mattes.is_some();
            let sink = FragmentSink {
                all: &mut self.fragments,
                first: (start * LANES) as u32,
            };
            let wave = Wave {
                radiance: &mut radiance[part.clone()],
                aovs: aovs.part(part.clone()),
                fragments: collects.then_some(sink),
                shadow_filter: shadow_filter.reborrow(),
                rays: QueueSlice {
                    queue: &rays,
                    packets: part,
                    after: &[],
                },
                bounced: false,
            };
            let (context, scratch) = (&mut self.context, &mut self.scratch);
            match context.integrator.ao_distance {
                Some(distance) => trace_ambient_occlusion(context, scratch, wave, distance),
                None => trace_waves(context, scratch, &mut self.levels, wave),
            }
        }
        let AovBuffer {
            hits,
            surfaces,
            light,
            ..
        } = aovs;
        // A packet's fragments are collected surface by surface.
        self.fragments.sort_by_key(|fragment| fragment.ray);
        TracedSamples {
            rays,
            radiance,
            hits,
            surfaces,
            light: light.map(|way| &*way),
            fragments: &self.fragments,
            counter: &mut self.counter,
        }
    }
}
