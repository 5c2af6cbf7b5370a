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
#[path = "encoder_tests.rs"]
mod tests;
