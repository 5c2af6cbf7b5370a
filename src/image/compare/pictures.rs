//! Difference pictures, of the colours or of the first layer that both pictures have.

use super::super::error::{CompareError, PictureError};
use super::super::png::write_png;
use super::super::read::{PictureReader, SampleKind};
use super::band_pairs::{BandPair, band_pairs};
use super::comparison::PictureComparison;
use super::difference::SamplePair;
use super::layer_pairs::{LayerPair, pair_layers};
use super::on_screen::{on_screen, over_black, unit};
use phalanx_files::replace_file;
use std::io;
use std::ops::Range;
use std::path::Path;

/// Columns between pictures that are next to each other.
const GAP: usize = 8;
/// Colour of these columns.
const GAP_COLOR: [u8; 3] = [64; 3];
/// Colour of a pixel with a sample that is not finite in only one picture.
const NOT_FINITE: [u8; 3] = [0, 255, 255];

/// Writes a PNG of the differences: black where the pictures are equal, then from dark red through
/// yellow to white, and cyan where only one of them is finite. White is a difference of 255 steps
/// for a screen, of 1 for linear colours, and of the largest value for other layers.
///
/// # Errors
/// As [`compare_pictures`](super::compare_pictures), and of writing.
pub fn save_heat(
    path: &Path,
    a: &mut PictureReader,
    b: &mut PictureReader,
    comparison: &PictureComparison,
) -> Result<(), CompareError> {
    save(path, [a, b], comparison, false)
}

/// Writes a PNG of the first picture, the second, and their differences as in [`save_heat`], side
/// by side, over black. Linear colours are sRGB-encoded; other layers are shown by the absolute
/// values of their first three channels, as a share of the largest one.
///
/// # Errors
/// As [`save_heat`].
pub fn save_side_by_side(
    path: &Path,
    a: &mut PictureReader,
    b: &mut PictureReader,
    comparison: &PictureComparison,
) -> Result<(), CompareError> {
    save(path, [a, b], comparison, true)
}

/// Writes a PNG of the differences row by row, to the right of both pictures if `side_by_side` is
/// set.
fn save(
    path: &Path,
    [a, b]: [&mut PictureReader; 2],
    comparison: &PictureComparison,
    side_by_side: bool,
) -> Result<(), CompareError> {
    let pairs = pair_layers(a, b)?;
    let first = pairs.common.first().zip(comparison.layers.first());
    let (layer, difference) =
        first.ok_or_else(|| CompareError::NothingInCommon(pairs.only_in.clone()))?;
    let (width, height) = (a.layout().width, a.layout().height);
    let columns = if side_by_side { 3 * width + 2 * GAP as u32 } else { width };
    let drawing = Drawing {
        layer,
        width: width as usize,
        color: layer.rgb().is_some(),
        peak: difference.peak,
    };
    let mut bands = band_pairs(a, b)?.map(|band| {
        let band = band.map_err(io::Error::other)?;
        let (height, drawing) = (band.rows as usize, &drawing);
        let samples = move |rows: Range<usize>| {
            let mut rgb = Vec::with_capacity(3 * columns as usize * rows.len());
            rows.for_each(|row| drawing.row(&band, row, side_by_side, &mut rgb));
            rgb
        };
        Ok((height, Box::new(samples) as Box<_>))
    });
    let written = replace_file(path, |out| {
        write_png(out, (columns, height), None, &mut bands)
    });
    Ok(written.map_err(PictureError::write(path))?)
}

/// Description of how a layer is drawn.
struct Drawing<'a> {
    layer: &'a LayerPair,
    width: usize,
    /// True if it has red, green and blue.
    color: bool,
    /// Largest value of a sample.
    peak: f64,
}

impl Drawing<'_> {
    /// Adds a row of the differences to the samples, to the right of both pictures if
    /// `side_by_side` is set.
    fn row(&self, band: &BandPair, row: usize, side_by_side: bool, rgb: &mut Vec<u8>) {
        let row = row * self.width..(row + 1) * self.width;
        for side in 0..if side_by_side { 2 } else { 0 } {
            rgb.extend(row.clone().flat_map(|index| self.pixel(band, side, index)));
            rgb.extend([GAP_COLOR; GAP].as_flattened());
        }
        rgb.extend(row.flat_map(|index| self.heat(band, index)));
    }

    fn pixel(&self, band: &BandPair, side: usize, index: usize) -> [u8; 3] {
        let alpha = self.layer.straight_alpha(side);
        let alpha = alpha.map(|alpha| band.bits(side, alpha, index));
        let share = |channel: usize| {
            let channel = &self.layer.channels[channel];
            let (kind, bits) = (channel.kind[side], band.bits(side, channel, index));
            if self.color {
                on_screen(kind, alpha.map_or(bits, |alpha| over_black(bits, alpha)))
            } else {
                unit(kind.value(bits).abs() / self.peak.max(f64::MIN_POSITIVE))
            }
        };
        let byte = |share: f64| (share * 255.0 + 0.5) as u8;
        match self.layer.channels.len() {
            1 => [byte(share(0)); 3],
            2 => [byte(share(0)), byte(share(1)), 0],
            _ => [0, 1, 2].map(|channel| byte(share(channel))),
        }
    }

    fn heat(&self, band: &BandPair, index: usize) -> [u8; 3] {
        let mut largest: f64 = 0.0;
        for channel in &self.layer.channels {
            let bits = [0, 1].map(|side| band.bits(side, channel, index));
            let pair = SamplePair::of(channel.kind, bits);
            if pair.finite {
                largest = largest.max(pair.difference);
            } else if !pair.same_number {
                return NOT_FINITE;
            }
        }
        let display = self
            .layer
            .channels
            .iter()
            .all(|c| c.kind == [SampleKind::Display; 2]);
        let full = match (display, self.color) {
            (true, _) => 255.0,
            (false, true) => 1.0,
            (false, false) => self.peak.max(f64::MIN_POSITIVE),
        };
        ramp(largest / full)
    }
}

/// Colour of a difference, 0 to 1: the square root amplifies small ones, so that even the smallest
/// is visible.
fn ramp(difference: f64) -> [u8; 3] {
    if difference <= 0.0 {
        return [0, 0, 0];
    }
    const FLOOR: f64 = 0.15;
    let heat = FLOOR + (1.0 - FLOOR) * difference.min(1.0).sqrt();
    // Three thirds: red rises, then green, then blue.
    [0.0, 1.0, 2.0].map(|third| ((3.0 * heat - third).clamp(0.0, 1.0) * 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_rises_from_black_over_red_and_yellow_to_white() {
        assert_eq!(ramp(0.0), [0, 0, 0]);
        let step = |d: u32| ramp(f64::from(d) / 255.0);
        let [r, g, b] = step(1);
        assert!(r > 100 && g == 0 && b == 0, "one step is visible: {r}");
        assert_eq!(step(255), [255, 255, 255]);
        let brightness = |d| step(d).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!((1..255).all(|d| brightness(d) <= brightness(d + 1)));
        assert_eq!(ramp(1e9), [255, 255, 255]);
    }
}
