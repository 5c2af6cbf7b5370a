//! Finished tiles in a file that only ever grows: it may be cut off anywhere, by a crash or a full disk, and what is whole still counts.
//!
//! The file begins with [`MAGIC`], the length and the checksum of the picture's [`Identity`] as JSON, and that; then come records
//! (see `record`), in the order in which tiles were finished. Every tile names the identity's checksum, too, so that a file with a
//! damaged beginning is still known. A byte that has changed costs the tile that it belongs to, which is rendered again.

use super::coverage::Coverage;
use super::identity::Identity;
use super::record::{self, HEAD, Head};
use super::scan::{Owner, Scan};
use crate::frame::Tile;
use crate::image::Place;
use crate::render::{Film, Pixels};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What a tile file begins with.
pub(super) const MAGIC: [u8; 8] = *b"PHXTILES";

/// Before the identity: magic, length, checksum.
pub(super) const BEFORE: usize = 16;

/// How often what was written is asked to be on the disk, and not on its way there: what a power failure may cost.
const SYNC: Duration = Duration::from_secs(5);

/// Why a tile file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TileFileError {
    /// It could not be read or written.
    #[error("cannot use {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Another process writes to it.
    #[error("{}: another render is using it", path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// It is some other file.
    #[error("{}: not a file of finished tiles", path.display())]
    Other {
        /// The file.
        path: PathBuf,
    },
    /// It holds tiles of another picture.
    #[error("{}: holds tiles of another picture: {what} {there} there, {here} here", path.display())]
    Different {
        /// The file.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// Its value in the file.
        there: String,
        /// Its value now.
        here: String,
    },
}

/// Finished tiles, in a file and known by place.
#[derive(Debug)]
pub struct TileFile {
    path: PathBuf,
    identity: u32,
    /// Tiles that were there when the file was opened, by row of their upper border.
    tiles: Vec<(Tile, u64)>,
    coverage: Coverage,
    pixels: u64,
    /// Tiles that are there, but not as they were written.
    damaged: usize,
    end: Mutex<End>,
}

/// Where the next tile goes.
#[derive(Debug)]
struct End {
    file: File,
    /// The end of the last whole record.
    at: u64,
    buffer: Vec<u8>,
    synced: Instant,
}

