//! The beginning of a tile file: whose tiles these are.
//!
//! | bytes | what |
//! |---|---|
//! | 0 to 8 | [`MAGIC`] |
//! | 8 to 12 | length of the text |
//! | 12 to 16 | checksum of the text |
//! | 16 on | the text: JSON, of [`LAYOUT`] and the picture's identity |

use super::identity::Identity;
use serde::{Deserialize, Serialize};
use std::io::{self, Read};

/// The first bytes of a tile file.
pub(super) const MAGIC: [u8; 8] = *b"PHXTILES";

/// Magic, length and checksum.
const BEFORE: usize = 16;

/// Version of the layout of tile files. Version 1 had its settings as one text.
pub(super) const LAYOUT: u32 = 2;

/// Longest text that is looked at: many times what an identity takes.
const MAX_TEXT: u32 = 1 << 20;

/// The owner of a file's tiles.
pub(super) enum Owner {
    /// It is empty.
    Nobody,
    Ours,
    /// Another picture.
    Other(Box<Identity>),
    /// A program that has another layout.
    Layout(u32),
    /// It is no tile file.
    Unknown,
}

/// The text of a beginning.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Text<P> {
    layout_version: u32,
    picture: P,
}

/// The version alone, of a text whose other fields may have any names. Version 1 did not name it.
#[derive(Deserialize)]
struct Layout {
    #[serde(default = "first")]
    layout_version: u32,
}

fn first() -> u32 {
    1
}

/// The beginning of a file of a picture's tiles.
pub(super) fn bytes(identity: &Identity) -> Vec<u8> {
    let text = serde_json::to_string(&Text {
        layout_version: LAYOUT,
        picture: identity,
    });
    let text = text.unwrap_or_default();
    let mut bytes = MAGIC.to_vec();
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(crc32fast::hash(text.as_bytes()).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

/// Reads the beginning of a file of this length: its owner, and where records may begin.
pub(super) fn read(
    reader: &mut impl Read,
    length: u64,
    identity: &Identity,
) -> io::Result<(Owner, u64)> {
    if length == 0 {
        return Ok((Owner::Nobody, 0));
    }
    let mut before = Vec::new();
    reader.take(BEFORE as u64).read_to_end(&mut before)?;
    let ours = bytes(identity);
    let cut_off = length < ours.len() as u64;
    let Some(before) = before.first_chunk::<BEFORE>() else {
        // A file of which not even this was written; anything else of that size is somebody's.
        let owner = match ours.starts_with(&before) {
            true => Owner::Nobody,
            false => Owner::Unknown,
        };
        return Ok((owner, length));
    };
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|k| before[at + k]));
    let (bytes, checksum) = (word(8), word(12));
    let end = BEFORE as u64 + u64::from(bytes);
    if before[..8] != MAGIC || end > length || bytes > MAX_TEXT {
        let owner = match before[..8] == MAGIC && cut_off {
            true => Owner::Nobody,
            false => Owner::Unknown,
        };
        return Ok((owner, 0));
    }
    // No longer than the file, and the limit above.
    let mut text = vec![0; bytes as usize];
    reader.read_exact(&mut text)?;
    match crc32fast::hash(&text) == checksum {
        true => Ok(match owner(&text, identity) {
            Owner::Unknown => (Owner::Unknown, 0),
            known => (known, end),
        }),
        false => Ok((Owner::Unknown, 0)),
    }
}

fn owner(text: &[u8], identity: &Identity) -> Owner {
    match serde_json::from_slice::<Layout>(text) {
        Ok(layout) if layout.layout_version != LAYOUT => {
            return Owner::Layout(layout.layout_version);
        }
        _ => {}
    }
    let Ok(Text { picture, .. }) = serde_json::from_slice::<Text<Identity>>(text) else {
        return Owner::Unknown;
    };
    // As texts: a zero has a sign.
    match picture.check() {
        Ok(()) if picture.json() == identity.json() => Owner::Ours,
        Ok(()) => Owner::Other(Box::new(picture)),
        Err(_) => Owner::Unknown,
    }
}
