//! Differences of a layer, summed row by row, so that sums do not depend on how a picture is cut.

use super::super::read::SampleKind;
use super::band_pairs::BandPair;
use super::layer_pairs::{COLOR, LayerPair};
use serde::Serialize;

/// Largest difference of a sample.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LargestDifference {
    /// The difference, in the unit of the samples; not part of its place in documents.
    #[serde(skip)]
    pub value: f64,
    /// Column of the pixel; the first one from the top left, if there are several.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Name of the channel.
    pub channel: String,
}

/// Numbers of samples that are not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NotFiniteCounts {
    /// Samples that are not a number, in the first picture and in the second.
    pub nan: [u64; 2],
    /// Infinite samples, in the first picture and in the second.
    pub infinite: [u64; 2],
    /// Pairs of samples in which one is not finite and the other is not the same: they count as
    /// different regardless of the tolerance.
    pub different: u64,
}

/// Differences of a layer in some rows.
#[derive(Clone, Debug, Default)]
pub(super) struct LayerDifference {
    /// True if a sample has other bits.
    pub(super) bits_differ: bool,
    pub(super) largest: Option<LargestDifference>,
    /// Sum of squared differences of finite samples, excluding alpha if there are colours.
    squares: f64,
    /// Number of samples in that sum.
    samples: u64,
    /// Largest absolute value of a finite sample.
    pub(super) peak: f64,
    /// Pixels with a sample that differs beyond the tolerance.
    pub(super) differing: u64,
    pub(super) not_finite: NotFiniteCounts,
}

impl LayerDifference {
    /// Adds rows below.
    pub(super) fn add(&mut self, below: LayerDifference) {
        self.bits_differ |= below.bits_differ;
        let value = |largest: &Option<LargestDifference>| largest.as_ref().map_or(0.0, |l| l.value);
        if value(&below.largest) > value(&self.largest) {
            self.largest = below.largest;
        }
        self.squares += below.squares;
        self.samples += below.samples;
        self.peak = self.peak.max(below.peak);
        self.differing += below.differing;
        for side in 0..2 {
            self.not_finite.nan[side] += below.not_finite.nan[side];
            self.not_finite.infinite[side] += below.not_finite.infinite[side];
        }
        self.not_finite.different += below.not_finite.different;
    }

    /// Root mean square difference.
    pub(super) fn rmse(&self) -> f64 {
        (self.squares / self.samples.max(1) as f64).sqrt()
    }
}

/// Differences of a layer in one row of a band. Pixels that differ beyond the tolerance are marked.
/// Without a tolerance a pixel differs if any of its bits do.
pub(super) fn row_difference(
    layer: &LayerPair,
    band: &BandPair,
    row: u32,
    tolerance: Option<f64>,
    marks: &mut [bool],
) -> LayerDifference {
    let mut difference = LayerDifference::default();
    let mut differs = vec![false; marks.len()];
    let width = marks.len();
    let start = row as usize * width;
    for channel in &layer.channels {
        let [p, q] = [0, 1].map(|side| {
            let plane = &band.planes[side][channel.index[side]];
            &plane[start..start + width]
        });
        let counted = layer.name != COLOR || channel.name != "A";
        let mut largest = 0.0;
        for (x, (&p, &q)) in p.iter().zip(q).enumerate() {
            let pair = SamplePair::of(channel.kind, [p, q]);
            difference.count(&pair, counted);
            differs[x] |= pair.is_beyond(tolerance);
            if pair.finite && pair.difference > largest {
                largest = pair.difference;
                difference.note_largest(largest, x as u32, band.top + row, &channel.name);
            }
        }
    }
    difference.differing = differs.iter().filter(|differs| **differs).count() as u64;
    for (mark, differs) in marks.iter_mut().zip(differs) {
        *mark |= differs;
    }
    difference
}

impl LayerDifference {
    fn note_largest(&mut self, value: f64, x: u32, y: u32, channel: &str) {
        let before = |known: &LargestDifference| {
            value > known.value || (value == known.value && x < known.x)
        };
        if self.largest.as_ref().is_none_or(before) {
            let channel = channel.to_owned();
            self.largest = Some(LargestDifference {
                value,
                x,
                y,
                channel,
            });
        }
    }

    #[inline]
    fn count(&mut self, pair: &SamplePair, counted: bool) {
        self.bits_differ |= !pair.same_bits;
        if pair.finite {
            let [v, w] = pair.values;
            self.peak = self.peak.max(v.abs()).max(w.abs());
            if counted {
                self.squares += pair.difference * pair.difference;
                self.samples += 1;
            }
            return;
        }
        for (side, value) in pair.values.into_iter().enumerate() {
            match value {
                _ if value.is_nan() => self.not_finite.nan[side] += 1,
                _ if value.is_infinite() => self.not_finite.infinite[side] += 1,
                _ => self.peak = self.peak.max(value.abs()),
            }
        }
        self.not_finite.different += u64::from(!pair.same_number);
    }
}

/// Two samples at the same place.
pub(super) struct SamplePair {
    pub(super) values: [f64; 2],
    /// Absolute difference; meaningless unless both are finite.
    pub(super) difference: f64,
    pub(super) finite: bool,
    /// True if all bits are the same; for samples of different kinds, if their numbers are the
    /// same.
    pub(super) same_bits: bool,
    /// True if they are the same number, or both not a number.
    pub(super) same_number: bool,
}

impl SamplePair {
    #[inline]
    pub(super) fn of(kind: [SampleKind; 2], bits: [u32; 2]) -> SamplePair {
        let values = [kind[0].value(bits[0]), kind[1].value(bits[1])];
        let [v, w] = values;
        let same_number = v == w || (v.is_nan() && w.is_nan());
        // 16-bit integers are subtracted before they are divided, which is exact.
        let difference = match kind {
            [SampleKind::Display, SampleKind::Display] => {
                SampleKind::Display.value(bits[0].abs_diff(bits[1]))
            }
            _ => (v - w).abs(),
        };
        SamplePair {
            values,
            difference,
            finite: v.is_finite() && w.is_finite(),
            same_bits: if kind[0] == kind[1] { bits[0] == bits[1] } else { same_number },
            same_number,
        }
    }

    /// Returns true if the samples count as different.
    #[inline]
    fn is_beyond(&self, tolerance: Option<f64>) -> bool {
        match tolerance {
            None => !self.same_bits,
            Some(_) if !self.finite => !self.same_number,
            Some(most) => self.difference > most,
        }
    }
}
