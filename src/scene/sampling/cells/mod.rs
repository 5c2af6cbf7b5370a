//! Adaptive sampling by cell subdivision: parts of pixels that differ from their neighbours get
//! more samples.
//!
//! A pixel's square is halved repeatedly, across and down in turn, and each cell holds one sample.
//! So the first 2^k points of a pixel fall, one each, into its cells of level k (`sobol`). A cell
//! of level k is halved by the one sample of numbers 2^k to 2^(k+1) that falls into its empty half.
//! A pixel has 2^k samples at most, the largest power of two within the requested number. A pixel
//! is the mean of its samples by the areas of their cells, in the unit square from which its filter
//! draws.
//!
//! Cells that meet at a side are compared, also across pixels. If their samples differ by d, the
//! length over three channels, an edge lies between them. It lies in one cell or in the other, with
//! the shares in which the border divides the way from sample to sample. A cell of area a that
//! holds the share s of that way has an error of about a d √(s/6), because one sample of a step
//! somewhere in it has (E\[p (1 - p)\] = 1/6).
//!
//! A cell is halved while a^1.1 d √(s/6) is above the threshold. Halving removes a constant part of
//! the error's square, so that equal errors in all cells are optimal for a given number of samples.
//! The exponent 1.1 gives small cells a little less weight, because larger cells may hide
//! something. On an edge the error of n samples then falls with n^(-3/2), where samples spread over
//! the whole pixel leave n^(-3/4) (Mitchell, "Consequences of Stratified Sampling in Graphics",
//! 1996).
//!
//! A shadow ray is skipped if [`MIN_AGREEING`] of the samples in the cell and around it hit the
//! same primitive along the same path and agree on the light's visibility. The reused result then
//! counts as a sample itself. It is reused only if the light's term times the cell's area is below
//! [`REUSE_LIMIT`] thresholds, so that a lower threshold reduces this error, too.
//!
//! Filters wider than a pixel's square draw from beyond it, so that neighbouring cells of two
//! pixels are not neighbours in the picture. They are compared nevertheless, which finds details
//! that a pixel's own samples miss (perf/notes/large-pictures.md).
//!
//! Neighbours are those in the same block of 8x8 pixels of the whole picture, so that no tile
//! depends on another one. All decisions are made in f64 and integers, in one order. Both engines
//! share them, as they share the points.

mod neighbours;
mod pixel;
#[cfg(test)]
mod tests;
mod visibility;

pub use visibility::{LightVisibility, MAX_HITS, MIN_AGREEING, path_id};

use super::adaptive::{Adaptive, BLOCK, FIRST_SAMPLES};
use super::pixel::MAX_SPP;
use super::pixel_accumulator::PixelAccumulator;
use super::pixel_coverage::{PixelCoverage, SurfaceShare};
use super::sobol::{Dimension, points_of, seeds};
use libm::exp2;
use pixel::{CellPixel, CellSample, PIXEL_SIDE, column_and_row, in_packets, index};
use std::ops::Range;
use visibility::agreed_lights;

/// Largest contribution whose visibility is reused, in thresholds. A larger limit saves no more
/// rays at the error of 64 uniform samples, and leaves more error where the threshold is lower.
const REUSE_LIMIT: f64 = 64.0;

/// Maximum number of halvings of a pixel: [`super::MAX_SPP`] samples.
const MAX_LEVELS: usize = 17;

/// Exponent of the area a: halving goes on while a^1.1 d is large.
const AREA_POWER: f64 = 1.1;

/// A requested sample.
#[derive(Clone, Debug)]
pub struct SampleRequest {
    /// Column and row of its pixel in the block.
    pub pixel: (u32, u32),
    /// Number of the sample among the pixel's.
    pub number: u32,
    /// Range of the neighbouring samples whose visibility may be reused.
    neighbours: Range<usize>,
}

/// Result of a sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct SampleResult {
    /// Radiance of the sample.
    pub radiance: [f32; 3],
    /// Radiance by the path along which it came; black if it is not requested.
    pub light: [[f32; 3]; 3],
    /// Filter weight of the sample.
    pub weight: f32,
    /// Visibility of the lights at the sample's hits.
    pub visibility: [LightVisibility; MAX_HITS],
}

/// Sums of a pixel's samples.
#[derive(Clone, Copy, Debug, Default)]
pub struct PixelSum {
    /// Sum of radiance.
    pub radiance: PixelAccumulator,
    /// Sums of radiance by the path along which it came.
    pub light: [PixelAccumulator; 3],
    /// Number of samples.
    pub samples: u32,
}

/// The cells of a block's pixels.
#[derive(Default)]
pub struct Cells {
    corner: (u32, u32),
    size: (u32, u32),
    /// Level at which cells are not halved any more.
    limit: u8,
    /// Bounds that the square of a difference must exceed, one per level.
    thresholds: [f64; MAX_LEVELS],
    /// Largest contribution of a light times its cell's area for which visibility may be reused.
    reuse_limit: f64,
    pixels: Vec<CellPixel>,
    samples: Vec<CellSample>,
    /// Visibility of the lights, one entry per sample.
    visibility: Vec<[LightVisibility; MAX_HITS]>,
    /// Radiance by path, one entry per sample, if it is requested.
    light: Option<Vec<[[f32; 3]; 3]>>,
    /// Surfaces with the numbers of the samples that see them, if they are requested.
    surfaces: Vec<(u32, SurfaceShare)>,
    requests: Vec<SampleRequest>,
    near: Vec<u32>,
    fresh: Vec<u32>,
}

