//! The first bytes of a cache: they identify the file and locate its sections.
//!
//! | bytes | content |
//! |---|---|
//! | 0..8 | [`MAGIC`] |
//! | 8..12 | [`BYTE_ORDER_MARK`] in the byte order of the machine that wrote it |
//! | 12..16 | [`VERSION`] |
//! | 16..20 | layout: a checksum of the sections' names and row sizes |
//! | 20..24 | number of sections |
//! | 24..32 | length of the file |
//! | 32..36 | CRC-32 of the header and the table, these four bytes taken as zero |
//! | 36..64 | zero |
//! | 64.. | the table, per section: offset (8), rows (8), bytes of a row (4), CRC-32 (4) |
//!
//! The CRC-32 of a section covers its bytes. Sections begin at multiples of [`ALIGN`]; the bytes
//! between them are zero. All numbers are little-endian.

use super::error::CacheFault;
use super::file_type::{MAGIC, VERSION};
use std::ops::Range;

/// A number that reads differently on a machine of another byte order.
const BYTE_ORDER_MARK: u32 = 0x0a0b_0c0d;
/// A cache line, to which the rows of some columns are aligned.
pub(super) const ALIGN: u64 = 64;

/// Bytes that one task checks: they stay in a core's own cache between the checksum and the check
/// of the rows.
pub(super) const BLOCK: usize = 1 << 18;

/// Bound on the rows of a section, which no section reaches. Rows are small and sections few, so no
/// sum of their sizes overflows.
const MAX_ROWS: u64 = 1 << 40;

const HEADER: usize = 64;
const ENTRY: usize = 24;
const CHECKSUM: Range<usize> = 32..36;

/// A section of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SectionEntry {
    pub(super) offset: u64,
    pub(super) rows: u64,
    pub(super) row_bytes: u32,
    pub(super) checksum: u32,
}

impl SectionEntry {
    pub(super) fn bytes(&self) -> u64 {
        self.rows * u64::from(self.row_bytes)
    }

    /// Its span in the file; [`read`] has checked that the file is long enough.
    pub(super) fn range(&self) -> Range<usize> {
        self.offset as usize..(self.offset + self.bytes()) as usize
    }
}

