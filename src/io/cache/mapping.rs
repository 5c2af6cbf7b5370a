//! A file as memory: the one place where bytes of a file are taken for rows.
//!
//! The file is taken not to change while it is mapped. Whoever writes into it or shortens it while
//! it is rendered from gets a wrong picture or a bus error, as with any mapped file;
//! `phalanx build` therefore never writes into an existing file but puts a new one in its place,
//! and a mapping goes on showing the old one. A library answers no signals; the program makes an
//! error message of that one (`cli/bus_error`).

use bytemuck::Pod;
use memmap2::Mmap;
use phalanx_scene::Column;
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
        // Asked before: opening a pipe would wait for somebody to write into it.
        if !std::fs::metadata(path)?.is_file() {
            return Err(io::Error::other("it is not a regular file"));
        }
        let file = File::open(path)?;
        // Not populated at once: faulting pages in on all threads, while they are checked, takes
        // less time than having the system do it on one (perf/notes/cache.md).
        //
        // SAFETY: the map is private to this module, is only read, and the file is taken not to
        // change while it is mapped, as the module says and the user is told.
        let map = unsafe { Mmap::map(&file) }?;
        Ok(Arc::new(Mapping(map)))
    }

    /// The whole file.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// A piece of the file as a column; `None` where it is no whole number of aligned rows within
    /// the file.
    pub(super) fn column<T: Pod>(self: &Arc<Self>, range: Range<usize>) -> Option<Column<T>> {
        let bytes = self.0.get(range)?;
        let rows: &[T] = bytemuck::try_cast_slice(bytes).ok()?;
        if rows.is_empty() {
            return Some(Column::new());
        }
        // SAFETY: the rows are valid as long as the map exists. The column keeps the map alive and
        // gives out no borrow longer than its own; every bit pattern is a `T`, as `Pod` promises.
        let rows: &'static [T] = unsafe { std::slice::from_raw_parts(rows.as_ptr(), rows.len()) };
        Some(Column::mapped(rows, Arc::clone(self) as _))
    }
}
