//! The reader: corners of either encoding, welded into a mesh.

use super::ascii::mark_length;
use super::binary::{FACET, HEADER};
use super::{ascii, binary, weld};
use crate::formats::defaults::MissingParts;
use crate::formats::diagnostics::DiagnosticSink;
use crate::formats::faces::VERTEX;
use crate::formats::folder::Folder;
use crate::formats::loaded::Loaded;
use crate::formats::mesh::{self, MergedMesh, NotFinite};
use crate::formats::mesh_defaults::BARE;
use crate::formats::options::Options;
use crate::formats::origin::ReadStop;
use crate::formats::text;
use crate::formats::up_axis::UpAxis;
use crate::formats::workers;
use phalanx_scene::MaterialTable;

/// The text of a file; a binary one has none.
pub(crate) fn text(bytes: &[u8]) -> String {
    match is_binary(bytes) {
        true => String::new(),
        false => text::lossy_same_length(bytes),
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

/// Reads an STL file.
pub(crate) fn read(bytes: &[u8], _: &Folder, options: &Options) -> Result<Loaded, ReadStop> {
    read_in_chunks(bytes, options, CHUNK_BYTES)
}

/// Bytes that a thread takes at a time.
const CHUNK_BYTES: usize = 1 << 20;

fn read_in_chunks(bytes: &[u8], options: &Options, chunk_bytes: usize) -> Result<Loaded, ReadStop> {
    let threads = workers::thread_count(options.threads);
    let binary = is_binary(bytes);
    let (welded, not_finite, report) = if binary {
        let mut report = DiagnosticSink::binary();
        let facets = binary::facets(bytes, &mut report);
        let welded = weld::weld(facets.len() / FACET, threads, |k| binary::corner(facets, k));
        let not_finite = welded.not_finite(binary::corner_span);
        (welded, not_finite, report)
    } else {
        let mut report = DiagnosticSink::new(bytes);
        let soup = ascii::read(
            bytes,
            threads,
            chunk_bytes,
            options.origin.position(),
            &mut report,
        );
        let facets = soup.len();
        let welded = weld::weld(facets, threads, |k| soup[k / 3][k % 3].map(f32::to_bits));
        let not_finite = welded.not_finite(|corner| ascii::corner_span(bytes, corner));
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
    let missing = MissingParts {
        up: UpAxis::Z,
        ..BARE
    };
    mesh::finish_with(scene, joined, &missing, options, report)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
