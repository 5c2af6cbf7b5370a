//! The packet engine's tile renderer: it determines how many camera rays each pixel of a tile gets.

use super::adaptive_edges::EdgeSampler;
use super::adaptive_noise::NoiseSampler;
use super::frame::Settings;
use super::sample_tracer::SampleTracer;
use super::stats::RenderStats;
use super::tile_sums::TileSums;
use super::traced_samples::{PixelAccumulators, TracedSamples};
use super::wavefront::{ShadowFilter, push_camera_rays};
use super::workers::TileRenderer;
use phalanx_scene::camera::Camera;
use phalanx_scene::film::{Tile, TileBuffer};
use phalanx_scene::{MatteIds, Scene};
use phalanx_trace::bvh::Bvh;
use std::mem::replace;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Renders tiles with packets of eight rays.
pub struct WavefrontRenderer<'a> {
    tracer: SampleTracer<'a>,
    /// Accumulators of the pixels of a tile, if pixels have several samples.
    accumulators: PixelAccumulators,
    edges: EdgeSampler,
    noise: NoiseSampler,
    /// Sums that each tile goes on from, and leaves its own in.
    sums: Option<&'a TileSums>,
}

impl<'a> WavefrontRenderer<'a> {
    /// A renderer for one worker. The camera is that of the settings.
    pub fn new(scene: &'a Scene, bvh: &'a Bvh, camera: &'a Camera, settings: &Settings) -> Self {
        WavefrontRenderer {
            tracer: SampleTracer::new(scene, bvh, camera, settings),
            accumulators: PixelAccumulators::default(),
            edges: EdgeSampler::default(),
            noise: NoiseSampler::default(),
            sums: None,
        }
    }

    /// Sets the identifiers of surfaces, without which layers of coverage are 0.
    pub fn with_mattes(mut self, mattes: Option<&'a MatteIds>) -> Self {
        self.tracer.context.mattes = mattes.filter(|_| self.tracer.aovs.of_coverage());
        self
    }

    /// Goes on from the samples that tiles have in these sums, if any, and leaves the new sums
    /// there.
    pub(super) fn with_sums(mut self, sums: Option<&'a TileSums>) -> Self {
        self.sums = sums;
        self
    }

    /// Sets a flag that another thread sets to stop: tiles are incomplete from then on.
    pub fn with_stop(mut self, stop: &'a AtomicBool) -> Self {
        self.tracer.context.stop = stop;
        self
    }
}

impl TileRenderer for WavefrontRenderer<'_> {
    fn render_tile(&mut self, tile: Tile, pixels: &mut TileBuffer) {
        let tracer = &mut self.tracer;
        if let Some(adaptive) = tracer.sampling.adaptively() {
            return if tracer.seeded || tracer.camera.has_lens() {
                self.noise.render_tile(tracer, adaptive, tile, pixels)
            } else {
                self.edges.render_tile(tracer, adaptive, tile, pixels)
            };
        }
        let mut sum = self.sums.map(|sums| sums.of(tile));
        let spp = tracer.sampling.spp;
        let first = sum.as_mut().map_or(0, |sum| replace(&mut sum.samples, spp));
        if spp == 1 {
            let mut traced = trace_tile(tracer, tile, 0, pixels.record_hits());
            traced.write_pixels(pixels);
            return traced.write_hits(pixels, Some);
        }
        let sums = match &mut sum {
            Some(sum) => &mut sum.pixels,
            None => &mut self.accumulators,
        };
        // A single sample is a picture of its own.
        let first = if first < 2 { 0 } else { first };
        if first == 0 {
            sums.fit(tile.pixels() as usize, tracer.aovs);
        }
        let stop = tracer.context.stop;
        for sample in first..spp {
            let mut traced = trace_tile(tracer, tile, sample, pixels.record_hits());
            if stop.load(Relaxed) {
                // The tile may go on later, from the samples that are complete.
                return sum.iter_mut().for_each(|sum| sum.samples = sample);
            }
            sums.add(&traced, tile.width);
            traced.write_hits(pixels, Some);
        }
        for index in 0..tile.pixels() as u32 {
            let (x, y) = (index % tile.width, index / tile.width);
            sums.write_pixel(index as usize, pixels, (x, y));
        }
    }

    fn stats(&self) -> RenderStats {
        self.tracer.stats()
    }

    fn tracing(&self) -> Duration {
        self.tracer.tracing()
    }
}

/// Traces the `sample`-th camera ray of each pixel of a tile.
fn trace_tile<'t, 'a>(
    tracer: &'t mut SampleTracer<'a>,
    tile: Tile,
    sample: u32,
    record_hits: bool,
) -> TracedSamples<'t, 'a> {
    let (camera, sampling) = (tracer.camera, tracer.sampling);
    let capacity = tile.pixels() as usize;
    tracer.trace(capacity, sample, record_hits, ShadowFilter::NONE, |rays| {
        push_camera_rays(rays, camera, tile, &sampling, sample);
    })
}
