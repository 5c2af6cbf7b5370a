//! Comparison of two pictures, layer by layer.

use super::super::error::CompareError;
use super::super::read::{PictureReader, SampleKind};
use super::band_pairs::{BandPair, band_pairs};
use super::difference::{LargestDifference, LayerDifference, NotFiniteCounts, row_difference};
use super::flip::{FlipSum, RgbRow};
use super::layer_pairs::{ChannelPair, LayerPair, LayerPairs, pair_layers};
use super::ssim::SsimChannel;
use phalanx_scene::map_on_pool;
use std::borrow::Cow;

/// Differences of two pictures of one size. Samples for a screen are in steps of an 8-bit sample, 0
/// to 255, of which 16-bit files give fractions; linear samples are as in the files.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureComparison {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// True if the samples are for a screen, and in steps of an 8-bit sample.
    pub display: bool,
    /// Layers that both pictures have, colours first.
    pub layers: Vec<LayerComparison>,
    /// Layers, and channels of layers, that only the first picture has, and those that only the
    /// second has.
    pub only_in: [Vec<String>; 2],
    /// Layers and channels that are not compared, because the other picture's format only has
    /// colours.
    pub left_out: Vec<String>,
    /// Pixels that differ beyond the tolerance in some layer.
    pub differing: u64,
}

/// Differences of one layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerComparison {
    /// Its name; that of red, green, blue and alpha is `color`.
    pub name: String,
    /// Names of its channels.
    pub channels: Vec<String>,
    /// True if all bits of all samples are the same.
    pub identical: bool,
    /// Largest difference of finite samples; `None` if there is none above 0.
    pub largest: Option<LargestDifference>,
    /// Root mean square difference of finite samples. Alpha of the colours is excluded, as opaque
    /// pictures would dilute the result.
    pub rmse: f64,
    /// Largest absolute value of a finite sample in both pictures.
    pub peak: f64,
    /// Peak signal-to-noise ratio in decibels, of a peak of 255 for a screen, and for linear
    /// samples of the largest in both pictures, at least 1. `None` if the error is 0.
    pub psnr: Option<f64>,
    /// Mean structural similarity of red, green and blue as a screen shows them over black. `None`
    /// for other layers, and for pictures smaller than 11x11.
    pub ssim: Option<f64>,
    /// Mean FLIP of red, green and blue as a screen shows them, 0 to 1, at 67 pixels per degree.
    /// `None` for other layers.
    pub flip: Option<f64>,
    /// Pixels that differ beyond the tolerance.
    pub differing: u64,
    /// Samples that are not finite.
    pub not_finite: NotFiniteCounts,
}

