//! Header of a tile file, which identifies the picture that the tiles belong to.
//!
//! | bytes | content |
//! |---|---|
//! | 0 to 8 | [`MAGIC`] |
//! | 8 to 12 | length of the text |
//! | 12 to 16 | checksum of the text |
//! | 16 on | the text: JSON, of [`LAYOUT_VERSION`] and the picture's identity |

use super::render_key::RenderKey;
use serde::{Deserialize, Serialize};
use std::io::{self, Read};

/// The first bytes of a tile file.
pub(super) const MAGIC: [u8; 8] = *b"PHXTILES";

/// Magic, length and checksum.
const PREFIX_BYTES: usize = 16;

/// Version of the layout of tile files. Version 1 had its settings as one text.
pub(super) const LAYOUT_VERSION: u32 = 2;

/// Longest text that is read: many times the length of an identity.
const MAX_TEXT: u32 = 1 << 20;

/// The owner of a file's tiles.
pub(super) enum FileOwner {
    /// No owner: the file is empty.
    Nobody,
    Ours,
    /// Another picture.
    Other(Box<RenderKey>),
    /// A program that has another layout.
    Layout(u32),
    /// Unknown: the file is no tile file.
    Unknown,
}

/// The JSON text of a header.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct HeaderText<P> {
    layout_version: u32,
    picture: P,
}

/// The version alone, of a text whose other fields may have any names. Version 1 did not name its
/// version.
#[derive(Deserialize)]
struct LayoutVersion {
    #[serde(default = "first")]
    layout_version: u32,
}

fn first() -> u32 {
    1
}

/// Header bytes of a file of a picture's tiles.
pub(super) fn bytes(key: &RenderKey) -> Vec<u8> {
    let text = serde_json::to_string(&HeaderText {
        layout_version: LAYOUT_VERSION,
        picture: key,
    });
    let text = text.unwrap_or_default();
    let mut bytes = MAGIC.to_vec();
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(crc32fast::hash(text.as_bytes()).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

/// Reads the header of a file of this length. Returns its owner, and the offset where records may
/// begin.
pub(super) fn read(
    reader: &mut impl Read,
    length: u64,
    key: &RenderKey,
) -> io::Result<(FileOwner, u64)> {
    if length == 0 {
        return Ok((FileOwner::Nobody, 0));
    }
    let mut before = Vec::new();
    reader.take(PREFIX_BYTES as u64).read_to_end(&mut before)?;
    let ours = bytes(key);
    let cut_off = length < ours.len() as u64;
    let Some(before) = before.first_chunk::<PREFIX_BYTES>() else {
        // A file whose header was not even written completely; any other file of that size is
        // somebody's.
        let owner = match ours.starts_with(&before) {
            true => FileOwner::Nobody,
            false => FileOwner::Unknown,
        };
        return Ok((owner, length));
    };
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|k| before[at + k]));
    let (bytes, checksum) = (word(8), word(12));
    let end = PREFIX_BYTES as u64 + u64::from(bytes);
    if before[..8] != MAGIC || end > length || bytes > MAX_TEXT {
        let owner = match before[..8] == MAGIC && cut_off {
            true => FileOwner::Nobody,
            false => FileOwner::Unknown,
        };
        return Ok((owner, 0));
    }
    // The text is no longer than the file, and than the limit above.
    let mut text = vec![0; bytes as usize];
    reader.read_exact(&mut text)?;
    match crc32fast::hash(&text) == checksum {
        true => Ok(match owner(&text, key) {
            FileOwner::Unknown => (FileOwner::Unknown, 0),
            known => (known, end),
        }),
        false => Ok((FileOwner::Unknown, 0)),
    }
}

fn owner(text: &[u8], key: &RenderKey) -> FileOwner {
    match serde_json::from_slice::<LayoutVersion>(text) {
        Ok(layout) if layout.layout_version != LAYOUT_VERSION => {
            return FileOwner::Layout(layout.layout_version);
        }
        _ => {}
    }
    let Ok(HeaderText { picture, .. }) = serde_json::from_slice::<HeaderText<RenderKey>>(text)
    else {
        return FileOwner::Unknown;
    };
    // Identities are compared as texts, because a zero has a sign.
    match picture.check() {
        Ok(()) if picture.json() == key.json() => FileOwner::Ours,
        Ok(()) => FileOwner::Other(Box::new(picture)),
        Err(_) => FileOwner::Unknown,
    }
}
