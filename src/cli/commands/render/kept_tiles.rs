//! Files of finished tiles, as they are opened and left.

use crate::cli::output::{self, CliError, grouped};
use phalanx::files::shown_path;
use phalanx::jobs::{RenderKey, TileFile};
use std::path::Path;

/// Opens the file of a picture's finished tiles, and notes how many of its `pixels` they are.
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

/// Warns on stderr of the tiles of a file that must be rendered again.
pub fn warn_damaged(file: &TileFile, name: &Path) {
    if file.damaged() > 0 {
        output::warning(&format!(
            "{}: {} tiles are damaged, and are rendered again",
            shown_path(name),
            grouped(file.damaged() as u64)
        ));
    }
}

/// Makes sure that finished tiles are in the file, also after an interruption, which then says so.
pub fn keep_tiles<T>(file: &TileFile, rendered: Result<T, CliError>) -> Result<T, CliError> {
    file.sync()?;
    rendered.map_err(|error| match error {
        CliError::Interrupted => CliError::Resumable(format!(
            "finished tiles are kept in {}; the same command goes on from there",
            shown_path(file.path())
        )),
        other => other,
    })
}