impl Cells {
    /// Begins a block. Its upper left pixel is at column and row `corner` of the whole picture, and
    /// it has `size` columns and rows there. Requests the first sample of each pixel. If `by_way`
    /// is true, light is also stored by the path along which it came.
    pub fn begin(
        &mut self,
        adaptive: Adaptive,
        spp: u32,
        (corner, size): ((u32, u32), (u32, u32)),
        by_way: bool,
    ) {
        let threshold = f64::from(adaptive.threshold);
        self.corner = corner;
        self.size = size;
        self.limit = spp.clamp(1, MAX_SPP).ilog2() as u8;
        self.thresholds = std::array::from_fn(|level| {
            6.0 * threshold * threshold * exp2(2.0 * AREA_POWER * level as f64)
        });
        self.reuse_limit = REUSE_LIMIT * threshold;
        self.pixels.iter_mut().for_each(CellPixel::clear);
        self.pixels
            .resize_with((BLOCK * BLOCK) as usize, CellPixel::default);
        self.samples.clear();
        self.visibility.clear();
        self.light = by_way.then(|| self.light.take().unwrap_or_default());
        self.light.iter_mut().for_each(Vec::clear);
        self.surfaces.clear();
        self.fresh.clear();
        self.clear_requests();
        self.request_all(0..1);
    }

    /// Column and row of the block's upper left pixel in the whole picture.
    #[inline]
    pub fn corner(&self) -> (u32, u32) {
        self.corner
    }

    /// The requested samples.
    #[inline]
    pub fn requests(&self) -> &[SampleRequest] {
        &self.requests
    }

    /// Stores the result of a requested sample.
    #[inline]
    pub fn add_result(&mut self, ask: usize, result: &SampleResult) {
        let sample = self.samples.len() - self.requests.len() + ask;
        self.samples[sample].radiance = result.radiance;
        self.samples[sample].weight = result.weight;
        self.visibility[sample] = result.visibility;
        if let Some(light) = &mut self.light {
            light[sample] = result.light;
        }
    }

    /// Stores the surfaces that a requested sample sees.
    #[inline]
    pub fn add_surfaces(&mut self, ask: usize, surfaces: impl IntoIterator<Item = SurfaceShare>) {
        let sample = (self.samples.len() - self.requests.len() + ask) as u32;
        let surfaces = surfaces.into_iter().map(|surface| (sample, surface));
        self.surfaces.extend(surfaces);
    }

    /// The lights whose visibility is known at a hit of a requested sample, and those of them that
    /// are visible.
    pub fn known_lights(&self, ask: usize, hit: usize, path_id: u32) -> (u32, u32) {
        let near = &self.near[self.requests[ask].neighbours.clone()];
        agreed_lights(
            near.iter()
                .map(|&near| &self.visibility[near as usize][hit]),
            path_id,
        )
    }

    /// Returns true if a requested sample may reuse the results of others for a light that would
    /// contribute this radiance.
    #[inline]
    pub fn may_reuse(&self, ask: usize, radiance: [f32; 3]) -> bool {
        let sample = &self.samples[self.samples.len() - self.requests.len() + ask];
        let [r, g, b] = radiance.map(f64::from);
        let most = self.reuse_limit * f64::from(1u32 << sample.level);
        (r * r + g * g) + b * b < most * most
    }

    /// Requests more samples, once all requested ones have results. Returns true if there are any.
    pub fn next_round(&mut self) -> bool {
        let first = FIRST_SAMPLES.min(1 << self.limit);
        let begun = self.requests.first().is_some_and(|ask| ask.number == 0);
        self.clear_requests();
        if begun && first > 1 {
            self.request_all(1..first);
        } else {
            let open = self.compare();
            self.request_halves(open);
        }
        !self.requests.is_empty()
    }

    /// The sums of the pixels, row by row of whole rows of eight.
    pub fn sums(&self) -> [PixelSum; (BLOCK * BLOCK) as usize] {
        let mut sums = [PixelSum::default(); (BLOCK * BLOCK) as usize];
        for (k, sample) in self.samples.iter().enumerate() {
            let sum = &mut sums[usize::from(sample.pixel)];
            // Powers of two, so that equal areas give the mean of as many samples bit for bit.
            let area = 1.0 / f64::from(1u32 << sample.level);
            sum.radiance.add_share(sample.radiance, sample.weight, area);
            if let Some(light) = &self.light {
                for (pixels, part) in sum.light.iter_mut().zip(light[k]) {
                    pixels.add_share(part, sample.weight, area);
                }
            }
            sum.samples += 1;
        }
        sums
    }

