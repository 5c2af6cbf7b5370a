//! Renders blocks of pixels, each with as many samples as it needs.

use super::Oracle;
use super::pixel::{OraclePixel, OraclePixelAccumulator};
use super::shadow_cache_cursor::{SampleVisibility, ShadowCacheCursor};
use glam::Vec3;
use phalanx_scene::camera::Camera;
use phalanx_scene::film::Tile;
use phalanx_scene::sampling::{Adaptive, BLOCK, Cells, SampleResult, Sampling};

impl Oracle<'_> {
    /// Renders the pixels of a block, with as many samples as they need, row by row. `block` is its
    /// part in the picture, of 8 columns and rows at most.
    pub fn block(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        block: Tile,
    ) -> Vec<OraclePixel> {
        let occlusion = self.integrator.settings.ao_distance.is_some();
        if self.scene().is_stochastic() || camera.has_lens() || occlusion {
            self.block_by_pixels(camera, sampling, adaptive, block)
        } else {
            self.block_by_cells(camera, sampling, adaptive, block)
        }
    }

    /// Renders a block in which only the positions of camera rays within their pixels are random,
    /// with as many samples as the cells of the pixels need.
    fn block_by_cells(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        block: Tile,
    ) -> Vec<OraclePixel> {
        let size = (block.width, block.height);
        let mut first = [[None; BLOCK as usize]; BLOCK as usize];
        let mut cells = Cells::default();
        cells.begin(*adaptive, sampling.spp, ((block.x, block.y), size), true);
        loop {
            for k in 0..cells.requests().len() {
                let request = &cells.requests()[k];
                let ((column, row), number) = (request.pixel, request.number);
                let mut visibility = SampleVisibility::of(&cells, k);
                let place = (block.x + column, block.y + row);
                let traced = self.sample(camera, sampling, place, number, visibility.cursor());
                let answer = SampleResult {
                    radiance: traced.light.sum().to_array(),
                    light: traced.light.all().map(Vec3::into),
                    weight: traced.weight,
                    visibility: visibility.visibility,
                };
                if number == 0 {
                    first[row as usize][column as usize] = Some((traced.ray, traced.hit));
                }
                cells.add_result(k, &answer);
                cells.add_surfaces(k, traced.surfaces);
            }
            if !cells.next_round() {
                break;
            }
        }
        let (sums, coverage) = (cells.sums(), cells.coverage());
        let places = (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
        let pixel = |(column, row): (u32, u32)| {
            let index = (row * BLOCK + column) as usize;
            let sum = &sums[index];
            OraclePixel {
                radiance: sum.radiance.mean().into(),
                light: sum.light.map(|way| way.mean().into()),
                first: first[row as usize][column as usize],
                samples: sum.samples,
                coverage: coverage[index].clone(),
            }
        };
        places.map(pixel).collect()
    }

    /// Renders a block in which more is random than the positions of camera rays within their
    /// pixels, with as many samples as each pixel needs.
    fn block_by_pixels(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        block: Tile,
    ) -> Vec<OraclePixel> {
        let size = (block.width, block.height);
        let mut sums: [[OraclePixelAccumulator; BLOCK as usize]; BLOCK as usize] =
            Default::default();
        let places = || (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
        let (mut open, mut samples) = (!0, 0);
        while open != 0 && samples < sampling.spp {
            let next = adaptive.next(samples, sampling.spp);
            for (column, row) in places() {
                if open >> (row * BLOCK + column) & 1 == 0 {
                    continue;
                }
                for sample in samples..next {
                    let place = (block.x + column, block.y + row);
                    let traced =
                        self.sample(camera, sampling, place, sample, ShadowCacheCursor::NONE);
                    sums[row as usize][column as usize].add(traced);
                }
            }
            samples = next;
            let gathered =
                (sums.each_ref()).map(|row| row.each_ref().map(OraclePixelAccumulator::radiance));
            open = adaptive.still_active(open, samples, &gathered, size);
        }
        places()
            .map(|(x, y)| sums[y as usize][x as usize].finish())
            .collect()
    }
}
