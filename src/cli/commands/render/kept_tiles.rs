//! Opening and closing files of finished tiles.

use crate::cli::output::{self, CliError, grouped};
use phalanx::files::shown_path;
use phalanx::jobs::{RenderKey, TileFile};
use std::path::Path;

/// Opens the file of a picture's finished tiles, and prints their share of its `pixels`.
pub fn open_tiles(path: &Path, key: &RenderKey, pixels: u64) -> Result<TileFile, CliError> {
    let file = TileFile::open(path, key)?;
    warn_damaged(&file, path);
    if file.pixels() > 0 {
        let share = 100.0 * file.pixels() as f64 / pixels as f64;
        output::status(&format!(
            "resuming from {}, {share:.1} % done",
            shown_path(path)
        ));
    }
    Ok(file)
}

/// Warns of damaged tiles in a file, which are rendered again.
pub fn warn_damaged(file: &TileFile, name: &Path) {
    if file.damaged() > 0 {
        output::warning(&format!(
            "{}: {} damaged tiles will be rendered again",
            shown_path(name),
            grouped(file.damaged() as u64)
        ));
    }
}

/// Syncs finished tiles to the file, also after an interruption, whose message then names the file.
pub fn keep_tiles<T>(file: &TileFile, rendered: Result<T, CliError>) -> Result<T, CliError> {
    file.sync()?;
    rendered.map_err(|error| match error {
        CliError::Interrupted => CliError::Resumable(format!(
            "finished tiles are kept in {}; run the same command to resume",
            shown_path(file.path())
        )),
        other => other,
    })
}