impl PictureComparison {
    /// Returns true if all bits are the same, and both have the same layers.
    pub fn identical(&self) -> bool {
        self.layers.iter().all(|layer| layer.identical) && self.only_in.iter().all(Vec::is_empty)
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// Compares two pictures. Samples differ if they are farther apart than the tolerance, in the unit
/// of the samples; without a tolerance, if any of their bits differ. Samples that are not finite
/// equal only their like.
///
/// # Errors
/// [`CompareError`]: pictures of different sizes, of samples of different meaning, without a common
/// layer, or that cannot be read.
pub fn compare_pictures(
    a: &mut PictureReader,
    b: &mut PictureReader,
    tolerance: Option<f64>,
) -> Result<PictureComparison, CompareError> {
    let pairs = pair_layers(a, b)?;
    let layout = a.layout();
    let (width, height) = (layout.width, layout.height);
    let display = !layout.format.is_linear();
    let figures = |layer: &LayerPair| LayerFigures::new(layer, height);
    let mut figures: Vec<LayerFigures> = pairs.common.iter().map(figures).collect();
    let mut differing = 0;
    for band in band_pairs(a, b)? {
        let band = band?;
        differing += add_differences(&pairs, &band, width as usize, tolerance, &mut figures);
        let layers = pairs.common.iter().zip(&mut figures);
        map_on_pool(layers, |(pair, layer)| {
            layer.add_seen(pair, &band, width as usize)
        });
    }
    let layers = pairs.common.iter().zip(figures);
    Ok(PictureComparison {
        width,
        height,
        display,
        layers: layers
            .map(|(pair, difference)| difference.finish(pair, display))
            .collect(),
        only_in: pairs.only_in,
        left_out: pairs.left_out,
        differing,
    })
}

/// Rows that are passed on at once, as they are copied.
const FLIP_ROWS: usize = 64;

/// Figures of one layer in the rows so far.
struct LayerFigures {
    difference: LayerDifference,
    /// One for each of red, green and blue.
    ssim: Vec<SsimChannel>,
    flip: Option<FlipSum>,
}

/// Adds the differences of all layers in a band. Returns the number of pixels that differ.
fn add_differences(
    pairs: &LayerPairs,
    band: &BandPair,
    width: usize,
    tolerance: Option<f64>,
    figures: &mut [LayerFigures],
) -> u64 {
    let rows = map_on_pool(0..band.rows, |row| {
        let mut marks = vec![false; width];
        let layers = pairs.common.iter();
        let differences =
            layers.map(|layer| row_difference(layer, band, row, tolerance, &mut marks));
        let differences: Vec<LayerDifference> = differences.collect();
        (
            differences,
            marks.iter().filter(|mark| **mark).count() as u64,
        )
    });
    let mut differing = 0;
    for (differences, pixels) in rows {
        differing += pixels;
        for (layer, row) in figures.iter_mut().zip(differences) {
            layer.difference.add(row);
        }
    }
    differing
}

impl LayerFigures {
    fn new(layer: &LayerPair, height: u32) -> LayerFigures {
        let is_integer = |channel: &ChannelPair| channel.kind.contains(&SampleKind::Integer);
        let rgb = layer.rgb().filter(|rgb| !rgb.iter().any(|c| is_integer(c)));
        let kinds = |rgb: [&ChannelPair; 3]| [0, 1].map(|side| rgb.map(|c| c.kind[side]));
        let ssim = rgb.iter().flatten();
        LayerFigures {
            difference: LayerDifference::default(),
            ssim: ssim.map(|c| SsimChannel::new(c.kind)).collect(),
            flip: rgb.map(|rgb| FlipSum::new(kinds(rgb), height)),
        }
    }

    fn add_seen(&mut self, pair: &LayerPair, band: &BandPair, width: usize) {
        let [Some(first), Some(second)] = [0, 1].map(|side| band.shown_rgb(side, pair)) else {
            return;
        };
        let channels = first.iter().zip(&second).zip(&mut self.ssim);
        map_on_pool(channels, |((a, b), ssim)| {
            let rows = a.chunks_exact(width).zip(b.chunks_exact(width));
            rows.for_each(|(a, b)| ssim.push(a, b));
        });
        let Some(flip) = &mut self.flip else { return };
        let row = |rgb: &[Cow<[u32]>; 3], row: usize| -> RgbRow {
            [0, 1, 2].map(|c: usize| rgb[c][row * width..(row + 1) * width].to_vec())
        };
        for top in (0..band.rows as usize).step_by(FLIP_ROWS) {
            let end = (top + FLIP_ROWS).min(band.rows as usize);
            let rows = (top..end).map(|y| [row(&first, y), row(&second, y)]);
            flip.push(rows.collect());
        }
    }

    fn finish(self, pair: &LayerPair, display: bool) -> LayerComparison {
        let difference = self.difference;
        let rmse = difference.rmse();
        let peak = if display { 255.0 } else { difference.peak.max(1.0) };
        let means: Vec<f64> = self.ssim.iter().filter_map(SsimChannel::mean).collect();
        LayerComparison {
            name: pair.name.clone(),
            channels: pair.channels.iter().map(|c| c.name.clone()).collect(),
            identical: !difference.bits_differ,
            rmse,
            peak: difference.peak,
            psnr: (rmse > 0.0).then(|| 20.0 * libm::log10(peak / rmse)),
            ssim: (means.len() == 3).then(|| means.iter().sum::<f64>() / 3.0),
            flip: self.flip.as_ref().and_then(FlipSum::mean),
            largest: difference.largest,
            differing: difference.differing,
            not_finite: difference.not_finite,
        }
    }
}
