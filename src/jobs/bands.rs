//! Renders a window of the picture in bands from top to bottom, a few of which are in memory at a
//! time; or some of its tiles, none of which are kept in memory.

use super::kept_file::KeptFileError;
use super::open_bands::OpenBands;
use super::stored_tiles::{StoredTiles, TileOutputs};
use super::tile_file::TileFile;
use phalanx_image::BAND_ROWS;
use phalanx_render::RenderStats;
use phalanx_render::frame::{
    AccelRef, Control, FrameError, Interrupted, Settings, Tile, render_tiles,
};
use phalanx_scene::Scene;
use phalanx_scene::film::{Aovs, Film, TileSink, tiles};
use std::panic::resume_unwind;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Instant;

/// Approximate number of pixels of a band that is merged: 48 MB of radiance.
const MERGED_PIXELS: u32 = 1 << 22;

/// Approximate number of pixels of a band that is rendered: a hundredth of a second of work, so
/// that the picture is written while it is rendered.
const BAND_PIXELS: u32 = 1 << 18;

/// Maximum number of rows of a band that consists of whole tiles.
const MOST_ROWS: u32 = 1024;

/// The reason why the bands end early.
#[derive(Debug, thiserror::Error)]
pub enum BandsError {
    /// The render was stopped, or is impossible.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A finished tile could not be stored, or could not be read.
    #[error(transparent)]
    Tiles(#[from] KeptFileError),
    /// The system has no thread for rendering while bands are taken.
    #[error("no thread could be started: {0}")]
    Thread(#[source] std::io::Error),
    /// The consumer of the bands wants no more.
    #[error("the caller stopped the picture")]
    Abandoned,
}

/// Totals of rendering bands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandStats {
    /// Work counters.
    pub stats: RenderStats,
    /// Wall seconds of rendering, without reading and without waiting for the consumer of the
    /// bands, which works at the same time.
    pub seconds: f64,
}

/// Bands of a window for tiles of this side, from the top: a multiple of [`BAND_ROWS`] high, and
/// whole tiles where those are not too many rows.
pub fn bands(window: Tile, side: u32) -> Vec<Tile> {
    let heights = (1..=MOST_ROWS / BAND_ROWS).map(|k| k * BAND_ROWS);
    let step = heights.into_iter().find(|rows| rows.is_multiple_of(side));
    let step = step.unwrap_or(BAND_ROWS);
    let rows = BAND_PIXELS / window.width.max(1) / step * step;
    bands_of(window, rows.max(step))
}

/// Bands of a window of up to `rows` rows.
fn bands_of(window: Tile, rows: u32) -> Vec<Tile> {
    let band = |top: u32| Tile {
        y: window.y + top,
        height: rows.min(window.height - top),
        ..window
    };
    let tops = (0..window.height).step_by(rows as usize);
    tops.map(band).collect()
}

/// Renders the window of the settings and passes its bands to `take`, from the top and each as soon
/// as it is complete, while others are rendered. `take` returns whether it wants the next. With a
/// tile file in the outputs, tiles in the file are read from it, and the others are added to it as
/// they are finished.
///
/// # Errors
/// [`BandsError`].
pub fn render_bands(
    scene: &Scene,
    tree: AccelRef,
    settings: &Settings,
    control: &Control,
    outputs: TileOutputs,
    mut take: impl FnMut(Film) -> bool,
) -> Result<BandStats, BandsError> {
    let side = settings.tile_side();
    let bands = bands(settings.window(), side);
    outputs.record_resumed(control, outputs.file.map_or(0, TileFile::pixels));
    let split = bands.iter();
    let split = split.map(|band| split_finished(tiles(*band, side), outputs.file));
    let (finished, missing): (Vec<_>, Vec<_>) = split.unzip();
    let counts = missing.iter().map(Vec::len).collect();
    let missing = missing.concat();
    let stored = StoredTiles::new(outputs, settings.aovs, control);
    let open = OpenBands::new(&bands, (&finished, counts), settings, stored);
    let fill = || {
        let _ended = OnDrop(|| open.end());
        BandStats::render(scene, tree, settings, control, &missing, &open)
    };
    let (filled, is_wanted) = std::thread::scope(|scope| {
        let filling = std::thread::Builder::new().spawn_scoped(scope, fill);
        let filling = filling.map_err(BandsError::Thread)?;
        let closed = OnDrop(|| open.close());
        let is_wanted = open.give_all(&mut take);
        drop(closed);
        let filled = filling.join();
        Ok::<_, BandsError>((
            filled.unwrap_or_else(|panic| resume_unwind(panic)),
            is_wanted,
        ))
    })?;
    if let Some(error) = open.stored.take_error() {
        return Err(error.into());
    }
    if !is_wanted {
        return Err(BandsError::Abandoned);
    }
    let BandStats { stats, seconds } = filled?;
    if !open.all_taken() {
        // Stopped while the last tiles waited for bands above them.
        return Err(FrameError::from(Interrupted).into());
    }
    let waited = open.waited() / settings.threads.max(1) as f64;
    Ok(BandStats {
        stats,
        seconds: (seconds - waited).max(0.0),
    })
}

/// Calls a function when it is dropped, even by a panic.
struct OnDrop<F: Fn()>(F);

impl<F: Fn()> Drop for OnDrop<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

/// Renders tiles of the picture into a file, except those that the file already has.
///
/// # Errors
/// [`BandsError`].
pub fn render_to_file(
    scene: &Scene,
    tree: AccelRef,
    settings: &Settings,
    control: &Control,
    share: Vec<Tile>,
    file: &TileFile,
) -> Result<BandStats, BandsError> {
    let (finished, missing) = split_finished(share, Some(file));
    let outputs = TileOutputs {
        file: Some(file),
        thumbnail: None,
    };
    outputs.record_resumed(control, finished.iter().map(Tile::pixels).sum());
    let stored = StoredTiles::new(outputs, settings.aovs, control);
    let rendered = BandStats::render(scene, tree, settings, control, &missing, &stored);
    match stored.take_error() {
        Some(error) => Err(error.into()),
        None => rendered,
    }
}

/// Assembles a window from the tiles of several files, which together have all of it, and passes
/// each band to `take`.
///
/// # Errors
/// [`BandsError`].
pub fn merge_bands(
    window: Tile,
    aovs: Aovs,
    files: &[TileFile],
    control: &Control,
    mut take: impl FnMut(Film) -> bool,
) -> Result<(), BandsError> {
    let rows = MERGED_PIXELS / window.width.max(1) / BAND_ROWS * BAND_ROWS;
    for band in bands_of(window, rows.max(BAND_ROWS)) {
        let mut film = Film::new(band.width, band.height, false).with_aovs(aovs);
        for file in files {
            if control.stop.load(Relaxed) {
                return Err(FrameError::from(Interrupted).into());
            }
            file.restore(band, &mut film)?;
        }
        control.pixels.fetch_add(band.pixels(), Relaxed);
        if !take(film) {
            return Err(BandsError::Abandoned);
        }
    }
    Ok(())
}

impl BandStats {
    /// Renders tiles into a sink.
    fn render(
        scene: &Scene,
        tree: AccelRef,
        settings: &Settings,
        control: &Control,
        tiles: &[Tile],
        sink: &dyn TileSink,
    ) -> Result<BandStats, BandsError> {
        if tiles.is_empty() {
            return Ok(BandStats::default());
        }
        let start = Instant::now();
        let rendered = render_tiles(scene, tree, settings, control, tiles, sink)?;
        Ok(BandStats {
            stats: rendered.stats,
            seconds: start.elapsed().as_secs_f64(),
        })
    }
}

/// Splits tiles into those that the file has, and those that it does not have.
fn split_finished(tiles: Vec<Tile>, file: Option<&TileFile>) -> (Vec<Tile>, Vec<Tile>) {
    let is_finished = |tile: &Tile| file.is_some_and(|file| file.has(*tile));
    tiles.into_iter().partition(is_finished)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_a_window_in_whole_tiles() {
        for (x, y, width, height) in [
            (0, 0, 640, 480),
            (3, 5, 40_000, 30_000),
            (1, 1, 1, 1),
            (0, 100, 65_536, 65),
            (9, 0, 5_000, 5_001),
        ] {
            let window = Tile {
                x,
                y,
                width,
                height,
            };
            for side in [8, 32, 48, 64, 128, 1000, 1024] {
                let bands = bands(window, side);
                let mut top = y;
                for (k, band) in bands.iter().enumerate() {
                    assert_eq!((band.x, band.y, band.width), (x, top, width));
                    let last = k + 1 == bands.len();
                    assert!(last || band.height % BAND_ROWS == 0, "{band:?}");
                    assert!(last || side == 1000 || band.height % side == 0, "{band:?}");
                    assert!(band.pixels() <= u64::from(BAND_PIXELS.max(width * MOST_ROWS)));
                    top += band.height;
                }
                assert_eq!(top, y + height);
            }
        }
    }
}
