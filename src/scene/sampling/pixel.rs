//! Positions of the camera rays of a pixel.

use super::adaptive::Adaptive;
use super::filter::Filter;
use super::sobol::{Dimension, points_of, seeds};

/// Sampling settings of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Camera rays per pixel, 1 to [`MAX_SPP`], or their maximum if sampling is adaptive. One goes
    /// through the pixel's centre; more are distributed over the filter.
    pub spp: u32,
    /// Reconstruction filter of the pixel.
    pub filter: Filter,
    /// Criterion for when a pixel has enough camera rays, for adaptive sampling.
    pub adaptive: Option<Adaptive>,
}

/// Maximum number of samples per pixel.
pub const MAX_SPP: u32 = 65_536;

/// Positions of the camera rays of N pixels, and their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSamples<const N: usize> {
    /// Continuous positions, downward.
    pub row: [f32; N],
    /// Continuous positions, to the right.
    pub column: [f32; N],
    /// Filter weights; 1 except for filters with negative lobes.
    pub weight: [f32; N],
}

impl Sampling {
    /// One ray through the centre of each pixel.
    pub const CENTER: Sampling = Sampling {
        spp: 1,
        filter: Filter::Box,
        adaptive: None,
    };

    /// Four rays per pixel: smooth edges.
    pub const SMOOTH: Sampling = Sampling {
        spp: 4,
        ..Sampling::CENTER
    };

    /// The criterion for when a pixel has enough camera rays, if it is set; none for a single ray.
    #[inline]
    pub fn adaptively(&self) -> Option<Adaptive> {
        self.adaptive.filter(|_| self.spp > 1)
    }

    /// Positions of the `sample`-th camera ray of some pixels, in columns `x` and rows `y`.
    #[inline(always)]
    pub fn film_samples<const N: usize>(
        &self,
        x: [u32; N],
        y: [u32; N],
        sample: u32,
    ) -> FilmSamples<N> {
        self.film_samples_of(x, y, [sample; N])
    }

    /// Positions of camera rays of some pixels, one for each pixel, with these numbers.
    #[inline(always)]
    pub fn film_samples_of<const N: usize>(
        &self,
        x: [u32; N],
        y: [u32; N],
        samples: [u32; N],
    ) -> FilmSamples<N> {
        let mut places = FilmSamples {
            row: y.map(|y| y as f32 + 0.5),
            column: x.map(|x| x as f32 + 0.5),
            weight: [1.0; N],
        };
        if self.spp > 1 {
            let [u, v] = points_of(seeds(x, y), samples, Dimension::Pixel);
            for lane in 0..N {
                let (right, wx) = self.filter.draw(u[lane]);
                let (down, wy) = self.filter.draw(v[lane]);
                places.row[lane] += down;
                places.column[lane] += right;
                places.weight[lane] = wx * wy;
            }
        }
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_goes_through_the_centre() {
        for (_, filter) in Filter::ALL {
            let one = Sampling {
                spp: 1,
                filter,
                adaptive: None,
            };
            let places = one.film_samples([3, 65_535], [0, 9], 0);
            assert_eq!(places.column, [3.5, 65_535.5]);
            assert_eq!(places.row, [0.5, 9.5]);
            assert_eq!(places.weight, [1.0; 2]);
        }
    }

    #[test]
    fn samples_surround_the_centre() {
        for (_, filter) in Filter::ALL {
            let many = Sampling {
                spp: 1024,
                filter,
                ..Sampling::CENTER
            };
            let (mut sum, mut weights) = ([0.0; 2], 0.0);
            for sample in 0..many.spp {
                let position = many.film_samples([7], [5], sample);
                let weight = f64::from(position.weight[0]);
                sum[0] += weight * f64::from(position.column[0] - 7.5);
                sum[1] += weight * f64::from(position.row[0] - 5.5);
                weights += weight;
            }
            // The samples are stratified a thousandfold along each axis. Where Mitchell's weights
            // jump from 1.1 to -1.1, twice along each axis, a part of 1/1024 may be on the wrong
            // side.
            let most = 9.0 / 1024.0;
            assert!(
                (weights / 1024.0 - 1.0).abs() < most,
                "{filter:?} {weights}"
            );
            assert!(
                sum.iter().all(|s| (s / weights).abs() < most),
                "{filter:?} {sum:?}"
            );
        }
    }
}
