//! A window of the picture, rendered in bands from top to bottom, of which one is in memory at a
//! time; or some of its tiles, none of which is kept in memory.

use super::thumbnail::Thumbnail;
use super::tile_file::{TileFile, TileFileError};
use crate::RenderStats;
use crate::frame::{AccelRef, Control, FrameError, Interrupted, Settings, Tile, render_tiles};
use phalanx_io::image::BAND_ROWS;
use phalanx_scene::Scene;
use phalanx_scene::film::{Aovs, Film, SharedFilm, TileBuffer, TileSink, tiles};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Approximate number of pixels of a band. That is a fifth of a second of work, so that a thread
/// that finishes it early waits for next to nothing, in 48 MB.
const BAND_PIXELS: u32 = 1 << 22;

/// The reason why no more bands come.
#[derive(Debug, thiserror::Error)]
pub enum BandsError {
    /// The render was stopped, or cannot be.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A finished tile could not be stored, or could not be read.
    #[error(transparent)]
    Tiles(#[from] TileFileError),
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
    /// bands.
    pub seconds: f64,
}

/// Bands of a window, from the top. Each is as high as `BAND_PIXELS` allows, and a multiple of
/// [`BAND_ROWS`].
pub fn bands(window: Tile) -> Vec<Tile> {
    let rows = BAND_PIXELS / window.width.max(1) / BAND_ROWS * BAND_ROWS;
    let rows = rows.max(BAND_ROWS);
    let band = |top: u32| Tile {
        y: window.y + top,
        height: rows.min(window.height - top),
        ..window
    };
    (0..window.height)
        .step_by(rows as usize)
        .map(band)
        .collect()
}

/// Renders the window of the settings band by band and gives each to `take`, which returns whether
/// it wants the next. With a tile file in the outputs, the tiles that the file has are taken from
/// it, and the others are added to it as they are finished.
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
    let mut banded = BandStats::default();
    outputs.record_resumed(control, outputs.file.map_or(0, TileFile::pixels));
    for band in bands(settings.window()) {
        let film = Film::new(band.width, band.height, settings.record_hits);
        let mut film = film.with_aovs(settings.aovs);
        if let Some(file) = outputs.file {
            file.restore(band, &mut film)?;
        }
        let (there, missing) = split_finished(tiles(band, side), outputs.file);
        if let Some(thumbnail) = outputs.thumbnail {
            there
                .iter()
                .for_each(|tile| thumbnail.add_from(&film, band, *tile));
        }
        let kept = BandSink {
            film: Some(SharedFilm::of(&mut film, band, side)),
            aovs: settings.aovs,
            outputs,
            control,
            failed: Mutex::new(None),
        };
        banded.add(scene, tree, settings, &missing, &kept)?;
        if !take(film) {
            return Err(BandsError::Abandoned);
        }
    }
    Ok(banded)
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
    let (there, missing) = split_finished(share, Some(file));
    let outputs = TileOutputs {
        file: Some(file),
        thumbnail: None,
    };
    outputs.record_resumed(control, there.iter().map(Tile::pixels).sum());
    let kept = BandSink {
        film: None,
        aovs: settings.aovs,
        outputs,
        control,
        failed: Mutex::new(None),
    };
    let mut banded = BandStats::default();
    banded.add(scene, tree, settings, &missing, &kept)?;
    Ok(banded)
}

/// Assembles a window from the tiles of several files, which together have all of it, and gives
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
    for band in bands(window) {
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
    fn add(
        &mut self,
        scene: &Scene,
        tree: AccelRef,
        settings: &Settings,
        missing: &[Tile],
        kept: &BandSink,
    ) -> Result<(), BandsError> {
        if missing.is_empty() {
            return Ok(());
        }
        let start = Instant::now();
        let painted = render_tiles(scene, tree, settings, kept.control, missing, kept);
        self.seconds += start.elapsed().as_secs_f64();
        let mut failed = kept.failed.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = failed.take() {
            return Err(error.into());
        }
        self.stats.add(&painted?.stats);
        Ok(())
    }
}

/// Destinations of finished tiles, beside the picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct TileOutputs<'a> {
    /// File that tiles are stored in.
    pub file: Option<&'a TileFile>,
    /// Thumbnail that tiles are shown in.
    pub thumbnail: Option<&'a Thumbnail>,
}

impl TileOutputs<'_> {
    /// Reports the pixels that were finished before, for whoever watches the render's progress.
    fn record_resumed(self, control: &Control, pixels: u64) {
        control.pixels_resumed.store(pixels, Relaxed);
        control.pixels.fetch_add(pixels, Relaxed);
    }
}

/// Splits tiles into those that the file has, and those that it does not have.
fn split_finished(tiles: Vec<Tile>, file: Option<&TileFile>) -> (Vec<Tile>, Vec<Tile>) {
    let there = |tile: &Tile| file.is_some_and(|file| file.has(*tile));
    tiles.into_iter().partition(there)
}

/// Sink for finished tiles: they go onto the band's film, and into the file.
struct BandSink<'a> {
    film: Option<SharedFilm<'a>>,
    aovs: Aovs,
    outputs: TileOutputs<'a>,
    control: &'a Control,
    /// The reason why a tile could not be stored.
    failed: Mutex<Option<TileFileError>>,
}

impl TileSink for BandSink<'_> {
    fn records_hits(&self) -> bool {
        self.film.as_ref().is_some_and(TileSink::records_hits)
    }

    fn aovs(&self) -> Aovs {
        self.aovs
    }

    fn put(&self, tile: Tile, pixels: &TileBuffer) {
        if let Some(film) = &self.film {
            film.put(tile, pixels);
        }
        if let Some(thumbnail) = self.outputs.thumbnail {
            thumbnail.add(tile, pixels);
        }
        let file = self.outputs.file;
        let Some(Err(error)) = file.map(|file| file.append(tile, pixels)) else {
            return;
        };
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        // The first error is the reason; later ones follow from it.
        failed.get_or_insert(error);
        self.control.stop.store(true, Relaxed);
    }
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
            let bands = bands(window);
            let mut top = y;
            for (k, band) in bands.iter().enumerate() {
                assert_eq!((band.x, band.y, band.width), (x, top, width));
                let last = k + 1 == bands.len();
                assert!(last || band.height % BAND_ROWS == 0, "{band:?}");
                assert!(band.pixels() <= u64::from(BAND_PIXELS.max(width * BAND_ROWS)));
                top += band.height;
            }
            assert_eq!(top, y + height);
        }
        assert_eq!(bands(Tile::whole(640, 480)).len(), 1);
    }
}