/// Name of a section and size of its rows. Those of all sections are the layout.
pub(super) type SectionLayout = (&'static str, usize);

fn layout(shapes: &[SectionLayout]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for (name, row_bytes) in shapes {
        hasher.update(format!("{name}:{row_bytes};").as_bytes());
    }
    hasher.finalize()
}

/// Offsets of sections of these sizes, one after another, and the length of the file.
fn section_offsets(sizes: impl Iterator<Item = u64>, count: usize) -> (Vec<u64>, u64) {
    let mut end = (HEADER + ENTRY * count) as u64;
    let begin = |size: u64| {
        let offset = end.next_multiple_of(ALIGN);
        end = offset + size;
        offset
    };
    (sizes.map(begin).collect(), end)
}

/// Header and table for sections (rows and checksum of each), and the offset of each.
pub(super) fn write(shapes: &[SectionLayout], sections: &[(u64, u32)]) -> (Vec<u8>, Vec<u64>) {
    let size =
        |(&(_, row_bytes), &(rows, _)): (&SectionLayout, &(u64, u32))| rows * row_bytes as u64;
    let (offsets, end) = section_offsets(shapes.iter().zip(sections).map(size), shapes.len());
    let mut bytes = MAGIC.to_vec();
    bytes.extend(BYTE_ORDER_MARK.to_ne_bytes());
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(layout(shapes).to_le_bytes());
    bytes.extend((shapes.len() as u32).to_le_bytes());
    bytes.extend(end.to_le_bytes());
    bytes.resize(HEADER, 0);
    for (((_, row_bytes), (rows, checksum)), offset) in shapes.iter().zip(sections).zip(&offsets) {
        bytes.extend(offset.to_le_bytes());
        bytes.extend(rows.to_le_bytes());
        bytes.extend((*row_bytes as u32).to_le_bytes());
        bytes.extend(checksum.to_le_bytes());
    }
    let checksum = crc32fast::hash(&bytes);
    bytes[CHECKSUM].copy_from_slice(&checksum.to_le_bytes());
    (bytes, offsets)
}

/// The sections of a file that is a whole cache of this layout. Their bytes are not checked yet.
pub(super) fn read(file: &[u8], shapes: &[SectionLayout]) -> Result<Vec<SectionEntry>, CacheFault> {
    let begins = file.len().min(MAGIC.len());
    if file.is_empty() || file[..begins] != MAGIC[..begins] {
        return Err(CacheFault::NotACache);
    }
    let length = file.len() as u64;
    let cut = |needed: u64| CacheFault::Truncated { length, needed };
    let header = file.get(..HEADER).ok_or(cut(HEADER as u64))?;
    if word(header, 8) == BYTE_ORDER_MARK.swap_bytes() {
        return Err(CacheFault::ByteOrder);
    }
    if word(header, 8) != BYTE_ORDER_MARK {
        return Err(CacheFault::Damaged("header"));
    }
    if word(header, 12) != VERSION {
        return Err(CacheFault::Version(word(header, 12)));
    }
    // An older or newer build may have another number of sections. The checksum tells that from
    // damage.
    let count = word(header, 20) as usize;
    let end = HEADER as u64 + ENTRY as u64 * count as u64;
    let table = file.get(..end as usize).ok_or(cut(end))?;
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&table[..CHECKSUM.start]);
    hasher.update(&[0; 4]);
    hasher.update(&table[CHECKSUM.end..]);
    if hasher.finalize() != word(header, CHECKSUM.start) {
        return Err(CacheFault::Damaged("header"));
    }
    if word(header, 16) != layout(shapes) || count != shapes.len() {
        return Err(CacheFault::Layout);
    }
    let sections: Vec<SectionEntry> = table[HEADER..].chunks_exact(ENTRY).map(entry).collect();
    check_offsets(&sections, shapes, long(header, 24), length)?;
    Ok(sections)
}

/// Checks that the sections are at the offsets that [`write()`] gives them, so that none overlaps
/// another or leaves the file.
fn check_offsets(
    sections: &[SectionEntry],
    shapes: &[SectionLayout],
    end: u64,
    length: u64,
) -> Result<(), CacheFault> {
    let fitting = sections
        .iter()
        .zip(shapes)
        .all(|(section, (_, row_bytes))| {
            section.row_bytes as usize == *row_bytes && section.rows < MAX_ROWS
        });
    if !fitting {
        return Err(CacheFault::Damaged("table of sections"));
    }
    let (offsets, expected) =
        section_offsets(sections.iter().map(SectionEntry::bytes), sections.len());
    if expected != end || offsets.iter().ne(sections.iter().map(|s| &s.offset)) {
        return Err(CacheFault::Damaged("table of sections"));
    }
    match length.cmp(&end) {
        std::cmp::Ordering::Less => Err(CacheFault::Truncated {
            length,
            needed: end,
        }),
        std::cmp::Ordering::Equal => Ok(()),
        std::cmp::Ordering::Greater => Err(CacheFault::Surplus("after its end")),
    }
}

fn entry(bytes: &[u8]) -> SectionEntry {
    SectionEntry {
        offset: long(bytes, 0),
        rows: long(bytes, 8),
        row_bytes: word(bytes, 16),
        checksum: word(bytes, 20),
    }
}

fn word(bytes: &[u8], offset: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|k| bytes[offset + k]))
}

fn long(bytes: &[u8], offset: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|k| bytes[offset + k]))
}

/// Returns true if the bytes between the sections are zero. Otherwise a flipped bit there would go
/// unnoticed.
pub(super) fn gaps_are_zero(file: &[u8], sections: &[SectionEntry]) -> bool {
    let mut end = HEADER + ENTRY * sections.len();
    sections.iter().all(|section| {
        let gap = end..section.range().start;
        end = section.range().end;
        file[gap].iter().all(|&b| b == 0)
    })
}
