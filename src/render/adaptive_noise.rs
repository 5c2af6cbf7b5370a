//! Tiles whose pixels get as many samples as they need, where chance decides more than the position
//! of a camera ray in its pixel. The packet engine works in rounds. Each round determines again
//! which pixels need more samples.

use super::adaptive_edges::within;
use super::tile_renderer::{WavefrontRenderer, push_block};
use phalanx_scene::camera::Camera;
use phalanx_scene::film::Tile;
use phalanx_scene::film::TileBuffer;
use phalanx_scene::sampling::{Adaptive, BLOCK, PixelAccumulator, Sampling};
use phalanx_trace::packet::RayQueue;
use std::ops::Range;

impl WavefrontRenderer<'_> {
    /// Renders a tile, and with it the rest of its blocks: pixels beyond a region's border also
    /// decide where more samples are needed.
    pub(super) fn render_adaptively(
        &mut self,
        adaptive: Adaptive,
        tile: Tile,
        pixels: &mut TileBuffer,
    ) {
        let whole = tile.outward(BLOCK, self.camera.size());
        self.accumulators
            .fit(whole.pixels() as usize, pixels.aovs());
        self.active_pixels.clear();
        self.active_pixels.resize(corners(whole).count(), !0);
        let (mut samples, most) = (0, self.sampling.spp);
        while self.active_pixels.iter().any(|open| *open != 0) {
            let next = adaptive.next(samples, most);
            self.round(whole, samples..next, tile, pixels);
            samples = next;
            if samples == most {
                break;
            }
            for (open, corner) in self.active_pixels.iter_mut().zip(corners(whole)) {
                if *open != 0 {
                    let (block, size) = block(&self.accumulators.radiance, whole, corner);
                    *open = adaptive.still_active(*open, samples, &block, size);
                }
            }
        }
        let (right, down) = (tile.x - whole.x, tile.y - whole.y);
        for y in 0..tile.height {
            for x in 0..tile.width {
                let at = (y + down) * whole.width + x + right;
                self.accumulators.write_pixel(at as usize, pixels, (x, y));
            }
        }
    }

    /// Adds these samples to all active pixels. Several samples of a pixel are traced together, as
    /// many rays as one sample of all pixels would be, so that packets are full where few pixels
    /// are active. Where rays have seeds, one sample is traced at a time, because that is what
    /// seeds are for.
    fn round(&mut self, whole: Tile, samples: Range<u32>, tile: Tile, pixels: &mut TileBuffer) {
        let open = std::mem::take(&mut self.active_pixels);
        let count: u64 = open.iter().map(|open| u64::from(open.count_ones())).sum();
        let together = match self.seeded {
            true => 1,
            false => (whole.pixels() / count.max(1)).max(1) as u32,
        };
        let mut first = samples.start;
        while first < samples.end {
            let part = first..samples.end.min(first + together);
            let room = count as usize * part.len();
            let push = |rays: &mut RayQueue, camera: &Camera, sampling: &Sampling| {
                for sample in part.clone() {
                    for (&open, corner) in open.iter().zip(corners(whole)) {
                        if open != 0 {
                            push_block(rays, camera, whole, corner, open, sampling, sample);
                        }
                    }
                }
            };
            let keep_hits = pixels.record_hits();
            self.trace(
                room,
                first,
                keep_hits,
                None,
                push,
                |sums, traced, counter| {
                    sums.add(traced, whole.width);
                    traced.keep(pixels, counter, within(whole, tile));
                },
            );
            first = part.end;
        }
        self.active_pixels = open;
    }
}

/// Upper left corners of a tile's blocks, relative to the tile.
pub(super) fn corners(tile: Tile) -> impl Iterator<Item = (u32, u32)> {
    let across = (0..tile.width).step_by(BLOCK as usize);
    let down = (0..tile.height).step_by(BLOCK as usize);
    down.flat_map(move |y| across.clone().map(move |x| (x, y)))
}

/// Columns and rows that the block with this corner has within a tile.
pub(super) fn size_of(tile: Tile, (x, y): (u32, u32)) -> (u32, u32) {
    (BLOCK.min(tile.width - x), BLOCK.min(tile.height - y))
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
        let at = ((y + row as u32) * tile.width + x) as usize;
        pixels[..size.0 as usize].copy_from_slice(&gathered[at..at + size.0 as usize]);
    }
    (block, size)
}
