//! Finished tiles in a file that only grows. It may be cut off anywhere, by a crash or a full disk,
//! and its complete records remain valid.
//!
//! The file begins with the picture's [`RenderKey`] (see `file_header`). Then come records (see
//! `tile_record`), in the order in which tiles were finished. Every record holds the key's
//! checksum, too, so that a file with a damaged header can still be identified. If a byte changes,
//! its tile is rendered again.

use super::file_header;
use super::finished_pixels::FinishedPixels;
use super::kept_file::{KeptFileError, check_regular, open_exclusive};
use super::recovery::Recovery;
use super::render_key::RenderKey;
use super::tile_record::{self, HEADER_BYTES, MAX_SIDE, RecordHeader};
use phalanx_image::put_tile_bytes;
use phalanx_render::frame::Tile;
use phalanx_scene::film::{Film, TileBuffer};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Interval at which written data is flushed to the disk: a power failure costs at most the data of
/// one interval.
const SYNC_INTERVAL: Duration = Duration::from_secs(5);

/// Finished tiles, stored in a file and found by position.
#[derive(Debug)]
pub struct TileFile {
    path: PathBuf,
    identity: u32,
    planes: u32,
    /// Tiles that were present when the file was opened, by row of their upper border.
    tiles: Vec<(Tile, u64)>,
    finished: FinishedPixels,
    pixels: u64,
    /// Tiles that are present, but damaged.
    damaged: usize,
    append: Mutex<AppendPosition>,
}

/// The position in the file where the next tile is written.
#[derive(Debug)]
struct AppendPosition {
    file: File,
    /// The end of the last whole record.
    offset: u64,
    buffer: Vec<u8>,
    synced: Instant,
}

impl TileFile {
    /// Opens the file of a picture's tiles to add to it, or creates it if it does not exist.
    ///
    /// # Errors
    /// [`KeptFileError`]: also where the file is another picture's, and where another process adds
    /// to it.
    pub fn open(path: &Path, key: &RenderKey) -> Result<TileFile, KeptFileError> {
        let io = |source| KeptFileError::io(path, source);
        let file = open_exclusive(path)?;
        let mut opened = TileFile::scan(path, file, key)?;
        let AppendPosition { file, offset, .. } = opened
            .append
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        if *offset == 0 {
            let head = file_header::bytes(key);
            file.seek(SeekFrom::Start(0)).map_err(io)?;
            file.write_all(&head).map_err(io)?;
            *offset = head.len() as u64;
        }
        // Bytes behind the last whole record are part of an unfinished one.
        file.set_len(*offset).map_err(io)?;
        file.seek(SeekFrom::Start(*offset)).map_err(io)?;
        Ok(opened)
    }

    /// Opens a file of a picture's tiles to read them.
    ///
    /// # Errors
    /// [`KeptFileError`].
    pub fn read(path: &Path, key: &RenderKey) -> Result<TileFile, KeptFileError> {
        let io = |source| KeptFileError::io(path, source);
        TileFile::check_place(path)?;
        let file = File::open(path).map_err(io)?;
        TileFile::scan(path, file, key)
    }

