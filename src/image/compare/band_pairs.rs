//! The same rows of two pictures, band by band.

use super::super::error::{CompareError, PictureError};
use super::super::read::{PictureLayout, PictureReader, SamplePlanes};
use super::layer_pairs::{ChannelPair, LayerPair};
use super::on_screen::{OPAQUE, over_black};
use std::borrow::Cow;

/// Bytes of a band of both pictures, unless a few rows take more.
const BAND_BYTES: u64 = 64 << 20;
/// Maximum number of bytes of a band of both pictures.
const MAX_BAND_BYTES: u64 = 1 << 30;
/// Minimum number of rows of a band.
const MIN_ROWS: u64 = 16;
/// Rows of the blocks of most files.
const BLOCK_ROWS: u64 = 64;

/// Some rows of two pictures.
pub(super) struct BandPair {
    /// The first row.
    pub(super) top: u32,
    /// Number of rows.
    pub(super) rows: u32,
    /// Samples of each picture.
    pub(super) planes: [SamplePlanes; 2],
}

impl BandPair {
    /// The sample of a channel of one picture.
    pub(super) fn bits(&self, side: usize, channel: &ChannelPair, index: usize) -> u32 {
        self.planes[side][channel.index[side]][index]
    }

    /// Samples of a layer's red, green and blue in one picture, over black: see [`over_black`].
    pub(super) fn shown_rgb(&self, side: usize, layer: &LayerPair) -> Option<[Cow<'_, [u32]>; 3]> {
        let plane = |channel: &ChannelPair| &self.planes[side][channel.index[side]][..];
        let alpha = layer.straight_alpha(side).map(plane);
        let alpha = alpha.filter(|alpha| alpha.iter().any(|a| *a < OPAQUE));
        let shown = |channel| match alpha {
            None => Cow::Borrowed(plane(channel)),
            Some(alpha) => {
                let samples = plane(channel).iter().zip(alpha);
                samples.map(|(s, a)| over_black(*s, *a)).collect()
            }
        };
        layer.rgb().map(|rgb| rgb.map(shown))
    }
}

/// Reads two pictures of the same size from the top.
pub(super) fn band_pairs<'a>(
    a: &'a mut PictureReader,
    b: &'a mut PictureReader,
) -> Result<impl Iterator<Item = Result<BandPair, PictureError>>, CompareError> {
    let rows = rows_at_once(a.layout(), b.layout())?;
    let height = a.layout().height;
    Ok((0..height).step_by(rows as usize).map(move |top| {
        let rows = rows.min(height - top);
        let band = top..top + rows;
        let planes = [a.read(band.clone())?, b.read(band)?];
        Ok(BandPair { top, rows, planes })
    }))
}

/// Number of rows that are read at once.
fn rows_at_once(a: &PictureLayout, b: &PictureLayout) -> Result<u32, CompareError> {
    let samples = |layout: &PictureLayout| u64::from(layout.width) * layout.channels.len() as u64;
    let row = 4 * (samples(a) + samples(b)).max(1);
    let rows = match BAND_BYTES / row {
        few @ 0..BLOCK_ROWS => few.max(MIN_ROWS),
        many => many / BLOCK_ROWS * BLOCK_ROWS,
    };
    let rows = rows.min(u64::from(a.height.max(1)));
    if rows * row > MAX_BAND_BYTES {
        Err(CompareError::Memory {
            rows: rows as u32,
            bytes: rows * row,
            most: MAX_BAND_BYTES,
        })
    } else {
        Ok(rows as u32)
    }
}
