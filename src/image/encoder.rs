//! Linear radiance to samples of 8 or 16 bits.
//!
//! The steps are exposure, tone curve, clamp to \[0, 1\] (NaN counts as 0), transfer, and
//! quantisation. No step calls a power function per sample, or a function with results that depend
//! on the build. Without a transfer the sample is `floor(255 c)` or `floor(255 c + 0.5)` in f32,
//! each operation rounded on its own (65535 with 16 bits). With sRGB it is the number of thresholds
//! at or below `c`. The thresholds are the inverse curve in f64 from the `libm` crate, whose
//! results are the same everywhere.

use super::neutral::neutral;
use phalanx_scene::film::Film;
use phalanx_scene::sampling::srgb_to_linear;
use phalanx_scene::{OutputEncoding, Quantize, Transfer};
use std::sync::OnceLock;

/// An RGB picture of 8-bit samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green and blue of each pixel in turn, row by row from the top left.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// Red, green, blue and 255 of each pixel in turn, as canvases of browsers take them.
    pub fn rgba(&self) -> Vec<u8> {
        let mut rgba = vec![u8::MAX; self.rgb.len() / 3 * 4];
        let pixels = rgba.as_chunks_mut::<4>().0.iter_mut();
        for (pixel, rgb) in pixels.zip(self.rgb.as_chunks::<3>().0) {
            pixel[..3].copy_from_slice(rgb);
        }
        rgba
    }
}

/// Maximum number of stops of an exposure, up or down: beyond it every sample of an ordinary
/// picture is black or white.
pub const MAX_EXPOSURE: f32 = 100.0;

/// Curve from exposed radiance to what a screen shows of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// None: values above 1 are white.
    #[default]
    Linear,
    /// Khronos PBR Neutral.
    Neutral,
}

/// An exposure, and what follows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Exposure in stops: radiance is multiplied by two to the power of it, rounded to f32.
    pub stops: f32,
    /// Curve after the exposure.
    pub curve: ToneCurve,
    /// Encoding after the curve.
    pub encoding: OutputEncoding,
}

impl From<OutputEncoding> for Exposure {
    fn from(encoding: OutputEncoding) -> Exposure {
        Exposure {
            stops: 0.0,
            curve: ToneCurve::Linear,
            encoding,
        }
    }
}

impl Exposure {
    fn gain(self) -> f32 {
        libm::exp2(self.stops.into()) as f32
    }

    /// The map from radiance to what the encoding gets: exposure and curve.
    pub fn mapping(self) -> impl Fn([f32; 3]) -> [f32; 3] + use<> {
        let gain = self.gain();
        move |rgb| match self.curve {
            ToneCurve::Linear => rgb.map(|c| c * gain),
            ToneCurve::Neutral => neutral(rgb.map(|c| c * gain)),
        }
    }
}

/// Encodes a film as a picture under an exposure.
pub fn encode(film: &Film, exposure: impl Into<Exposure>) -> Picture {
    Encoder::new(exposure.into()).encode(film)
}

/// Encodes radiance under one exposure.
pub(super) struct Encoder {
    pub(super) exposure: Exposure,
    eight: SrgbTable,
    /// The table for 16-bit samples, made at its first use because it is large.
    sixteen: OnceLock<DeepTable>,
}

impl Encoder {
    pub(super) fn new(exposure: Exposure) -> Encoder {
        Encoder {
            exposure,
            eight: SrgbTable::new(&srgb_thresholds(exposure.encoding.quantize)),
            sixteen: OnceLock::new(),
        }
    }

    pub(super) fn encode(&self, film: &Film) -> Picture {
        Picture {
            width: film.width,
            height: film.height,
            rgb: self.rgb_8(film.planes.each_ref().map(Vec::as_slice)),
        }
    }

    /// Encodes planes of red, green and blue with 8 bits a sample.
    pub(super) fn rgb_8(&self, planes: [&[f32]; 3]) -> Vec<u8> {
        let OutputEncoding { transfer, quantize } = self.exposure.encoding;
        match transfer {
            Transfer::None => interleave(planes, self.exposure, |c| {
                linear_sample(c, 255.0, quantize) as u8
            }),
            Transfer::Srgb => interleave(planes, self.exposure, |c| self.eight.sample(c)),
        }
    }

