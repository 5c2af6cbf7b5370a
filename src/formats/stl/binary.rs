//! Binary STL: the positions of its facets. The length of the file decides, because counts are
//! often wrong.

use crate::diagnostics::{DiagnosticSink, Span, counted};
use crate::memory::{MemoryLedger, OverLimit};
use std::borrow::Cow;

/// Bytes before the first facet of a binary file: a remark and the number of facets.
pub(super) const HEADER: usize = 84;
/// Bytes of a facet: a normal, three corners, and a word of two bytes.
pub(super) const FACET: usize = 50;

/// Bytes of a corner; equal to the bytes before the first corner of a facet.
const CORNER: usize = 12;

/// Facets of a binary file.
pub(super) struct BinaryFacets<'a> {
    /// [`FACET`] bytes for each.
    pub(super) bytes: Cow<'a, [u8]>,
    /// The file, if the words of facets are lengths of data that follows each.
    payloads: Option<&'a [u8]>,
}

/// The number of facets that the header announces; `None` if there is no whole header.
pub(super) fn announced(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..)?.first_chunk()?;
    Some(u64::from(u32::from_le_bytes(*count)))
}

/// Returns true if the length of a file is that of the facets that its header announces, and of
/// the data that follows each.
pub(super) fn is_exact(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|count| {
        let rest = (bytes.len() - HEADER) as u64;
        rest == count * FACET as u64 || count_payloads(bytes) == Some(count)
    })
}

/// Offsets of facets that are followed by as many bytes as the word at their end says.
fn payload_offsets(bytes: &[u8]) -> impl Iterator<Item = usize> {
    let mut position = HEADER;
    std::iter::from_fn(move || {
        let facet = bytes.get(position..position + FACET)?;
        let offset = position;
        position += FACET + usize::from(word(facet, 0));
        Some(offset)
    })
}

/// The number of facets with data between them, if they fill the file.
fn count_payloads(bytes: &[u8]) -> Option<u64> {
    let (mut count, mut end) = (0, HEADER);
    for offset in payload_offsets(bytes) {
        count += 1;
        end = offset + FACET + usize::from(word(&bytes[offset..], 0));
    }
    (end == bytes.len()).then_some(count)
}

/// The facets of a file that begins with a whole header.
pub(super) fn facets<'a>(
    bytes: &'a [u8],
    memory: &MemoryLedger,
    report: &mut DiagnosticSink,
) -> Result<BinaryFacets<'a>, OverLimit> {
    let plain = |facets: &'a [u8]| {
        Ok(BinaryFacets {
            bytes: Cow::Borrowed(facets),
            payloads: None,
        })
    };
    let Some(promised) = announced(bytes) else {
        let message = "this is not an STL file: it is too short";
        report.error(Span::at(bytes.len()), message);
        return plain(&[]);
    };
    let rest = &bytes[HEADER..];
    let (complete, surplus) = ((rest.len() / FACET) as u64, rest.len() % FACET);
    if promised == complete && surplus == 0 {
        return plain(rest);
    }
    let payloads = count_payloads(bytes);
    if payloads == Some(promised) {
        return with_payloads(bytes, promised, memory);
    }
    let count = Span::new(HEADER - 4, 4);
    let facets = |number: u64| counted(number as usize, "1 facet", "facets");
    let announced = facets(promised);
    let mut miscounted = |number: u64| {
        let number = facets(number);
        let message = format!("the file has {number} by its length, and announces {promised}");
        report.warning(count, message);
    };
    if surplus == 0 {
        miscounted(complete);
        return plain(rest);
    }
    if let Some(number) = payloads {
        miscounted(number);
        return with_payloads(bytes, number, memory);
    }
    if promised > 0 && promised <= complete {
        let (facets, surplus) = rest.split_at(promised as usize * FACET);
        let message = format!("{} bytes behind the last facet are ignored", surplus.len());
        report.warning(Span::at(HEADER + facets.len()), message);
        return plain(facets);
    }
    // Files of other formats may look like this, too.
    let facets = &rest[..rest.len() - surplus];
    let message = format!("the file ends within a facet, after {complete} of {announced}");
    let end = Span::at(bytes.len());
    if complete > 0 && is_likely(facets) {
        report.warning(end, message)
    } else {
        report.error(end, message)
    }
    plain(facets)
}

/// The facets without the data between them, copied.
fn with_payloads<'a>(
    bytes: &'a [u8],
    count: u64,
    memory: &MemoryLedger,
) -> Result<BinaryFacets<'a>, OverLimit> {
    let needed = count * FACET as u64;
    memory.take(needed, "for the facets of the file")?;
    let mut facets = Vec::new();
    facets.reserve_exact(needed as usize);
    let offsets = payload_offsets(bytes);
    offsets.for_each(|offset| facets.extend_from_slice(&bytes[offset..offset + FACET]));
    Ok(BinaryFacets {
        bytes: Cow::Owned(facets),
        payloads: Some(bytes),
    })
}

/// Returns true if at least nine in ten corners are in reach: fewer than half of those made of
/// arbitrary bytes are.
fn is_likely(facets: &[u8]) -> bool {
    let corners = facets.len() / FACET * 3;
    let is_far = |&k: &usize| !crate::mesh::is_in_reach(corner(facets, k).map(f32::from_bits));
    10 * (0..corners).filter(is_far).count() <= corners
}

/// The word at the end of a facet.
#[inline]
fn word(facets: &[u8], facet: usize) -> u16 {
    let offset = facet * FACET + FACET - 2;
    u16::from_le_bytes([facets[offset], facets[offset + 1]])
}

/// The bits of a corner: three for each facet.
#[inline]
pub(super) fn corner(facets: &[u8], corner: usize) -> [u32; 3] {
    let start = corner / 3 * FACET + CORNER * (1 + corner % 3);
    let bytes = &facets[start..start + CORNER];
    let number = |k: usize| {
        bytes[k..]
            .first_chunk()
            .map_or(0, |b| u32::from_le_bytes(*b))
    };
    [number(0), number(4), number(8)]
}

impl BinaryFacets<'_> {
    /// Number of facets.
    pub(super) fn len(&self) -> usize {
        self.bytes.len() / FACET
    }

    /// The word of each facet, unless it is the length of data that follows.
    pub(super) fn words(&self) -> Option<impl ExactSizeIterator<Item = u16> + Clone> {
        let all = (0..self.len()).map(|facet| word(&self.bytes, facet));
        self.payloads.is_none().then_some(all)
    }

    /// Span of a corner.
    pub(super) fn corner_span(&self, corner: usize) -> Span {
        let facet = match self.payloads {
            Some(file) => payload_offsets(file).nth(corner / 3).unwrap_or(HEADER),
            None => HEADER + corner / 3 * FACET,
        };
        Span::new(facet + CORNER * (1 + corner % 3), CORNER)
    }
}
