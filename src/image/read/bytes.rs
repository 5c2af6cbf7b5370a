//! Bytes of a picture file, which its reader may read more than once.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// Number of bytes that identify the kind of a file.
const HEAD: u64 = 16;
/// Maximum number of bytes that are read from a pipe or device, which are held in memory.
const MAX_PIPE_BYTES: u64 = 2 << 30;

/// Bytes of a picture file.
pub(super) enum PictureBytes {
    /// A regular file, read as needed.
    File(File),
    /// All bytes of a pipe or device.
    Memory(Arc<[u8]>),
}

/// A reader for formats that seek.
pub(super) trait ReadSeek: BufRead + Seek + Send {}

impl<T: BufRead + Seek + Send> ReadSeek for T {}

/// Opens a file, and returns its first bytes. A pipe or device is read further only if `wanted`
/// accepts them: one that never ends is not read beyond its first bytes.
pub(super) fn open_bytes(
    path: &Path,
    is_wanted: impl Fn(&[u8]) -> bool,
) -> io::Result<(PictureBytes, Vec<u8>)> {
    let mut file = File::open(path)?;
    let mut head = Vec::new();
    (&mut file).take(HEAD).read_to_end(&mut head)?;
    if file.metadata()?.is_file() {
        return Ok((PictureBytes::File(file), head));
    }
    let mut all = head.clone();
    if is_wanted(&head) {
        file.take(MAX_PIPE_BYTES).read_to_end(&mut all)?;
    }
    if all.len() as u64 >= MAX_PIPE_BYTES {
        let message = "more than 2 GiB from a pipe or device: save it as a file first";
        return Err(io::Error::other(message));
    }
    Ok((PictureBytes::Memory(all.into()), head))
}

impl PictureBytes {
    /// A reader from the first byte on. There may be one at a time.
    pub(super) fn reader(&self) -> Result<Box<dyn ReadSeek>, String> {
        match self {
            PictureBytes::Memory(bytes) => Ok(Box::new(Cursor::new(Arc::clone(bytes)))),
            PictureBytes::File(file) => {
                let mut again = file.try_clone().map_err(|e| e.to_string())?;
                again.seek(SeekFrom::Start(0)).map_err(|e| e.to_string())?;
                Ok(Box::new(BufReader::with_capacity(1 << 16, again)))
            }
        }
    }

    /// Number of bytes.
    pub(super) fn len(&self) -> Result<u64, String> {
        match self {
            PictureBytes::Memory(bytes) => Ok(bytes.len() as u64),
            PictureBytes::File(file) => {
                let metadata = file.metadata().map_err(|e| e.to_string())?;
                Ok(metadata.len())
            }
        }
    }
}
