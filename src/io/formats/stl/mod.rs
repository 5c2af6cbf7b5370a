//! STL: triangles without shared corners, as text or binary. Corners with the same bits become one
//! vertex.
//!
//! Normals of the file are not used: a facet's side follows from the order of its corners, as the
//! format demands.

mod ascii;
mod binary;
mod weld;

use super::diagnostics::{DiagnosticSink, Span};
use super::faces::VERTEX;
use super::mesh::{self, MergedMesh, NotFinite, ParseError};
use super::origin::ReadStop;
use super::workers;
use super::{Loaded, Options};
use phalanx_scene::MaterialTable;

/// Bytes before the first facet of a binary file: a remark and the number of facets.
const HEADER: usize = 84;
/// Bytes of a facet: a normal, three corners, and two unused bytes.
const FACET: usize = 50;

/// The part of a file that is text.
pub(super) fn text_part(bytes: &[u8]) -> &[u8] {
    match is_binary(bytes) {
        true => &[],
        false => bytes,
    }
}

/// Returns true if a file is binary. Its length decides, since many binary files begin with `solid`
/// like text. If the length does not fit, bytes decide that no text has.
fn is_binary(bytes: &[u8]) -> bool {
    let promised = bytes.get(HEADER - 4..).and_then(<[u8]>::first_chunk);
    let exact = promised.is_some_and(|&count| {
        let facets = u64::from(u32::from_le_bytes(count));
        bytes.len() as u64 == HEADER as u64 + facets * FACET as u64
    });
    let text = bytes[mark_length(bytes)..].trim_ascii_start();
    let solid = text
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let head = &bytes[..bytes.len().min(4096)];
    exact || !solid && bytes.len() >= HEADER || memchr::memchr(0, head).is_some()
}

/// The length of the byte order mark that some editors put before text.
fn mark_length(bytes: &[u8]) -> usize {
    let mark = "\u{feff}".as_bytes();
    if bytes.starts_with(mark) {
        mark.len()
    } else {
        0
    }
}

/// Corners as in the file, three for each facet.
type Soup = Vec<[[f32; 3]; 3]>;

/// Reads an STL file.
pub(super) fn read(bytes: &[u8], options: &Options) -> Result<Loaded, ReadStop> {
    read_in_chunks(bytes, options, CHUNK_BYTES)
}

/// Bytes that a thread takes at a time.
const CHUNK_BYTES: usize = 1 << 20;

fn read_in_chunks(bytes: &[u8], options: &Options, piece: usize) -> Result<Loaded, ReadStop> {
    let threads = workers::thread_count(options.threads);
    let binary = is_binary(bytes);
    let (welded, not_finite, report) = if binary {
        let mut report = DiagnosticSink::binary();
        let facets = binary::facets(bytes, &mut report);
        let welded = weld::weld(facets.len() / FACET, threads, |k| binary::corner(facets, k));
        let not_finite = welded.not_finite(binary::place);
        (welded, not_finite, report)
    } else {
        let mut report = DiagnosticSink::new(bytes);
        let soup = ascii::read(
            bytes,
            threads,
            piece,
            options.origin.position(),
            &mut report,
        );
        let facets = soup.len();
        let welded = weld::weld(facets, threads, |k| soup[k / 3][k % 3].map(f32::to_bits));
        let not_finite = welded.not_finite(|corner| ascii::place(bytes, corner));
        (welded, not_finite, report)
    };
    finish(welded, not_finite, binary, options, report)
}

fn finish(
    mut welded: weld::Welded,
    not_finite: Vec<NotFinite>,
    binary: bool,
    options: &Options,
    mut report: DiagnosticSink,
) -> Result<Loaded, ReadStop> {
    if report.is_clean() {
        let corners = [&welded.corners[..]];
        mesh::report_not_finite(&not_finite, corners.into_iter(), &mut report);
    }
    if !report.is_clean() {
        return Err(ReadStop::of(report));
    }
    let mut joined = MergedMesh {
        vertices: std::mem::take(&mut welded.vertices),
        single: [binary; 3],
        ..MergedMesh::default()
    };
    joined.faces[VERTEX] = welded.corners;
    let scene = mesh::bare_scene(options, &mut MaterialTable::default());
    mesh::finish(scene, joined, options, report)
}

fn fault(offset: usize, length: usize, message: impl Into<String>) -> ParseError {
    ParseError::new(Span { offset, length }, message)
}

#[cfg(test)]
mod tests;
