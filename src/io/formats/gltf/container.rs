//! GLB: a header of twelve bytes, and chunks. The first chunk is the JSON document, and the second
//! may be a buffer.

use crate::formats::diagnostics::{Span, quoted_bytes};
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
    if version != 2 {
        let message = format!("GLB version {version} is not read here, only version 2");
        return Err(fault(4, message));
    }
    if length > bytes.len() {
        let have = bytes.len();
        let message = format!("the file is cut off: it has {have} of the {length} bytes it says");
        return Err(fault(8, message));
    }
    let mut chunks = Vec::new();
    let mut at = HEADER;
    while at < length && chunks.len() < 2 {
        let (kind, body) = chunk(&bytes[..length], at)?;
        at = body.end;
        chunks.push((kind, body));
    }
    let mut chunks = chunks.into_iter();
    match chunks.next() {
        Some((kind, json)) if &kind == b"JSON" => Ok(Container {
            json,
            binary: chunks
                .next()
                .filter(|(kind, _)| kind == b"BIN\0")
                .map(|(_, body)| body),
        }),
        Some((kind, _)) => {
            let kind = quoted_bytes(&kind);
            let message = format!("the first chunk is {kind}, not `JSON`");
            Err(fault(HEADER + 4, message))
        }
        None => Err(fault(HEADER, "the file has no `JSON` chunk".into())),
    }
}

fn chunk(bytes: &[u8], at: usize) -> Result<([u8; 4], Range<usize>), ContainerFault> {
    let header = bytes.get(at..at + CHUNK_HEADER);
    let header = header.ok_or_else(|| fault(at, "the file ends within a chunk's header".into()))?;
    let (start, length) = (at + CHUNK_HEADER, word(header, 0).unwrap_or(0) as usize);
    let kind = [header[4], header[5], header[6], header[7]];
    match start.checked_add(length) {
        Some(end) if end <= bytes.len() => Ok((kind, start..end)),
        _ => {
            let rest = bytes.len() - start;
            let message =
                format!("a chunk of {length} bytes begins here, but {rest} bytes are left");
            Err(fault(at, message))
        }
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..at + 4)?;
    Some(u32::from_le_bytes(word.try_into().ok()?))
}

fn fault(offset: usize, message: String) -> ContainerFault {
    (Span::at(offset), message)
}
