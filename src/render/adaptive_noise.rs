//! Renders tiles in which each pixel gets as many samples as it needs, for scenes in which more is
//! random than the position of a camera ray in its pixel. The packet engine works in rounds, each
//! of which determines anew which pixels need more samples.

use super::blocks::{corners, size_of, within};
use super::sample_tracer::SampleTracer;
use super::traced_samples::PixelAccumulators;
use super::wavefront::{ShadowFilter, push_block};
use phalanx_scene::film::{Tile, TileBuffer};
use phalanx_scene::sampling::{Adaptive, BLOCK, BlockPixels, PixelAccumulator};
use std::ops::Range;

/// Gives pixels more samples, round by round, until none needs any.
#[derive(Default)]
pub(super) struct NoiseSampler {
    accumulators: PixelAccumulators,
    /// Pixels that get more samples, one entry per block.
    active: Vec<BlockPixels>,
}

impl NoiseSampler {
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
        (self.accumulators).fit(outer.pixels() as usize, pixels.aovs());
        self.active.clear();
        self.active.resize(corners(outer).count(), !0);
        let (mut samples, most) = (0, tracer.sampling.spp);
        while self.active.iter().any(|active| *active != 0) {
            let next = adaptive.next(samples, most);
            self.round(tracer, outer, samples..next, tile, pixels);
            if tracer.context.is_stopped() {
                return;
            }
            samples = next;
            if samples == most {
                break;
            }
            for (active, corner) in self.active.iter_mut().zip(corners(outer)) {
                if *active != 0 {
                    let (block, size) = block(&self.accumulators.radiance, outer, corner);
                    *active = adaptive.still_active(*active, samples, &block, size);
                }
            }
        }
        let (right, down) = (tile.x - outer.x, tile.y - outer.y);
        for y in 0..tile.height {
            for x in 0..tile.width {
                let index = (y + down) * outer.width + x + right;
                (self.accumulators).write_pixel(index as usize, pixels, (x, y));
            }
        }
    }

    /// Adds these samples to all active pixels. Several samples of a pixel are traced together, as
    /// many rays as for one sample of all pixels, so that packets are full even if few pixels are
    /// active. If rays have seeds, samples are traced one at a time, because seeds belong to one
    /// sample.
    fn round(
        &mut self,
        tracer: &mut SampleTracer,
        outer: Tile,
        samples: Range<u32>,
        tile: Tile,
        pixels: &mut TileBuffer,
    ) {
        let (camera, sampling) = (tracer.camera, tracer.sampling);
        let active = &self.active;
        let count: u64 = active.iter().map(|all| u64::from(all.count_ones())).sum();
        let together =
            if tracer.seeded { 1 } else { (outer.pixels() / count.max(1)).max(1) as u32 };
        for first in samples.clone().step_by(together as usize) {
            let part = first..samples.end.min(first + together);
            let capacity = count as usize * part.len();
            let record_hits = pixels.record_hits();
            let all = ShadowFilter::NONE;
            let mut traced = tracer.trace(capacity, first, record_hits, all, |rays| {
                for sample in part {
                    for (&active, corner) in active.iter().zip(corners(outer)) {
                        if active != 0 {
                            push_block(rays, camera, outer, corner, active, &sampling, sample);
                        }
                    }
                }
            });
            self.accumulators.add(&traced, outer.width);
            traced.write_hits(pixels, within(outer, tile));
        }
    }
}

/// The accumulators of a block's pixels, and the columns and rows of the block that lie in the
/// picture.
fn block(
    gathered: &[PixelAccumulator],
    tile: Tile,
    corner: (u32, u32),
) -> (
    [[PixelAccumulator; BLOCK as usize]; BLOCK as usize],
    (u32, u32),
) {
    let ((x, y), size) = (corner, size_of(tile, corner));
    let mut block = [[PixelAccumulator::default(); BLOCK as usize]; BLOCK as usize];
    for (row, pixels) in block.iter_mut().enumerate().take(size.1 as usize) {
        let index = ((y + row as u32) * tile.width + x) as usize;
        pixels[..size.0 as usize].copy_from_slice(&gathered[index..index + size.0 as usize]);
    }
    (block, size)
}
