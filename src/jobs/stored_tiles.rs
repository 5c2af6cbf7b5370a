//! Destinations of finished tiles apart from the picture: a file and a thumbnail.

use super::kept_file::KeptFileError;
use super::tile_file::TileFile;
use phalanx_image::Thumbnail;
use phalanx_render::frame::{Aovs, Control, Tile};
use phalanx_scene::film::{TileBuffer, TileSink};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Mutex, PoisonError};

/// Destinations of finished tiles apart from the picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct TileOutputs<'a> {
    /// File in which tiles are stored.
    pub file: Option<&'a TileFile>,
    /// Thumbnail that shows the tiles.
    pub thumbnail: Option<&'a Thumbnail>,
}

impl TileOutputs<'_> {
    /// Reports the pixels that were finished before, for displays of the render's progress.
    pub(super) fn record_resumed(self, control: &Control, pixels: u64) {
        control.pixels_resumed.store(pixels, Relaxed);
        control.pixels.fetch_add(pixels, Relaxed);
    }
}

/// Stores finished tiles, and remembers why one could not be stored.
pub(super) struct StoredTiles<'a> {
    pub(super) outputs: TileOutputs<'a>,
    aovs: Aovs,
    control: &'a Control,
    failed: Mutex<Option<KeptFileError>>,
}

impl<'a> StoredTiles<'a> {
    pub(super) fn new(outputs: TileOutputs<'a>, aovs: Aovs, control: &'a Control) -> Self {
        StoredTiles {
            outputs,
            aovs,
            control,
            failed: Mutex::new(None),
        }
    }

    /// The reason why a tile could not be stored, if there is one.
    pub(super) fn take_error(&self) -> Option<KeptFileError> {
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.take()
    }

    /// Returns true if the render should end.
    pub(super) fn is_stopped(&self) -> bool {
        self.control.stop.load(Relaxed)
    }

    /// Keeps the error, and ends the render. The first error is kept; later ones follow from it.
    pub(super) fn fail(&self, error: KeptFileError) {
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.get_or_insert(error);
        self.control.stop.store(true, Relaxed);
    }
}

impl TileSink for StoredTiles<'_> {
    fn records_hits(&self) -> bool {
        false
    }

    fn aovs(&self) -> Aovs {
        self.aovs
    }

    fn put(&self, tile: Tile, pixels: &TileBuffer) {
        if let Some(thumbnail) = self.outputs.thumbnail {
            thumbnail.add(tile, pixels);
        }
        let stored = self.outputs.file.map(|file| file.append(tile, pixels));
        if let Some(Err(error)) = stored {
            self.fail(error);
        }
    }
}
