//! Renders tiles in which each pixel gets as many samples as its cells need. The packet engine
//! works in rounds, each of which halves the cells left active by earlier rounds.

use super::blocks::{corners, size_of, within};
use super::coverage_layers::write_coverage;
use super::sample_tracer::SampleTracer;
use super::wavefront::{CAMERA_RAYS, RefineRequest, ShadowFilter, push_samples};
use phalanx_scene::camera::Camera;
use phalanx_scene::film::{Aov, RadianceAovs, Tile, TileBuffer};
use phalanx_scene::sampling::{
    Adaptive, BLOCK, Cells, LightVisibility, MAX_HITS, SampleResult, Sampling,
};
use phalanx_trace::packet::RayQueue;
use phalanx_trace::simd::LANES;

/// Maximum number of samples held at once, for a block or more, if every possible sample is taken.
/// Each takes about 110 bytes, including its results.
const MAX_GROUP_SAMPLES: u32 = 1 << 16;

/// Maximum number of rays that are traced together: the number of pixels in a tile of the default
/// side, for the same reason.
const MAX_WAVE_RAYS: usize = 1024;

/// The visibility of the lights is kept per ray of a single wave.
const _: () = assert!(MAX_WAVE_RAYS <= CAMERA_RAYS, "they would be several waves");

/// Halves cells, one group of blocks after another, until none requests a sample.
#[derive(Default)]
pub(super) struct EdgeSampler {
    /// Cells of a group, one entry per block.
    cells: Vec<Cells>,
    /// Samples that a round requests.
    requests: Vec<RefineRequest>,
    /// Visibility of the lights at their hits.
    visibility: Vec<[LightVisibility; MAX_HITS]>,
}

impl EdgeSampler {
    /// Renders a tile, and with it the rest of its blocks: pixels beyond a region's border also
    /// decide where more samples are needed.
    pub(super) fn render_tile(
        &mut self,
        tracer: &mut SampleTracer,
        adaptive: Adaptive,
        tile: Tile,
        pixels: &mut TileBuffer,
    ) {
        let outer = tile.outward(BLOCK, tracer.camera.size());
        let corners: Vec<_> = corners(outer).collect();
        let spp = tracer.sampling.spp;
        for group in corners.chunks((MAX_GROUP_SAMPLES / (BLOCK * BLOCK * spp)).max(1) as usize) {
            self.cells.resize_with(group.len(), Cells::default);
            for (cells, &(x, y)) in self.cells.iter_mut().zip(group) {
                let corner = (outer.x + x, outer.y + y);
                let size = size_of(outer, (x, y));
                cells.begin(adaptive, spp, (corner, size), pixels.aovs().of_light());
            }
            let mut first = true;
            loop {
                self.refine(tracer, outer, first, tile, pixels);
                if tracer.context.is_stopped() {
                    return;
                }
                first = false;
                let ask = |more, cells: &mut Cells| cells.next_round() | more;
                if !self.cells.iter_mut().fold(false, ask) {
                    break;
                }
            }
            for cells in &mut self.cells {
                finish(cells, tile, pixels);
            }
        }
    }

    /// Traces all samples that the blocks of a group request. The first samples of pixels also give
    /// hits, if those are recorded.
    fn refine(
        &mut self,
        tracer: &mut SampleTracer,
        outer: Tile,
        first: bool,
        tile: Tile,
        pixels: &mut TileBuffer,
    ) {
        let (camera, sampling) = (tracer.camera, tracer.sampling);
        self.requests.clear();
        for (block, cells) in (0..).zip(&self.cells) {
            let requests = 0..cells.requests().len() as u32;
            self.requests
                .extend(requests.map(|request| (block, request)));
        }
        for requests in self.requests.chunks(MAX_WAVE_RAYS) {
            self.visibility.clear();
            self.visibility.resize(requests.len(), Default::default());
            let cells = &self.cells;
            let shadow_filter = ShadowFilter::reuse(cells, requests, &mut self.visibility);
            let sample = if first { 0 } else { 1 };
            let (count, record_hits) = (requests.len(), pixels.record_hits());
            let mut traced = tracer.trace(count, sample, record_hits, shadow_filter, |rays| {
                push_requests(rays, camera, &sampling, outer, cells, requests);
            });
            traced.write_hits(pixels, within(outer, tile));
            let results = traced.outcomes().zip(&self.visibility);
            let results = results.zip(traced.seen());
            for (&(block, request), ((outcome, visibility), seen)) in requests.iter().zip(results) {
                let (radiance, light, weight) = outcome;
                let result = SampleResult {
                    radiance,
                    light,
                    weight,
                    visibility: *visibility,
                };
                let cells = &mut self.cells[block as usize];
                cells.add_result(request as usize, &result);
                cells.add_surfaces(request as usize, seen);
            }
        }
    }
}

/// Appends the camera rays that blocks of a tile request.
fn push_requests(
    rays: &mut RayQueue,
    camera: &Camera,
    sampling: &Sampling,
    outer: Tile,
    cells: &[Cells],
    requests: &[RefineRequest],
) {
    for eight in requests.chunks(LANES) {
        // Lanes past the end repeat the last request.
        let samples: [_; LANES] = std::array::from_fn(|k| {
            let (block, request) = eight[k.min(eight.len() - 1)];
            let cells = &cells[block as usize];
            let request = &cells.requests()[request as usize];
            let (x, y) = cells.corner();
            (x + request.pixel.0, y + request.pixel.1, request.number)
        });
        let columns = samples.map(|(x, _, _)| x);
        let rows = samples.map(|(_, y, _)| y);
        let numbers = samples.map(|(_, _, number)| number);
        let places = samples.map(|(x, y, _)| (y - outer.y) << 16 | (x - outer.x));
        push_samples(
            rays,
            camera,
            sampling.film_samples_of(columns, rows, numbers),
            eight.len(),
            &places,
        );
    }
}

/// Writes the sums that a block has accumulated to the pixels of a tile.
fn finish(cells: &mut Cells, tile: Tile, pixels: &mut TileBuffer) {
    let ((right, down), aovs) = (cells.corner(), pixels.aovs());
    let coverage = if aovs.of_coverage() { cells.coverage() } else { Vec::new() };
    for (index, sum) in (0..).zip(&cells.sums()) {
        let Some((x, y)) = tile.position_of(right + index % BLOCK, down + index / BLOCK) else {
            continue;
        };
        pixels.set(x, y, sum.radiance.mean());
        if aovs.of_light() {
            pixels.set_light(x, y, &RadianceAovs(sum.light.map(|way| way.mean())));
        }
        if let Some(coverage) = coverage.get(index as usize) {
            write_coverage(pixels, (x, y), coverage);
        }
        if aovs.has(Aov::Samples) {
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(sum.samples)]);
        }
    }
}
