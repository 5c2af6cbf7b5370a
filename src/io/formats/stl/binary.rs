//! Binary STL.

use crate::formats::diagnostics::{DiagnosticSink, Span};

/// Bytes before the first facet of a binary file: a remark and the number of facets.
pub(super) const HEADER: usize = 84;
/// Bytes of a facet: a normal, three corners, and two unused bytes.
pub(super) const FACET: usize = 50;

/// Bytes of a corner; equal to the bytes before the first corner of a facet.
const CORNER: usize = 12;

/// The bytes of the facets that the file has.
pub(super) fn facets<'a>(bytes: &'a [u8], report: &mut DiagnosticSink) -> &'a [u8] {
    let end = |offset: usize| Span::at(offset);
    let Some(count) = bytes.get(HEADER - 4..).and_then(<[u8]>::first_chunk) else {
        report.error(end(bytes.len()), "this is not an STL file: it is too short");
        return &[];
    };
    let promised = u64::from(u32::from_le_bytes(*count));
    let rest = &bytes[HEADER..];
    let whole = (rest.len() / FACET) as u64;
    if promised > whole {
        let message = format!("the file ends after {whole} of {promised} facets");
        report.error(end(bytes.len()), message);
        return &[];
    }
    let (facets, surplus) = rest.split_at(promised as usize * FACET);
    if !surplus.is_empty() {
        let span = end(HEADER + facets.len());
        report.warning(
            span,
            format!("{} bytes behind the last facet are ignored", surplus.len()),
        );
    }
    facets
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

/// Span of a corner.
pub(super) fn corner_span(corner: usize) -> Span {
    Span::new(
        HEADER + corner / 3 * FACET + CORNER * (1 + corner % 3),
        CORNER,
    )
}
