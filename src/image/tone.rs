//! Linear radiance to 8-bit samples.
//!
//! clamp to \[0, 1\] (NaN counts as 0), transfer, quantise. No step calls a power function per sample or one whose
//! bits depend on the build: without a transfer the sample is `floor(255 c)` or `floor(255 c + 0.5)` in f32, each
//! operation rounded on its own; with sRGB it is the number of thresholds at or below `c`, and the 255 thresholds are
//! the inverse curve in f64 from the `libm` crate, whose results are the same everywhere.

use crate::render::Film;
use crate::scene::{Quantize, Tone, Transfer};

/// An 8-bit RGB picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green and blue of each pixel in turn, row by row from the top left.
    pub rgb: Vec<u8>,
}

/// The picture of a film under a tone.
pub fn encode(film: &Film, tone: Tone) -> Picture {
    let rgb = match tone.transfer {
        Transfer::None => interleave(film, |c| linear_sample(c, tone.quantize)),
        Transfer::Srgb => {
            let table = SrgbTable::new(&srgb_thresholds(tone.quantize));
            interleave(film, |c| table.sample(c))
        }
    };
    Picture {
        width: film.width,
        height: film.height,
        rgb,
    }
}

fn interleave(film: &Film, sample: impl Fn(f32) -> u8) -> Vec<u8> {
    let [red, green, blue] = &film.planes;
    let mut rgb = vec![0; 3 * red.len()];
    let pixels = rgb.as_chunks_mut::<3>().0.iter_mut();
    for (((pixel, &r), &g), &b) in pixels.zip(red).zip(green).zip(blue) {
        *pixel = [sample(r), sample(g), sample(b)];
    }
    rgb
}

/// Clamped to \[0, 1\]; NaN gives 0, which `f32::clamp` would pass on.
fn unit(c: f32) -> f32 {
    if c > 0.0 { c.min(1.0) } else { 0.0 }
}

fn linear_sample(c: f32, quantize: Quantize) -> u8 {
    let scaled = 255.0 * unit(c);
    // The cast truncates, which is floor for what is not negative.
    match quantize {
        Quantize::Floor => scaled as u8,
        Quantize::Round => (scaled + 0.5) as u8,
    }
}

/// The number of thresholds at or below a value, without a search: thresholds are more than a cell apart, so that what is below
/// the value's cell is known, and within it is one at most.
struct SrgbTable {
    /// By cell, the sample of its lower end.
    lowest: [u8; CELLS + 1],
    /// By sample, the least value of the next, rounded up: a value of 32 bits reaches it if and only if it reaches the threshold.
    /// The last has none.
    next: [f32; 256],
}

/// The steepest part of the curve, its straight one, has a threshold every 1/3295.
const CELLS: usize = 4096;

impl SrgbTable {
    fn new(thresholds: &[f64; 255]) -> SrgbTable {
        let at_or_below = |c: f64| thresholds.partition_point(|&least| least <= c) as u8;
        let up = |least: f64| match least as f32 {
            near if f64::from(near) < least => near.next_up(),
            near => near,
        };
        SrgbTable {
            // A cell's end is a number of 32 bits, and a value times the number of cells is rounded nowhere.
            lowest: std::array::from_fn(|cell| at_or_below(cell as f64 / CELLS as f64)),
            next: std::array::from_fn(|k| thresholds.get(k).map_or(f32::INFINITY, |t| up(*t))),
        }
    }

    fn sample(&self, c: f32) -> u8 {
        let c = unit(c);
        // From 0 to CELLS; the bound says so to the compiler, too.
        let low = self.lowest[((c * CELLS as f32) as usize).min(CELLS)];
        low + u8::from(c >= self.next[usize::from(low)])
    }
}

/// `thresholds[k - 1]` is the least linear value whose sample is `k`.
fn srgb_thresholds(quantize: Quantize) -> [f64; 255] {
    let back = match quantize {
        Quantize::Floor => 0.0,
        Quantize::Round => 0.5,
    };
    // 1.0 is the largest clamped value: a threshold an ulp above it would make 255 unreachable.
    std::array::from_fn(|i| srgb_inverse(((i + 1) as f64 - back) / 255.0).min(1.0))
}