    /// The surfaces that the pixels show, in the order of [`Cells::sums`].
    pub fn coverage(&mut self) -> Vec<PixelCoverage> {
        let mut pixels = vec![PixelCoverage::default(); (BLOCK * BLOCK) as usize];
        self.surfaces.sort_by_key(|(sample, _)| *sample);
        let mut rest = &self.surfaces[..];
        for (number, sample) in (0..).zip(&self.samples) {
            let own = rest
                .iter()
                .take_while(|(owner, _)| *owner == number)
                .count();
            let (own, later) = rest.split_at(own);
            rest = later;
            let area = 1.0 / f64::from(1u32 << sample.level);
            let surfaces = own.iter().map(|(_, surface)| *surface);
            pixels[usize::from(sample.pixel)].add(surfaces, sample.weight, area);
        }
        pixels
    }

    fn clear_requests(&mut self) {
        self.requests.clear();
        self.near.clear();
    }

    /// Requests the samples with these numbers of all pixels, packet by packet of 4x2 pixels.
    fn request_all(&mut self, numbers: Range<u32>) {
        for number in numbers {
            for pixel in (0..(BLOCK * BLOCK) as usize).map(in_packets) {
                let (x, y) = column_and_row(pixel);
                if x < self.size.0 && y < self.size.1 {
                    let [position] = self.positions(pixel, [number]);
                    self.request(pixel, number, position, 0..0);
                }
            }
        }
    }

    /// Positions of the samples with these numbers in their pixel.
    #[inline(always)]
    fn positions<const N: usize>(&self, pixel: usize, numbers: [u32; N]) -> [[u32; 2]; N] {
        let (x, y) = column_and_row(pixel);
        let [seed] = seeds([self.corner.0 + x], [self.corner.1 + y]);
        let [u, v] = points_of([seed; N], numbers, Dimension::Pixel);
        // The points are multiples of 2^-24, so that nothing is lost.
        let unit = |c: f32| (c * PIXEL_SIDE as f32) as u32;
        std::array::from_fn(|k| [unit(u[k]), unit(v[k])])
    }

    /// Requests a sample, and halves the cell into which it falls.
    fn request(&mut self, pixel: usize, number: u32, position: [u32; 2], near: Range<usize>) {
        let new = self.samples.len() as u32;
        let mut sample = CellSample {
            position,
            radiance: [0.0; 3],
            weight: 0.0,
            pixel: pixel as u8,
            level: 0,
            fresh: true,
            active: false,
        };
        let cells = &mut self.pixels[pixel];
        if number == 0 {
            cells.samples.push(new);
        } else {
            let old = cells.sample_at(position);
            let halved = &mut self.samples[old as usize];
            halved.level += 1;
            halved.active = false;
            if !std::mem::replace(&mut halved.fresh, true) {
                self.fresh.push(old);
            }
            sample.level = halved.level;
            cells.fill(&sample, new);
        }
        self.fresh.push(new);
        self.samples.push(sample);
        self.visibility.push(Default::default());
        if let Some(light) = &mut self.light {
            light.push(Default::default());
        }
        self.requests.push(SampleRequest {
            pixel: column_and_row(pixel),
            number,
            neighbours: near,
        });
    }

    /// Requests the samples that halve the cells of these samples.
    fn request_halves(&mut self, mut open: Vec<u32>) {
        let key = |&sample: &u32| {
            let CellSample { pixel, level, .. } = self.samples[sample as usize];
            (in_packets(pixel.into()), level, sample)
        };
        open.sort_unstable_by_key(key);
        let mut near = std::mem::take(&mut self.near);
        let mut all = Vec::with_capacity(open.len());
        for sample in open {
            let CellSample { pixel, level, .. } = self.samples[sample as usize];
            self.find_halving_samples(pixel.into(), level);
            let index = (1 << level) + self.samples[sample as usize].index();
            let from = near.len();
            self.neighbourhood(sample, &mut near);
            let number = self.pixels[usize::from(pixel)].halving[index];
            all.push((usize::from(pixel), number, from..near.len()));
        }
        for (pixel, number, near) in all {
            let [position] = self.positions(pixel, [number]);
            self.request(pixel, number, position, near);
        }
        self.near = near;
    }

    /// Finds the samples that halve the cells of a pixel, up to this level. The 2^k points that
    /// follow those of level k lie one in each of its cells.
    fn find_halving_samples(&mut self, pixel: usize, level: u8) {
        let mut halving = std::mem::take(&mut self.pixels[pixel].halving);
        while halving.len() < 2 << level {
            let from = halving.len().max(1) as u32;
            let level = from.ilog2() as u8;
            halving.resize(2 << level, 0);
            for first in (from..2 * from).step_by(8) {
                let numbers: [u32; 8] = std::array::from_fn(|k| first + k as u32);
                let places = self.positions(pixel, numbers);
                for (number, position) in numbers.into_iter().zip(places).take(from as usize) {
                    halving[from as usize + index(position, level)] = number;
                }
            }
        }
        self.pixels[pixel].halving = halving;
    }
}
