//! Adaptive sampling by whole pixels, for pictures with random choices other than a camera ray's
//! position in its pixel. (Without such choices, sampling adapts within pixels: `cells`.)
//!
//! Every pixel begins with [`FIRST_SAMPLES`] samples. Each following round doubles the samples of
//! the pixels that are still active, up to the requested maximum. A pixel stays active while
//! another sample would help more than the threshold.
//!
//! The error of n stratified samples of an edge falls with n^(-3/4). So its square is v n^(-3/2),
//! with v the samples' variance, and one more sample reduces it by v n^(-5/2). Making that
//! reduction equal everywhere gives the least mean square for the rays. (Neyman's allocation, "On
//! the Two Different Aspects of the Representative Method", 1934, does so for samples that are not
//! stratified.)
//!
//! Variances of few samples are guesses. So a neighbour's larger variance counts for a pixel, too:
//! an edge that crosses the neighbour may have passed between the pixel's own samples.
//!
//! Neighbours are those in the same block of 8x8 pixels of the whole picture, so that no tile
//! depends on another one. All decisions are made in f64, in one order.

use super::pixel_accumulator::PixelAccumulator;

/// Side of the blocks within which pixels are compared.
pub const BLOCK: u32 = 8;

/// Samples that every pixel gets, unless the maximum is lower.
pub const FIRST_SAMPLES: u32 = 4;

/// Share of a neighbour's variance that counts as a pixel's own.
const NEIGHBOUR_WEIGHT: f64 = 0.25;

/// Criterion for when a pixel, or a part of it, is finished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Smallest worthwhile improvement by a sample, in radiance.
    ///
    /// With cells: a cell of area a, whose sample differs from a neighbouring one by d and which
    /// holds a share s of the way to it, is halved while a^1.1 d √(s/6) is above this.
    ///
    /// With other random choices: a pixel of n samples whose standard deviation is d gets more
    /// while d n^(-5/4) is above this.
    ///
    /// 0.001 gives about the quality of 64 uniform samples.
    pub threshold: f32,
}

/// A set of pixels of a block, one bit each, row by row from its upper left.
pub type PixelMask = u64;

impl Adaptive {
    /// The pixels that are to get as many samples again, out of a block's `open` pixels, which have
    /// `samples` each. `gathered` has the pixels of the block's rows, of which the first `width`
    /// and `height` are in the picture.
    pub fn still_active(
        &self,
        open: PixelMask,
        samples: u32,
        gathered: &[[PixelAccumulator; BLOCK as usize]; BLOCK as usize],
        (width, height): (u32, u32),
    ) -> PixelMask {
        let n = f64::from(samples);
        // n² √n, which needs no power function.
        let most = f64::from(self.threshold) * f64::from(self.threshold) * (n * n * n.sqrt());
        let (width, height) = (width as usize, height as usize);
        let mut own = [[0.0; BLOCK as usize]; BLOCK as usize];
        for (row, pixels) in own.iter_mut().zip(gathered).take(height) {
            for (variance, pixel) in row.iter_mut().zip(pixels).take(width) {
                *variance = pixel.variance();
            }
        }
        let mut stay = 0;
        for y in 0..height {
            for x in 0..width {
                let bit = 1 << (y * BLOCK as usize + x);
                let mut variance: f64 = own[y][x];
                for row in &own[y.saturating_sub(1)..(y + 2).min(height)] {
                    for &near in &row[x.saturating_sub(1)..(x + 2).min(width)] {
                        variance = variance.max(NEIGHBOUR_WEIGHT * near);
                    }
                }
                if open & bit != 0 && variance > most {
                    stay |= bit;
                }
            }
        }
        stay
    }

    /// Samples after which the next decision is made: twice as many, up to the most.
    #[inline]
    pub fn next(&self, samples: u32, most: u32) -> u32 {
        if samples == 0 { FIRST_SAMPLES.min(most) } else { (2 * samples).min(most) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type BlockAccumulators = [[PixelAccumulator; 8]; 8];

    fn block(value: impl Fn(usize, usize, u32) -> f32) -> BlockAccumulators {
        std::array::from_fn(|y| {
            std::array::from_fn(|x| {
                let mut pixel = PixelAccumulator::default();
                for sample in 0..8 {
                    pixel.add([value(x, y, sample); 3], 1.0);
                }
                pixel
            })
        })
    }

    const ADAPTIVE: Adaptive = Adaptive { threshold: 0.01 };

    #[test]
    fn what_is_plain_is_finished_at_once() {
        let plain = block(|_, _, _| 0.5);
        assert_eq!(ADAPTIVE.still_active(!0, 8, &plain, (8, 8)), 0);
    }

    #[test]
    fn an_edge_stays_open_with_its_neighbours_and_stops_where_it_helps_no_more() {
        // Column 3 contains an edge.
        let edge = block(|x, _, sample| match x {
            3 => (sample % 2) as f32,
            x => f32::from(u8::from(x > 3)),
        });
        let columns = |columns: &[usize]| {
            let bits = (0..8).flat_map(|y| columns.iter().map(move |x| 1u64 << (8 * y + x)));
            bits.fold(0, |all, bit| all | bit)
        };
        let all = columns(&[2, 3, 4]);
        assert_eq!(ADAPTIVE.still_active(!0, 8, &edge, (8, 8)), all);
        // Only pixels that were active and lie in the picture.
        assert_eq!(
            ADAPTIVE.still_active(columns(&[3]), 8, &edge, (8, 8)),
            columns(&[3])
        );
        assert_eq!(ADAPTIVE.still_active(!0, 8, &edge, (4, 2)), all & 0x0f0f);
        // A variance of 3/4 (three channels): n^(5/4) > 86.6, from n = 36 on. A quarter of it: from
        // 21 on.
        assert_eq!(ADAPTIVE.still_active(!0, 20, &edge, (8, 8)), all);
        assert_eq!(ADAPTIVE.still_active(!0, 21, &edge, (8, 8)), columns(&[3]));
        assert_eq!(ADAPTIVE.still_active(!0, 37, &edge, (8, 8)), 0);
    }

    #[test]
    fn samples_double_up_to_the_most() {
        let mut samples = 0;
        let mut all = Vec::new();
        while samples < 50 {
            samples = ADAPTIVE.next(samples, 50);
            all.push(samples);
        }
        assert_eq!(all, [4, 8, 16, 32, 50]);
        assert_eq!(ADAPTIVE.next(0, 3), 3);
    }
}
