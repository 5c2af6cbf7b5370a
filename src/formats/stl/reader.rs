//! The reader: corners of either encoding, welded into a mesh.

use super::{ascii, binary, colors, weld};
use crate::defaults::MissingParts;
use crate::diagnostics::{DiagnosticSink, Span};
use crate::faces::{Faces, VERTEX};
use crate::folder::Folder;
use crate::loaded::Loaded;
use crate::memory_budget::MemoryBudget;
use crate::mesh::{self, MergedMesh, NotFinite};
use crate::mesh_defaults::BARE;
use crate::options::Options;
use crate::origin::ReadStop;
use crate::text;
use crate::vertex_colors::MeshColors;
use crate::workers;
use phalanx_scene::{MaterialTable, UpAxis};

/// The text of a file; a binary one has none.
pub(crate) fn text(bytes: &[u8]) -> String {
    match is_binary(bytes) {
        true => String::new(),
        false => text::lossy_same_length(bytes),
    }
}

/// Bytes at the beginning of a file that tell text from a binary file.
const HEAD: usize = 4096;

/// Returns true if a file is binary. Its length decides, since many binary files begin with `solid`
/// like text. If the length does not match, bytes that do not occur in text decide.
fn is_binary(bytes: &[u8]) -> bool {
    if binary::is_exact(bytes) {
        return true;
    }
    // Text may be followed by zeros, or by the end of a text file of old systems.
    let filler = |&b: &u8| b == 0 || b == 0x1a || b.is_ascii_whitespace();
    let end = bytes.iter().rposition(|b| !filler(b));
    let head = &bytes[..end.map_or(0, |last| last + 1).min(HEAD)];
    let is_text = |&b: &u8| b >= b' ' || b.is_ascii_whitespace() || b == 0x0b;
    bytes.len() >= binary::HEADER && !head.iter().all(is_text)
}

/// Reads an STL file.
pub(crate) fn read(
    bytes: &[u8],
    asset_dir: &Folder,
    options: &Options,
) -> Result<Loaded, ReadStop> {
    read_in_chunks(bytes, asset_dir.allowance(), options, CHUNK_BYTES)
}

/// Bytes that a thread takes at a time.
const CHUNK_BYTES: usize = 1 << 20;

fn read_in_chunks(
    bytes: &[u8],
    budget: &MemoryBudget,
    options: &Options,
    chunk_bytes: usize,
) -> Result<Loaded, ReadStop> {
    let threads = workers::thread_count(options.threads);
    match is_binary(bytes) {
        true => read_binary(bytes, budget, options, threads),
        false => {
            let mut report = DiagnosticSink::new(bytes);
            let origin = options.origin.position();
            let soup = ascii::read(bytes, threads, chunk_bytes, origin, &mut report);
            let corner = |k: usize| soup[k / 3][k % 3].map(f32::to_bits);
            let welded = weld::weld(soup.len(), threads, corner);
            let not_finite = welded.not_finite(|corner| ascii::corner_span(bytes, corner));
            let joined = MergedMesh::default();
            finish(welded, not_finite, joined, options, report)
        }
    }
}

fn read_binary(
    bytes: &[u8],
    budget: &MemoryBudget,
    options: &Options,
    threads: usize,
) -> Result<Loaded, ReadStop> {
    let mut report = DiagnosticSink::binary();
    let facets = binary::facets(bytes, budget, &mut report);
    let words = facets.words();
    let header = &bytes[..bytes.len().min(binary::HEADER - 4)];
    let colors = words.map_or(Ok(MeshColors::default()), |words| {
        colors::read(header, words, budget)
    });
    let colors = colors.unwrap_or_else(|message| {
        report.error(Span::START, message);
        MeshColors::default()
    });
    let welded = weld::weld(facets.len(), threads, |k| binary::corner(&facets.bytes, k));
    let not_finite = welded.not_finite(|corner| facets.corner_span(corner));
    let joined = MergedMesh {
        single: [true; 3],
        colors,
        ..MergedMesh::default()
    };
    finish(welded, not_finite, joined, options, report)
}

fn finish(
    mut welded: weld::Welded,
    not_finite: Vec<NotFinite>,
    mut joined: MergedMesh,
    options: &Options,
    mut report: DiagnosticSink,
) -> Result<Loaded, ReadStop> {
    let mut faces = Faces::default();
    faces.columns[VERTEX] = std::mem::take(&mut welded.corners);
    if report.is_clean() {
        let vertices = &mut welded.vertices;
        mesh::leave_out_unreachable(not_finite, vertices, &mut [&mut faces], &mut report);
    }
    if !report.is_clean() {
        return Err(ReadStop::of(report));
    }
    joined.vertices = welded.vertices;
    joined.faces = faces.columns;
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
