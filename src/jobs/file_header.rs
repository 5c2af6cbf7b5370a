//! Header of a tile file, which identifies the picture that the tiles belong to.
//!
//! | bytes | content |
//! |---|---|
//! | 0 to 8 | [`MAGIC`] |
//! | 8 to 12 | length of the text |
//! | 12 to 16 | checksum of the text |
//! | 16 on | the text, a [`KeptHeader`] |

use super::kept_file::KeptFileError;
use super::kept_header::{KeptHeader, KeptKind};
use super::render_key::RenderKey;
use std::io::Read;
use std::path::Path;

/// The first bytes of a tile file.
pub(super) const MAGIC: [u8; 8] = *b"PHXTILES";

/// Magic, length and checksum.
const PREFIX_BYTES: usize = 16;

/// Longest text that is read: many times the length of an identity.
const MAX_TEXT: u32 = 1 << 20;

/// The files' kind in messages. Version 1 did not name its version.
pub(super) const TILES: KeptKind = KeptKind {
    name: "a file of finished tiles",
    foreign: "holds tiles of another picture",
    unnamed_version: Some(1),
};

/// The state of a file's header.
pub(super) enum FileHeader {
    /// Nothing has been written yet, or not even the whole header.
    Empty,
    /// It is this picture's, and records may begin at this offset.
    Ours(u64),
    /// There is none, or it is damaged: records may still be this picture's.
    Unknown,
}

/// Header bytes of a file of a picture's tiles.
pub(super) fn bytes(key: &RenderKey) -> Vec<u8> {
    let text = KeptHeader::new(key, None).json();
    let mut bytes = MAGIC.to_vec();
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(crc32fast::hash(text.as_bytes()).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

/// Reads the header of the file of this length at `path`, and refuses that of another picture or
/// version.
pub(super) fn read(
    reader: &mut impl Read,
    length: u64,
    key: &RenderKey,
    path: &Path,
) -> Result<FileHeader, KeptFileError> {
    let io = |source| KeptFileError::io(path, source);
    let mut before = Vec::new();
    let prefix = reader.take(PREFIX_BYTES as u64).read_to_end(&mut before);
    prefix.map_err(io)?;
    let ours = bytes(key);
    let Some(before) = before.first_chunk::<PREFIX_BYTES>() else {
        // Any other file of that size is somebody's.
        return Ok(if ours.starts_with(&before) { FileHeader::Empty } else { FileHeader::Unknown });
    };
    let word = |offset: usize| u32::from_le_bytes(std::array::from_fn(|k| before[offset + k]));
    let (bytes, checksum) = (word(8), word(12));
    let end = PREFIX_BYTES as u64 + u64::from(bytes);
    if before[..8] != MAGIC || end > length || bytes > MAX_TEXT {
        let cut_off = before[..8] == MAGIC && length < ours.len() as u64;
        return Ok(if cut_off { FileHeader::Empty } else { FileHeader::Unknown });
    }
    // The text is no longer than the file, and than the limit above.
    let mut text = vec![0; bytes as usize];
    reader.read_exact(&mut text).map_err(io)?;
    if crc32fast::hash(&text) != checksum {
        return Ok(FileHeader::Unknown);
    }
    match KeptHeader::new(key, None).check(&text, path, &TILES) {
        Ok(()) => Ok(FileHeader::Ours(end)),
        Err(KeptFileError::Other { .. }) => Ok(FileHeader::Unknown),
        Err(error) => Err(error),
    }
}
