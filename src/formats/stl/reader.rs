//! The reader: corners of either encoding, welded into a mesh.

use super::{ascii, binary, colors, weld};
use crate::diagnostics::DiagnosticSink;
use crate::folder::Folder;
use crate::memory::MemoryLedger;
use crate::mesh::defaults::GREY;
use crate::mesh::named_runs::{self, NAME_BYTES};
use crate::mesh::vertex_colors::MeshColors;
use crate::mesh::{self, MergedMesh};
use crate::options::ReadOptions;
use crate::origin::ReadStop;
use crate::read_scene::ReadScene;
use crate::text;
use crate::text::workers;
use phalanx_scene::{MaterialTable, Scene, UpAxis};

/// The text of a file; a binary one has none.
pub(crate) fn text(bytes: &[u8]) -> String {
    if is_binary(bytes) { String::new() } else { text::lossy_same_length(bytes) }
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
    // Text with a stray control character has the words of a facet all the same.
    let is_vertex = |word: &&[u8]| word.eq_ignore_ascii_case(b"vertex");
    let has_facet = || head.windows(6).filter(is_vertex).count() >= 3;
    bytes.len() >= binary::HEADER && !head.iter().all(is_text) && !has_facet()
}

/// Reads an STL file.
pub(crate) fn read(
    bytes: &[u8],
    asset_dir: &Folder,
    options: &ReadOptions,
) -> Result<ReadScene, ReadStop> {
    read_in_chunks(bytes, asset_dir.memory(), options, CHUNK_BYTES)
}

/// Bytes that a thread takes at a time.
const CHUNK_BYTES: usize = 1 << 20;

fn read_in_chunks(
    bytes: &[u8],
    memory: &MemoryLedger,
    options: &ReadOptions,
    chunk_bytes: usize,
) -> Result<ReadScene, ReadStop> {
    let threads = workers::thread_count(options.threads);
    if is_binary(bytes) {
        return read_binary(bytes, memory, options, threads);
    }
    let mut report = DiagnosticSink::new(bytes);
    let origin = options.origin.position();
    let (soup, solids) = ascii::read(bytes, threads, chunk_bytes, origin, &mut report);
    let corner = |k: usize| soup[k / 3][k % 3].map(f32::to_bits);
    let span = |corner| ascii::corner_span(bytes, corner);
    let welded = weld::weld(soup.len(), threads, corner).into_mesh(span);
    let joined = welded.triangulated(threads, &mut report);
    let bytes_of_names = solids.len() as u64 * NAME_BYTES;
    memory.take(bytes_of_names, "for the names of the file's solids")?;
    let mut scene = scene_for(&joined, options);
    named_runs::name(&mut scene.names, (bytes, solids), &Vec::new(), soup.len());
    mesh::finish(scene, joined, options, memory, report)
}

fn scene_for(joined: &MergedMesh, options: &ReadOptions) -> Scene {
    let mut scene = mesh::scene_for(&joined.colors, options, &mut MaterialTable::default());
    // As is the custom.
    scene.defaulted.up = UpAxis::Z;
    scene
}

fn read_binary(
    bytes: &[u8],
    memory: &MemoryLedger,
    options: &ReadOptions,
    threads: usize,
) -> Result<ReadScene, ReadStop> {
    let mut report = DiagnosticSink::binary();
    let facets = binary::facets(bytes, memory, &mut report)?;
    let header = &bytes[..bytes.len().min(binary::HEADER - 4)];
    // The material beneath colours is white, unless it is the user's.
    let bare = options.material.is_none().then_some(GREY.kd);
    let colors = match facets.words() {
        Some(words) => colors::read(header, words, bare, memory)?,
        None => MeshColors::default(),
    };
    let welded = weld::weld(facets.len(), threads, |k| binary::corner(&facets.bytes, k));
    let welded = welded.into_mesh(|corner| facets.corner_span(corner));
    let joined = MergedMesh {
        single: [true; 3],
        colors,
        ..welded.triangulated(threads, &mut report)
    };
    let scene = scene_for(&joined, options);
    mesh::finish(scene, joined, options, memory, report)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