impl TileFile {
    /// Opens the file of a picture's tiles to add to it, or begins one where there is none.
    ///
    /// # Errors
    /// [`TileFileError`]: also where the file is another picture's, and where another process adds to it.
    pub fn open(path: &Path, identity: &Identity) -> Result<TileFile, TileFileError> {
        let io = |source| io_error(path, source);
        TileFile::check_place(path)?;
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false);
        let file = file.open(path).map_err(io)?;
        lock(&file, path)?;
        let mut opened = TileFile::scan(path, file, identity)?;
        let End { file, at, .. } = opened.end.get_mut().unwrap_or_else(PoisonError::into_inner);
        if *at == 0 {
            let head = head(identity);
            file.seek(SeekFrom::Start(0)).map_err(io)?;
            file.write_all(&head).map_err(io)?;
            *at = head.len() as u64;
        }
        // Whatever stands behind the last whole record is half of one.
        file.set_len(*at).map_err(io)?;
        file.seek(SeekFrom::Start(*at)).map_err(io)?;
        Ok(opened)
    }

    /// Opens a file of a picture's tiles to take them from it.
    ///
    /// # Errors
    /// [`TileFileError`].
    pub fn read(path: &Path, identity: &Identity) -> Result<TileFile, TileFileError> {
        TileFile::check_place(path)?;
        let file = File::open(path).map_err(|source| io_error(path, source))?;
        TileFile::scan(path, file, identity)
    }

    /// Refuses a place that no tile file can be at, without opening it: tiles are read again from anywhere in the file, so that pipes,
    /// devices and `/dev/stdout` will not do.
    ///
    /// # Errors
    /// [`TileFileError::Io`].
    pub fn check_place(path: &Path) -> Result<(), TileFileError> {
        let refused = || io::Error::other("finished tiles are kept in a regular file only");
        match Place::of(path) {
            Ok(Place::File(_)) => Ok(()),
            Ok(Place::Stream(_) | Place::Open(_)) => Err(io_error(path, refused())),
            Err(error) => Err(io_error(path, error)),
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Pixels that were finished when the file was opened.
    pub fn pixels(&self) -> u64 {
        self.pixels
    }

    /// Tiles that were damaged, and have to be rendered again.
    pub fn damaged(&self) -> usize {
        self.damaged
    }

    /// Whether all of a tile was finished when the file was opened.
    pub fn has(&self, tile: Tile) -> bool {
        self.coverage.has(tile)
    }

    /// Puts finished pixels of a window onto its film; those that are not finished stay as they are.
    ///
    /// # Errors
    /// The system's reason, or that a tile is no longer what it was.
    pub fn restore(&self, window: Tile, film: &mut Film) -> Result<(), TileFileError> {
        let io = |source| io_error(&self.path, source);
        let mut end = self.end.lock().unwrap_or_else(PoisonError::into_inner);
        let mut bytes = Vec::new();
        let bottom = window.y + window.height;
        let until = self.tiles.partition_point(|(tile, _)| tile.y < bottom);
        let mut moved = false;
        for &(tile, at) in &self.tiles[..until] {
            if tile.within(window).pixels() == 0 {
                continue;
            }
            moved = true;
            bytes.resize(HEAD, 0);
            end.file.seek(SeekFrom::Start(at)).map_err(io)?;
            end.file.read_exact(&mut bytes).map_err(io)?;
            let changed = || io(io::Error::other("it has changed since it was opened"));
            let head = Head::read(&bytes).filter(|head| head.tile == tile);
            let head = head.ok_or_else(changed)?;
            bytes.resize(head.content_bytes(), 0);
            end.file.read_exact(&mut bytes).map_err(io)?;
            if crc32fast::hash(&bytes) != head.content {
                return Err(changed());
            }
            put(film, window, tile, &bytes);
        }
        if moved {
            let at = end.at;
            end.file.seek(SeekFrom::Start(at)).map_err(io)?;
        }
        Ok(())
    }

    /// Adds a finished tile. Where that fails, the file ends with the last whole one.
    ///
    /// # Errors
    /// The system's reason: that the disk is full, most likely.
    pub fn append(&self, tile: Tile, pixels: &Pixels) -> Result<(), TileFileError> {
        let io = |source| io_error(&self.path, source);
        let mut end = self.end.lock().unwrap_or_else(PoisonError::into_inner);
        let End {
            file,
            at,
            buffer,
            synced,
        } = &mut *end;
        record::write(buffer, tile, self.identity, &pixels.planes());
        let written = file.write_all(buffer);
        if let Err(error) = written {
            // As much as can be done: what is half written is found out anyway.
            let _ = file.set_len(*at);
            let _ = file.seek(SeekFrom::Start(*at));
            return Err(io(error));
        }
        *at += buffer.len() as u64;
        if synced.elapsed() > SYNC {
            file.sync_data().map_err(io)?;
            *synced = Instant::now();
        }
        Ok(())
    }

    /// Waits until all of it is on the disk.
    ///
    /// # Errors
    /// The system's reason.
    pub fn sync(&self) -> Result<(), TileFileError> {
        let end = self.end.lock().unwrap_or_else(PoisonError::into_inner);
        end.file
            .sync_all()
            .map_err(|source| io_error(&self.path, source))
    }

    /// Looks at every record.
    fn scan(path: &Path, file: File, identity: &Identity) -> Result<TileFile, TileFileError> {
        let io = |source| io_error(path, source);
        let found = Scan::run(&file, identity).map_err(io)?;
        match found.owner {
            Owner::Ours | Owner::Nobody => {}
            Owner::Unknown => return Err(TileFileError::Other { path: path.into() }),
            Owner::Other(theirs) => {
                // Of the same text there is no difference, and the checksum is the text's.
                let (what, there, here) = theirs.difference(identity).unwrap_or_default();
                return Err(TileFileError::Different {
                    path: path.into(),
                    what,
                    there,
                    here,
                });
            }
        }
        let mut coverage = Coverage::new(identity.window());
        let pixels = found
            .tiles
            .iter()
            .map(|(tile, _)| coverage.add(*tile))
            .sum();
        let mut tiles = found.tiles;
        tiles.sort_by_key(|(tile, at)| (tile.y, tile.x, *at));
        Ok(TileFile {
            path: path.into(),
            identity: identity.checksum(),
            tiles,
            coverage,
            pixels,
            damaged: found.damaged,
            end: Mutex::new(End {
                file,
                at: found.end,
                buffer: Vec::new(),
                synced: Instant::now(),
            }),
        })
    }
}

fn io_error(path: &Path, source: io::Error) -> TileFileError {
    TileFileError::Io {
        path: path.into(),
        source,
    }
}

fn lock(file: &File, path: &Path) -> Result<(), TileFileError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(TileFileError::InUse { path: path.into() }),
        // Some network file systems have no locks; what two renders add to one file is still sound.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// The beginning of a file.
pub(super) fn head(identity: &Identity) -> Vec<u8> {
    let text = serde_json::to_string(identity).unwrap_or_default();
    let mut head = MAGIC.to_vec();
    head.extend((text.len() as u32).to_le_bytes());
    head.extend(crc32fast::hash(text.as_bytes()).to_le_bytes());
    head.extend(text.as_bytes());
    head
}

/// Puts the part of a tile that lies in a window onto its film.
fn put(film: &mut Film, window: Tile, tile: Tile, bytes: &[u8]) {
    let part = tile.within(window);
    let plane_bytes = 4 * tile.pixels() as usize;
    for (plane, bytes) in film
        .planes_mut()
        .into_iter()
        .zip(bytes.chunks_exact(plane_bytes))
    {
        let words = bytes.as_chunks::<4>().0;
        for y in part.y..part.y + part.height {
            let from = ((y - tile.y) * tile.width + part.x - tile.x) as usize;
            let to = (y - window.y) as usize * window.width as usize + (part.x - window.x) as usize;
            let width = part.width as usize;
            let pixels = plane[to..to + width].iter_mut();
            for (pixel, word) in pixels.zip(&words[from..from + width]) {
                *pixel = f32::from_le_bytes(*word);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Settings;
    use crate::render::tiles;
    use crate::scene::Scene;
    use std::fs;

    const SIDE: u32 = 16;

    fn identity(width: u32) -> Identity {
        let scene = Scene::default();
        let region = Tile {
            x: 5,
            y: 3,
            width: 60,
            height: 50,
        };
        let settings = Settings {
            width,
            height: 70,
            region: Some(region),
            ..Settings::of(&scene)
        };
        Identity::of(&scene, &settings)
    }

    fn ours() -> Identity {
        identity(80)
    }

    /// A pixel's radiance says where it is.
    fn color(x: u32, y: u32) -> [f32; 3] {
        [x as f32, y as f32, (x * y) as f32]
    }

    fn add(file: &TileFile, tile: Tile) {
        let mut pixels = Pixels::new(false);
        pixels.fit(tile);
        for y in 0..tile.height {
            for x in 0..tile.width {
                pixels.set(x, y, color(tile.x + x, tile.y + y));
            }
        }
        file.append(tile, &pixels).unwrap();
    }

    fn all() -> Vec<Tile> {
        tiles(ours().window(), SIDE)
    }

    /// A file of these tiles.
    fn write(path: &Path, tiles: &[Tile]) {
        let file = TileFile::open(path, &ours()).unwrap();
        tiles.iter().for_each(|tile| add(&file, *tile));
        file.sync().unwrap();
    }

    /// The tiles that a file has, after asserting that all of their pixels are what they were.
    fn held(file: &TileFile) -> Vec<Tile> {
        let window = ours().window();
        let mut film = Film::new(window.width, window.height, false);
        file.restore(window, &mut film).unwrap();
        let (has, hasnt): (Vec<Tile>, Vec<Tile>) = all().iter().partition(|t| file.has(**t));
        let pixel = |x, y| film.pixel(x - window.x, y - window.y);
        for (tile, there) in has
            .iter()
            .map(|t| (t, true))
            .chain(hasnt.iter().map(|t| (t, false)))
        {
            for y in tile.y..tile.y + tile.height {
                for x in tile.x..tile.x + tile.width {
                    let want = if there { color(x, y) } else { [0.0; 3] };
                    assert_eq!(pixel(x, y), want, "({x}, {y})");
                }
            }
        }
        assert_eq!(file.pixels(), has.iter().map(Tile::pixels).sum::<u64>());
        has
    }

    #[test]
    fn what_was_added_is_there_when_it_is_opened_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let all = all();
        write(&path, &all[..3]);
        let again = TileFile::open(&path, &ours()).unwrap();
        assert_eq!(held(&again), all[..3]);
        // And after taking some back, adding goes on at the end.
        add(&again, all[3]);
        drop(again);
        let file = TileFile::read(&path, &ours()).unwrap();
        assert_eq!((held(&file), file.damaged()), (all[..4].to_vec(), 0));
    }

    #[test]
    fn a_file_that_is_cut_off_has_what_is_whole_and_goes_on_from_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let all = all();
        write(&path, &all[..3]);
        let bytes = fs::read(&path).unwrap();
        let beginning = head(&ours()).len();
        let mut ends = vec![beginning];
        for tile in &all[..3] {
            ends.push(ends[ends.len() - 1] + HEAD + 12 * tile.pixels() as usize);
        }
        assert_eq!(ends[3], bytes.len());
        let around = |end: &usize| [end - 1, *end, end + 1, end + HEAD - 1, end + HEAD + 7];
        let cuts = ends.iter().flat_map(around).chain([0, 1, 7, 8, 15, 16, 17]);
        for cut in cuts.filter(|cut| *cut <= bytes.len()) {
            fs::write(&path, &bytes[..cut]).unwrap();
            let file = TileFile::open(&path, &ours()).unwrap();
            let whole = ends[1..].iter().filter(|end| **end <= cut).count();
            assert_eq!(held(&file), all[..whole], "cut at {cut}");
            add(&file, all[4]);
            drop(file);
            let file = TileFile::read(&path, &ours()).unwrap();
            assert_eq!(held(&file).len(), whole + 1, "cut at {cut}");
            assert!(file.has(all[4]));
        }
    }

    #[test]
    fn a_byte_that_has_changed_costs_its_tile_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let all = all();
        write(&path, &all[..4]);
        let bytes = fs::read(&path).unwrap();
        let beginning = head(&ours()).len();
        let mut ends = vec![beginning];
        for tile in &all[..4] {
            ends.push(ends[ends.len() - 1] + HEAD + 12 * tile.pixels() as usize);
        }
        for at in (0..bytes.len())
            .step_by(97)
            .chain(0..40)
            .chain(ends[1]..ends[1] + HEAD)
        {
            let mut changed = bytes.clone();
            changed[at] ^= 0x10;
            fs::write(&path, &changed).unwrap();
            let file = TileFile::open(&path, &ours()).unwrap();
            let hurt = ends.windows(2).position(|e| (e[0]..e[1]).contains(&at));
            let left: Vec<Tile> = (0..4)
                .filter(|k| Some(*k) != hurt)
                .map(|k| all[k])
                .collect();
            assert_eq!(held(&file), left, "byte {at}");
            // It is rendered again, and then all are there.
            if let Some(hurt) = hurt {
                add(&file, all[hurt]);
            }
            drop(file);
            let file = TileFile::read(&path, &ours()).unwrap();
            assert_eq!(held(&file), all[..4], "byte {at}");
        }
    }

    #[test]
    fn other_files_are_refused_and_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let long = "my notes, and what else I wanted to say ".repeat(20);
        for text in ["x", "my notes", &long] {
            fs::write(&path, text).unwrap();
            let refused = TileFile::open(&path, &ours()).unwrap_err();
            assert!(matches!(refused, TileFileError::Other { .. }), "{refused}");
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        fs::remove_file(&path).unwrap();
        write(&path, &all()[..2]);
        let before = fs::read(&path).unwrap();
        let refused = TileFile::open(&path, &identity(81)).unwrap_err();
        assert!(
            refused.to_string().contains("size 80x70 there, 81x70 here"),
            "{refused}"
        );
        assert_eq!(fs::read(&path).unwrap(), before);
        let held = TileFile::open(&path, &ours()).unwrap();
        let refused = TileFile::open(&path, &ours()).unwrap_err();
        assert!(matches!(refused, TileFileError::InUse { .. }), "{refused}");
        drop(held);
        TileFile::open(&path, &ours()).unwrap();
    }
}
