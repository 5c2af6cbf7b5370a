//! GLB: a header of twelve bytes, and chunks. The first chunk is the JSON document, and the second
//! may be a buffer.

use super::version::FIRST_VERSION;
use crate::diagnostics::{Span, quoted_bytes};
use std::ops::Range;

/// First bytes of every GLB.
pub(super) const MAGIC: &[u8] = b"glTF";

/// The two parts of a file.
pub(super) struct Container {
    /// Span of the document.
    pub(super) json: Range<usize>,
    /// Span of the buffer without a name.
    pub(super) binary: Option<Range<usize>>,
}

/// A fault: its span and a message.
pub(super) type ContainerFault = (Span, String);

/// Kind of the chunk with the buffer.
const BINARY: &[u8] = b"BIN\0";

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Finds the parts of a GLB, or takes the whole file as the document.
pub(super) fn open(bytes: &[u8]) -> Result<Container, ContainerFault> {
    if !bytes.starts_with(MAGIC) {
        return Ok(Container {
            json: 0..bytes.len(),
            binary: None,
        });
    }
    let cut = |offset| fault(offset, "the file ends within its header".into());
    let version = word(bytes, 4).ok_or_else(|| cut(4))?;
    let length = word(bytes, 8).ok_or_else(|| cut(8))? as usize;
    if version == 1 {
        return Err(fault(4, FIRST_VERSION.into()));
    }
    if version != 2 {
        let message = format!("GLB version {version} is not read here, only version 2");
        return Err(fault(4, message));
    }
    // Chunks begin before the file's stated length, and end where their own length says, even
    // beyond it: some writers count padding that they do not write, or do not count what they add.
    let (kind, json) = if length > HEADER {
        chunk(bytes, HEADER)?
    } else {
        return Err(fault(HEADER, "the file has no `JSON` chunk".into()));
    };
    if &kind != b"JSON" {
        let kind = quoted_bytes(&kind);
        let message = format!("the first chunk is {kind}, not `JSON`");
        return Err(fault(HEADER + 4, message));
    }
    let binary = binary_chunk(bytes, json.end, length)?;
    Ok(Container { json, binary })
}

/// Finds the first chunk of binary data that begins from `offset` on and before `end`; others are
/// of extensions, or padding.
fn binary_chunk(
    bytes: &[u8],
    mut offset: usize,
    end: usize,
) -> Result<Option<Range<usize>>, ContainerFault> {
    let is_binary = |offset: usize| bytes.get(offset + 4..offset + CHUNK_HEADER) == Some(BINARY);
    while offset < end {
        // The length of the chunk before may not count its padding.
        if !is_binary(offset) && is_binary(offset.next_multiple_of(4)) {
            offset = offset.next_multiple_of(4);
        }
        match chunk(bytes, offset) {
            Ok((kind, body)) if kind == BINARY => return Ok(Some(body)),
            Ok((_, body)) => offset = body.end,
            Err(cut_off) if is_binary(offset) => return Err(cut_off),
            Err(_) => break,
        }
    }
    Ok(None)
}

fn chunk(bytes: &[u8], offset: usize) -> Result<([u8; 4], Range<usize>), ContainerFault> {
    let header = bytes.get(offset..offset + CHUNK_HEADER);
    let header =
        header.ok_or_else(|| fault(offset, "the file ends within a chunk's header".into()))?;
    let (start, length) = (offset + CHUNK_HEADER, word(header, 0).unwrap_or(0) as usize);
    let kind = [header[4], header[5], header[6], header[7]];
    match start.checked_add(length) {
        Some(end) if end <= bytes.len() => Ok((kind, start..end)),
        _ => {
            let rest = bytes.len() - start;
            let message = format!(
                "the file is cut off: a chunk of {length} bytes begins here, but {rest} bytes are left"
            );
            Err(fault(offset, message))
        }
    }
}

fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    let word = bytes.get(offset..offset + 4)?;
    Some(u32::from_le_bytes(word.try_into().ok()?))
}

fn fault(offset: usize, message: String) -> ContainerFault {
    (Span::at(offset), message)
}
