//! A finished tile as bytes of a tile file: a header of [`HEADER_BYTES`] bytes, numbers
//! little-endian, then its planes, row by row.
//!
//! | bytes | content |
//! |---|---|
//! | 0 to 8 | [`MAGIC`] |
//! | 8 to 24 | column, row, width and height of the tile |
//! | 24 to 28 | number of planes |
//! | 28 to 32 | checksum of the picture's identity |
//! | 32 to 36 | checksum of the planes |
//! | 36 to 40 | checksum of all bytes before this field |

use super::render_key::RenderKey;
use phalanx_image::extend_with_plane;
use phalanx_render::frame::Tile;

/// First bytes of a record, used to find the next record in a damaged file.
pub(super) const MAGIC: [u8; 8] = *b"\xf7PHXTILE";

/// Bytes of a header.
pub(super) const HEADER_BYTES: usize = 40;

/// The longest side of a tile: a header with a longer one is invalid.
pub(super) const MAX_SIDE: u32 = 1024;

/// Maximum number of planes of a tile: more than there are channels.
const MAX_PLANES: u32 = 64;

/// Planes of every tile of a picture: red, green, blue, and the channels of its layers.
pub(super) fn planes(key: &RenderKey) -> u32 {
    3 + key.pixels.aovs().channels().count() as u32
}

/// The header of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RecordHeader {
    pub(super) tile: Tile,
    pub(super) planes: u32,
    /// Checksum of the picture's identity.
    pub(super) identity: u32,
    /// Checksum of the planes.
    pub(super) content: u32,
}

impl RecordHeader {
    /// Bytes of the planes.
    pub(super) fn content_bytes(&self) -> usize {
        4 * self.planes as usize * self.tile.pixels() as usize
    }

    fn bytes(&self) -> [u8; HEADER_BYTES] {
        let place = [self.tile.x, self.tile.y, self.tile.width, self.tile.height];
        let words = place
            .into_iter()
            .chain([self.planes, self.identity, self.content]);
        let mut bytes = [0; HEADER_BYTES];
        bytes[..8].copy_from_slice(&MAGIC);
        for (place, word) in bytes[8..36].chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        let checksum = crc32fast::hash(&bytes[..36]);
        bytes[36..].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// Reads a header; `None` if these bytes are not a header.
    pub(super) fn read(bytes: &[u8]) -> Option<RecordHeader> {
        let bytes: &[u8; HEADER_BYTES] = bytes.first_chunk()?;
        let word = |offset: usize| {
            let four = bytes[offset..offset + 4].first_chunk();
            four.map_or(0, |four| u32::from_le_bytes(*four))
        };
        if bytes[..8] != MAGIC || word(36) != crc32fast::hash(&bytes[..36]) {
            return None;
        }
        let head = RecordHeader {
            tile: Tile {
                x: word(8),
                y: word(12),
                width: word(16),
                height: word(20),
            },
            planes: word(24),
            identity: word(28),
            content: word(32),
        };
        let sides = 1..=MAX_SIDE;
        let sound = sides.contains(&head.tile.width)
            && sides.contains(&head.tile.height)
            && (1..=MAX_PLANES).contains(&head.planes);
        sound.then_some(head)
    }
}

/// Writes a record into a buffer, and replaces its content.
pub(super) fn write(buffer: &mut Vec<u8>, tile: Tile, identity: u32, planes: &[&[f32]]) {
    buffer.clear();
    buffer.resize(HEADER_BYTES, 0);
    for plane in planes {
        extend_with_plane(buffer, plane);
    }
    let head = RecordHeader {
        tile,
        planes: planes.len() as u32,
        identity,
        content: crc32fast::hash(&buffer[HEADER_BYTES..]),
    };
    buffer[..HEADER_BYTES].copy_from_slice(&head.bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_read_as_it_was_written_and_no_flipped_bit_is() {
        let tile = Tile {
            x: 70_000,
            y: 3,
            width: 2,
            height: 3,
        };
        let planes = [[1.0f32, 2.0, -3.0, f32::MAX, 0.0, -0.0], [0.5; 6]];
        let mut bytes = vec![1, 2, 3];
        write(&mut bytes, tile, 77, &[&planes[0], &planes[1]]);
        let head = RecordHeader::read(&bytes).unwrap();
        assert_eq!((head.tile, head.planes, head.identity), (tile, 2, 77));
        assert_eq!(bytes.len(), HEADER_BYTES + head.content_bytes());
        assert_eq!(crc32fast::hash(&bytes[HEADER_BYTES..]), head.content);
        assert_eq!(
            bytes[HEADER_BYTES + 8..HEADER_BYTES + 12],
            (-3.0f32).to_le_bytes()
        );
        for bit in 0..8 * HEADER_BYTES {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(RecordHeader::read(&flipped), None, "bit {bit}");
        }
        assert_eq!(RecordHeader::read(&bytes[..HEADER_BYTES - 1]), None);
    }
}