    /// Encodes planes of red, green and blue with 16 bits a sample.
    pub(super) fn rgb_16(&self, planes: [&[f32]; 3]) -> Vec<u16> {
        let OutputEncoding { transfer, quantize } = self.exposure.encoding;
        match transfer {
            Transfer::None => interleave(planes, self.exposure, |c| {
                linear_sample(c, 65_535.0, quantize) as u16
            }),
            Transfer::Srgb => {
                let table = self.sixteen.get_or_init(|| DeepTable::new(quantize));
                interleave(planes, self.exposure, |c| table.sample(c))
            }
        }
    }
}

/// Three samples per pixel. Calls for each of them took longer than the work itself, so they are
/// inlined, and there is no closure over an array.
fn interleave<S: Copy + Default>(
    [red, green, blue]: [&[f32]; 3],
    exposure: Exposure,
    sample: impl Fn(f32) -> S,
) -> Vec<S> {
    let gain = exposure.gain();
    let mut rgb = vec![S::default(); 3 * red.len()];
    let pixels = rgb.as_chunks_mut::<3>().0.iter_mut();
    let pixels = pixels.zip(red).zip(green).zip(blue);
    // A loop for each curve: a branch per pixel makes the linear one several times as slow.
    match exposure.curve {
        ToneCurve::Linear => {
            for (((pixel, &r), &g), &b) in pixels {
                *pixel = [sample(r * gain), sample(g * gain), sample(b * gain)];
            }
        }
        ToneCurve::Neutral => {
            for (((pixel, &r), &g), &b) in pixels {
                let [r, g, b] = neutral([r * gain, g * gain, b * gain]);
                *pixel = [sample(r), sample(g), sample(b)];
            }
        }
    }
    rgb
}

/// Clamped to \[0, 1\]; NaN gives 0, whereas `f32::clamp` would return NaN.
#[inline(always)]
pub(super) fn unit(c: f32) -> f32 {
    if c > 0.0 { c.min(1.0) } else { 0.0 }
}

/// The value of which the integer part is the sample of `c`, out of `most`.
#[inline(always)]
pub(super) fn linear_sample(c: f32, most: f32, quantize: Quantize) -> f32 {
    let scaled = most * unit(c);
    match quantize {
        Quantize::Floor => scaled,
        Quantize::Round => scaled + 0.5,
    }
}

/// Counts the thresholds of 16-bit samples at or below a value, by a search among those of its
/// cell.
struct DeepTable {
    /// For each sample, the smallest value of the next sample, rounded up as in [`SrgbTable`].
    next: Vec<f32>,
    /// For each cell, the sample of its lower end; then the sample of the last cell's upper end.
    lowest: Vec<u16>,
}

impl DeepTable {
    fn new(quantize: Quantize) -> DeepTable {
        let next: Vec<f32> = (1..=u16::MAX)
            .map(|sample| round_up(threshold(sample.into(), u16::MAX.into(), quantize)))
            .collect();
        let at_or_below = |c: f32| next.partition_point(|&least| least <= c) as u16;
        let ends = (0..=TABLE_CELLS).map(|cell| at_or_below(cell as f32 / TABLE_CELLS as f32));
        DeepTable {
            lowest: ends.collect(),
            next,
        }
    }

    fn sample(&self, c: f32) -> u16 {
        let c = unit(c);
        let cell = ((c * TABLE_CELLS as f32) as usize).min(TABLE_CELLS - 1);
        let [low, high] = [self.lowest[cell], self.lowest[cell + 1]];
        let within = &self.next[low.into()..high.into()];
        low + within.partition_point(|&least| least <= c) as u16
    }
}