/// IEC 61966-2-1, from the encoded to the linear value.
fn srgb_inverse(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE_FLOOR: Tone = Tone {
        transfer: Transfer::None,
        quantize: Quantize::Floor,
    };

    /// The red samples of a one-row film.
    fn samples(values: &[f32], transfer: Transfer, quantize: Quantize) -> Vec<u8> {
        let film = Film {
            width: values.len() as u32,
            height: 1,
            planes: [
                values.to_vec(),
                vec![0.0; values.len()],
                vec![1.0; values.len()],
            ],
            hits: None,
        };
        let picture = encode(&film, Tone { transfer, quantize });
        assert_eq!(picture.rgb.len(), 3 * values.len());
        for pixel in picture.rgb.chunks_exact(3) {
            assert_eq!(pixel[1..], [0, 255]);
        }
        picture.rgb.iter().step_by(3).copied().collect()
    }

    const ODD: [f32; 7] = [
        f32::NAN,
        -1.0,
        -0.0,
        f32::NEG_INFINITY,
        f32::INFINITY,
        2.0,
        1.0,
    ];

    #[test]
    fn values_outside_the_unit_interval_are_clamped_and_nan_is_black() {
        for transfer in [Transfer::None, Transfer::Srgb] {
            for quantize in [Quantize::Floor, Quantize::Round] {
                let got = samples(&ODD, transfer, quantize);
                assert_eq!(
                    got,
                    [0, 0, 0, 0, 255, 255, 255],
                    "{transfer:?} {quantize:?}"
                );
            }
        }
    }

    #[test]
    fn without_transfer_the_sample_is_floor_or_nearest_of_255_c() {
        // 255 · 0.5 = 127.5; 255 · 0.998 = 254.49; 0.2 is an f32 just above 1/5, so that 255 · 0.2 is 51.
        let values = [0.5, 0.998, 0.999, 0.2, 0.001];
        assert_eq!(
            samples(&values, Transfer::None, Quantize::Floor),
            [127, 254, 254, 51, 0]
        );
        assert_eq!(
            samples(&values, Transfer::None, Quantize::Round),
            [128, 254, 255, 51, 0]
        );
    }

    #[test]
    fn srgb_gives_known_values() {
        // 0.5 encodes to 187.516, 0.18 to 117.65, 0.002 (the straight part) to 6.589, 0.9999 to 254.99.
        let values = [0.5, 0.18, 0.002, 0.9999];
        assert_eq!(
            samples(&values, Transfer::Srgb, Quantize::Floor),
            [187, 117, 6, 254]
        );
        assert_eq!(
            samples(&values, Transfer::Srgb, Quantize::Round),
            [188, 118, 7, 255]
        );
    }

    #[test]
    fn srgb_thresholds_agree_with_the_forward_curve() {
        let forward = |c: f64| match c {
            c if c <= 0.003_130_8 => 255.0 * 12.92 * c,
            c => 255.0 * (1.055 * libm::pow(c, 1.0 / 2.4) - 0.055),
        };
        for (quantize, offset) in [(Quantize::Floor, 0.0), (Quantize::Round, 0.5)] {
            let thresholds = srgb_thresholds(quantize);
            assert!(thresholds.windows(2).all(|w| w[0] < w[1]));
            for (i, &least) in thresholds.iter().enumerate() {
                let at = forward(least) + offset;
                // The two published constants of the joint differ in the eighth digit.
                assert!((at - (i + 1) as f64).abs() < 1e-3, "{quantize:?} {i}: {at}");
            }
        }
    }

    /// Beside every threshold, at every cell's ends, and all over.
    #[test]
    fn the_table_counts_thresholds() {
        for quantize in [Quantize::Floor, Quantize::Round] {
            let thresholds = srgb_thresholds(quantize);
            let table = SrgbTable::new(&thresholds);
            let cells = (0..=CELLS).map(|cell| cell as f32 / CELLS as f32);
            let near = thresholds.map(|t| t as f32).into_iter().chain(cells);
            let near =
                near.flat_map(|c| [c.next_down().next_down(), c.next_down(), c, c.next_up()]);
            let all = (0..3_000_000).map(|k| k as f32 / 2_900_000.0);
            for c in near.chain(all).chain(ODD) {
                let value = f64::from(unit(c));
                let want = thresholds.partition_point(|&least| least <= value);
                assert_eq!(usize::from(table.sample(c)), want, "{quantize:?} {c:e}");
            }
        }
    }

    /// The contract "same bytes on every build": these are the bits of the table, written down once.
    #[test]
    fn srgb_thresholds_are_pinned_bit_for_bit() {
        let hash = |quantize| {
            let bytes = srgb_thresholds(quantize).map(f64::to_bits);
            bytes
                .iter()
                .flat_map(|b| b.to_le_bytes())
                .fold(0xcbf2_9ce4_8422_2325_u64, |h, b| {
                    (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
                })
        };
        assert_eq!(hash(Quantize::Floor), PIN_FLOOR);
        assert_eq!(hash(Quantize::Round), PIN_ROUND);
    }

    const PIN_FLOOR: u64 = 5_556_954_415_098_186_741;
    const PIN_ROUND: u64 = 1_944_805_278_954_198_400;

    #[test]
    fn pixels_keep_their_order() {
        let film = Film {
            width: 2,
            height: 1,
            planes: [vec![0.1, 0.4], vec![0.2, 0.5], vec![0.3, 0.6]],
            hits: None,
        };
        assert_eq!(encode(&film, NONE_FLOOR).rgb, [25, 51, 76, 102, 127, 153]);
    }
}
