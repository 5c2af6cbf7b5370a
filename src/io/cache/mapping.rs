//! A file as memory: the only place where bytes of a file are treated as rows.
//!
//! The file must not change while it is mapped. If another program writes into it or shortens it
//! during a render, the result is a wrong picture or a bus error, as with any mapped file.
//! Therefore `phalanx build` never writes into an existing file: it replaces it with a new one, and
//! a mapping still shows the old one. A library does not handle signals; the program turns the bus
//! error into an error message (`cli/options/bus_error`).

use memmap2::{Mmap, MmapMut};
use phalanx_scene::AnyColumn;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// A mapped file, kept alive by every column in it.
pub(super) struct Mapping(Mmap);

impl Mapping {
    /// Maps a file, read only.
    pub(super) fn open(path: &Path) -> io::Result<Arc<Mapping>> {
        // Checked before opening: opening a pipe would wait for a writer.
        if !std::fs::metadata(path)?.is_file() {
            return Err(io::Error::other("it is not a regular file"));
        }
        let file = File::open(path)?;
        // Not populated at once: it is faster to fault pages in on all threads while they are
        // checked than to have the system do it on one (perf/notes/cache.md).
        //
        // SAFETY: the map is private to this module, is only read, and the file is taken not to
        // change while it is mapped, as the module and the user's documentation say.
        let map = unsafe { Mmap::map(&file) }?;
        Ok(Arc::new(Mapping(map)))
    }

    /// Maps a copy of bytes that came from elsewhere.
    pub(super) fn of_bytes(bytes: &[u8]) -> io::Result<Arc<Mapping>> {
        let mut map = MmapMut::map_anon(bytes.len())?;
        map.copy_from_slice(bytes);
        Ok(Arc::new(Mapping(map.make_read_only()?)))
    }

    /// The whole file.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Maps a column to a span of the file; false if that is not a whole number of aligned rows
    /// within the file.
    pub(super) fn map(self: &Arc<Self>, column: &mut dyn AnyColumn, range: Range<usize>) -> bool {
        let Some(bytes) = self.0.get(range) else {
            return false;
        };
        // SAFETY: the bytes are valid as long as the map exists. The column keeps the map alive and
        // gives out no borrow longer than its own.
        let bytes: &'static [u8] =
            unsafe { std::slice::from_raw_parts(bytes.as_ptr(), bytes.len()) };
        column.map(bytes, Arc::clone(self) as _)
    }
}