/// Counts the thresholds at or below a value, without a search. Thresholds are more than a cell
/// apart, so the count below the value's cell is known, and at most one lies within it.
struct SrgbTable {
    /// For each cell, the sample of its lower end.
    lowest: [u8; TABLE_CELLS + 1],
    /// For each sample, the smallest value of the next, rounded up: a value of 32 bits reaches it
    /// if and only if it reaches the threshold. The last sample has none.
    next: [f32; 256],
}

/// Number of cells. The steepest part of the curve, its straight one, has a threshold every 1/3295.
const TABLE_CELLS: usize = 4096;

impl SrgbTable {
    fn new(thresholds: &[f64; 255]) -> SrgbTable {
        let at_or_below = |c: f64| thresholds.partition_point(|&least| least <= c) as u8;
        SrgbTable {
            // A cell's end is a number of 32 bits, and a value times the number of cells is never
            // rounded.
            lowest: std::array::from_fn(|cell| at_or_below(cell as f64 / TABLE_CELLS as f64)),
            next: std::array::from_fn(|k| {
                thresholds.get(k).map_or(f32::INFINITY, |t| round_up(*t))
            }),
        }
    }

    #[inline(always)]
    fn sample(&self, c: f32) -> u8 {
        let c = unit(c);
        // The index is from 0 to CELLS; the bound also informs the compiler.
        let low = self.lowest[((c * TABLE_CELLS as f32) as usize).min(TABLE_CELLS)];
        low + u8::from(c >= self.next[usize::from(low)])
    }
}

/// The smallest f32 that is not below `least`.
fn round_up(least: f64) -> f32 {
    match least as f32 {
        near if f64::from(near) < least => near.next_up(),
        near => near,
    }
}

/// `thresholds[k - 1]` is the smallest linear value with sample `k`.
fn srgb_thresholds(quantize: Quantize) -> [f64; 255] {
    std::array::from_fn(|i| threshold((i + 1) as f64, 255.0, quantize))
}