    /// Rejects a path that cannot be a tile file, without opening it. Tiles are read from anywhere
    /// in the file, which rules out pipes, devices and `/dev/stdout`.
    ///
    /// # Errors
    /// [`KeptFileError::Io`].
    pub fn check_place(path: &Path) -> Result<(), KeptFileError> {
        check_regular(path)
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Pixels that were finished when the file was opened.
    pub fn pixels(&self) -> u64 {
        self.pixels
    }

    /// Number of damaged tiles, which must be rendered again.
    pub fn damaged(&self) -> usize {
        self.damaged
    }

    /// Returns true if all of a tile was finished when the file was opened.
    pub fn has(&self, tile: Tile) -> bool {
        self.finished.has(tile)
    }

    /// Copies finished pixels of a window onto its film; the other pixels do not change.
    ///
    /// # Errors
    /// The system's reason, or a tile that has changed.
    pub fn restore(&self, window: Tile, film: &mut Film) -> Result<(), KeptFileError> {
        let io = |source| KeptFileError::io(&self.path, source);
        let mut end = self.append.lock().unwrap_or_else(PoisonError::into_inner);
        let mut bytes = [0; HEADER_BYTES];
        let bottom = window.y + window.height;
        // Tiles are sorted by their first rows, and none has more rows than a tile may have.
        let from = |(tile, _): &(Tile, u64)| tile.y.saturating_add(MAX_SIDE) <= window.y;
        let from = self.tiles.partition_point(from);
        let until = self.tiles.partition_point(|(tile, _)| tile.y < bottom);
        let mut moved = false;
        for &(tile, offset) in &self.tiles[from..until] {
            if tile.within(window).pixels() == 0 {
                continue;
            }
            moved = true;
            end.file.seek(SeekFrom::Start(offset)).map_err(io)?;
            end.file.read_exact(&mut bytes).map_err(io)?;
            let changed = || io(io::Error::other("it has changed since it was opened"));
            let same = |head: &RecordHeader| head.tile == tile && head.planes == self.planes;
            let head = RecordHeader::read(&bytes).filter(same);
            let head = head.ok_or_else(changed)?;
            let mut content = vec![0; head.content_bytes()];
            end.file.read_exact(&mut content).map_err(io)?;
            if crc32fast::hash(&content) != head.content {
                return Err(changed());
            }
            put_tile_bytes(film, window, tile, &content);
        }
        if moved {
            let offset = end.offset;
            end.file.seek(SeekFrom::Start(offset)).map_err(io)?;
        }
        Ok(())
    }

    /// Appends a finished tile. If that fails, the file ends with the last whole tile.
    ///
    /// # Errors
    /// The system's reason, most likely a full disk.
    pub fn append(&self, tile: Tile, pixels: &TileBuffer) -> Result<(), KeptFileError> {
        let io = |source| KeptFileError::io(&self.path, source);
        let mut end = self.append.lock().unwrap_or_else(PoisonError::into_inner);
        let AppendPosition {
            file,
            offset,
            buffer,
            synced,
        } = &mut *end;
        tile_record::write(buffer, tile, self.identity, &pixels.planes());
        let written = file.write_all(buffer);
        if let Err(error) = written {
            // Truncation is best effort: an unfinished record is detected anyway.
            let _ = file.set_len(*offset);
            let _ = file.seek(SeekFrom::Start(*offset));
            return Err(io(error));
        }
        *offset += buffer.len() as u64;
        if synced.elapsed() > SYNC_INTERVAL {
            file.sync_data().map_err(io)?;
            *synced = Instant::now();
        }
        Ok(())
    }

    /// Waits until the whole file is on the disk.
    ///
    /// # Errors
    /// The system's reason.
    pub fn sync(&self) -> Result<(), KeptFileError> {
        let end = self.append.lock().unwrap_or_else(PoisonError::into_inner);
        end.file
            .sync_all()
            .map_err(|source| KeptFileError::io(&self.path, source))
    }

    /// Reads every record.
    fn scan(path: &Path, file: File, key: &RenderKey) -> Result<TileFile, KeptFileError> {
        let recovery = Recovery::run(path, &file, key)?;
        let mut finished = FinishedPixels::new(key.pixels.window());
        let new_pixels = recovery.tiles.iter().map(|(tile, _)| finished.add(*tile));
        let pixels = new_pixels.sum();
        let mut tiles = recovery.tiles;
        tiles.sort_by_key(|(tile, offset)| (tile.y, tile.x, *offset));
        Ok(TileFile {
            path: path.into(),
            identity: key.checksum(),
            planes: tile_record::planes(key),
            tiles,
            finished,
            pixels,
            damaged: recovery.damaged,
            append: Mutex::new(AppendPosition {
                file,
                offset: recovery.end,
                buffer: Vec::new(),
                synced: Instant::now(),
            }),
        })
    }
}

#[cfg(test)]
mod tests;