/// The smallest linear value with the encoded sample `sample` of `most`.
fn threshold(sample: f64, most: f64, quantize: Quantize) -> f64 {
    let back = match quantize {
        Quantize::Floor => 0.0,
        Quantize::Round => 0.5,
    };
    // 1.0 is the largest clamped value: a threshold an ulp above it would make the last sample
    // unreachable.
    srgb_to_linear((sample - back) / most).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE_FLOOR: OutputEncoding = OutputEncoding {
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
            aovs: Default::default(),
            aov_planes: Vec::new(),
            hits: None,
        };
        let picture = encode(&film, OutputEncoding { transfer, quantize });
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
        // 255 · 0.5 = 127.5; 255 · 0.998 = 254.49; 0.2 is an f32 just above 1/5, so that 255 · 0.2
        // is 51.
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
        // 0.5 encodes to 187.516, 0.18 to 117.65, 0.002 (the straight part) to 6.589, 0.9999 to
        // 254.99.
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
                let position = forward(least) + offset;
                // The two published constants of the joint differ in the eighth digit.
                assert!(
                    (position - (i + 1) as f64).abs() < 1e-3,
                    "{quantize:?} {i}: {position}"
                );
            }
        }
    }

    /// Checks values next to every threshold, at every cell's ends, and over the whole range.
    #[test]
    fn the_table_counts_thresholds() {
        for quantize in [Quantize::Floor, Quantize::Round] {
            let thresholds = srgb_thresholds(quantize);
            let table = SrgbTable::new(&thresholds);
            let cells = (0..=TABLE_CELLS).map(|cell| cell as f32 / TABLE_CELLS as f32);
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

    #[test]
    fn sixteen_bits_are_thresholds_at_or_below() {
        for quantize in [Quantize::Floor, Quantize::Round] {
            let table = DeepTable::new(quantize);
            assert!(table.next.windows(2).all(|w| w[0] < w[1]));
            let near = table
                .next
                .iter()
                .flat_map(|&t| [t.next_down(), t, t.next_up()]);
            let ends = (0..=TABLE_CELLS).map(|cell| cell as f32 / TABLE_CELLS as f32);
            let all = (0..300_000).map(|k| k as f32 / 290_000.0);
            for c in near.chain(ends).chain(all).chain(ODD) {
                let value = f64::from(unit(c));
                let want = match value {
                    v if v <= 0.003_130_8 => 12.92 * v,
                    v => 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055,
                };
                let want = 65_535.0 * want + f64::from(u8::from(quantize == Quantize::Round)) * 0.5;
                let got = f64::from(table.sample(c));
                // Next to a threshold, the forward curve is off by the difference of the published
                // constants.
                assert!(
                    got <= want + 0.02 && got > want - 1.02,
                    "{quantize:?} {c:e}: {got} {want}"
                );
            }
        }
        let srgb = OutputEncoding {
            transfer: Transfer::Srgb,
            quantize: Quantize::Round,
        };
        // 0.5 encodes to 0.735356983.
        let rgb_16 = |encoding: OutputEncoding| {
            Encoder::new(encoding.into()).rgb_16([&[0.5], &[1.0], &[f32::NAN]])
        };
        assert_eq!(rgb_16(srgb), [48_192, 65_535, 0]);
        assert_eq!(rgb_16(NONE_FLOOR), [32_767, 65_535, 0]);
    }

    #[test]
    fn a_stop_is_a_factor_of_two() {
        let film = Film {
            width: 3,
            height: 1,
            planes: [vec![0.1, 0.2, 0.4], vec![1e38; 3], vec![f32::NAN; 3]],
            aovs: Default::default(),
            aov_planes: Vec::new(),
            hits: None,
        };
        let red = |exposure| {
            let grade = Exposure {
                stops: exposure,
                ..NONE_FLOOR.into()
            };
            let rgb = encode(&film, grade).rgb;
            assert_eq!(rgb[1..3], [255, 0]);
            [rgb[0], rgb[3], rgb[6]]
        };
        assert_eq!(red(0.0), [25, 51, 102]);
        assert_eq!(red(1.0), [51, 102, 204]);
        assert_eq!(red(-1.0), [12, 25, 51]);
        // The root of two times 51.
        assert_eq!(red(0.5)[1], 72);
        assert_eq!(red(30.0), [255; 3]);
    }

    #[test]
    fn the_curve_comes_between_exposure_and_transfer() {
        let odd = [f32::NAN, -1.0, f32::NEG_INFINITY];
        let values = [0.02, 0.3, 0.7, 1.0, 4.0, f32::INFINITY]
            .into_iter()
            .chain(odd);
        let red: Vec<f32> = values.collect();
        let [green, blue] = [0.1, 0.4].map(|c| vec![c; red.len()]);
        let planes = [&red[..], &green, &blue];
        for encoding in [OutputEncoding::SRGB, NONE_FLOOR] {
            let toned = Exposure {
                stops: 1.5,
                curve: ToneCurve::Neutral,
                encoding,
            };
            let map = toned.mapping();
            let mapped: Vec<_> = (0..red.len())
                .map(|k| map([red[k], green[k], blue[k]]))
                .collect();
            let mapped = [0, 1, 2].map(|c| mapped.iter().map(|rgb| rgb[c]).collect::<Vec<_>>());
            let (got, plain) = (Encoder::new(toned), Encoder::new(encoding.into()));
            let mapped = mapped.each_ref().map(Vec::as_slice);
            assert_eq!(got.rgb_8(planes), plain.rgb_8(mapped));
            assert_eq!(got.rgb_16(planes), plain.rgb_16(mapped));
            // What is no light is as black as without a curve.
            let black = [
                toned,
                Exposure {
                    curve: ToneCurve::Linear,
                    ..toned
                },
            ]
            .map(|exposure| Encoder::new(exposure).rgb_8([&odd, &odd, &odd]));
            assert_eq!(black, [vec![0; 9], vec![0; 9]]);
        }
    }

    /// The contract "same bytes on every build": these are the expected bits of the table.
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
            aovs: Default::default(),
            aov_planes: Vec::new(),
            hits: None,
        };
        assert_eq!(encode(&film, NONE_FLOOR).rgb, [25, 51, 76, 102, 127, 153]);
    }
}
