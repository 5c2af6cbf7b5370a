//! The reader: chunks of the text, joined into a mesh.

use super::chunk::{IndexLimits, ObjChunk};
use super::{chunk, colors, materials, remarks, smoothing, uv_baking};
use crate::diagnostics::{DiagnosticSink, Span};
use crate::folder::Folder;
use crate::memory::MemoryLedger;
use crate::mesh::faces::{self, NORMAL, VERTEX};
use crate::mesh::named_runs::{self, NAME_BYTES};
use crate::mesh::vertex_colors::{COLOR_ROW_BYTES, MeshColors};
use crate::mesh::{self, NotFinite, PolygonMesh};
use crate::options::ReadOptions;
use crate::origin::{self, Origin, ReadStop};
use crate::read_scene::ReadScene;
use crate::text::HEAD_BYTES;
use crate::text::workers;
use glam::DVec3;
use phalanx_scene::MaterialTable;
use std::ops::Range;

/// Bytes of a chunk: large enough to be worth a task, small enough to keep all threads busy to the
/// end.
const CHUNK_BYTES: usize = 1 << 18;

/// Reads an OBJ file; the material files and textures that it names are looked for beside it.
pub(crate) fn read(
    bytes: &[u8],
    asset_dir: &Folder,
    options: &ReadOptions,
) -> Result<ReadScene, ReadStop> {
    let read = read_in_chunks(bytes, asset_dir, options, CHUNK_BYTES);
    match (read, first_nul(bytes)) {
        // One error instead of many about lines that are none.
        (Err(ReadStop::Wrong(_)), Some(nul)) => {
            let message = "this is not text: a Windows object file?";
            Err(DiagnosticSink::binary()
                .refuse(Span::at(nul), message)
                .into())
        }
        (read, _) => read,
    }
}

/// The first NUL at the beginning of a file, if it has more than those that pad it.
fn first_nul(bytes: &[u8]) -> Option<usize> {
    let nul = memchr::memchr(0, &bytes[..bytes.len().min(HEAD_BYTES)])?;
    let padding = bytes[nul..].iter().all(|&byte| byte <= b' ');
    (!padding).then_some(nul)
}

fn read_in_chunks(
    bytes: &[u8],
    asset_dir: &Folder,
    options: &ReadOptions,
    chunk_bytes: usize,
) -> Result<ReadScene, ReadStop> {
    let threads = workers::thread_count(options.threads);
    let mut report = DiagnosticSink::new(bytes);
    if bytes.trim_ascii().is_empty() {
        return Err(report.refuse(Span::START, "the file is empty").into());
    }
    let moved = options.origin.offset();
    let memory = asset_dir.memory();
    let mut chunks = read_chunks(bytes, threads, (chunk_bytes, moved), memory);
    let total = limits_of(&chunks)
        .first()
        .map_or([0; 3], |limits| limits.total);
    remarks::emit(bytes, &mut chunks, total, &mut report);
    let cutting = faces::cutting_bytes(chunks.iter().map(|chunk| &chunk.mesh.faces), threads);
    memory.lend(cutting, faces::PURPOSE)?;
    if !report.is_clean() {
        return Err(ReadStop::of(report));
    }
    let mut table = MaterialTable::default();
    let (mesh, colors, changes) = merge(chunks, threads);
    let mut joined = mesh.triangulated(threads, &mut report);
    joined.colors = colors;
    let mut scene = mesh::scene_for(&joined.colors, options, &mut table);
    scene.emission_lights = true;
    // Checked before materials and textures are read, which would be for nothing.
    if options.origin == Origin::Auto
        && let Some(far) = origin::of_triangles(&joined.vertices, &joined.faces[VERTEX])
    {
        return Err(ReadStop::Far(far));
    }
    if !joined.colors.rgb.is_empty() {
        let rows = joined.faces[VERTEX].len() as u64 * COLOR_ROW_BYTES;
        memory.take(rows, "for the colours of the file's vertices")?;
    }
    let mut notes = Vec::new();
    if report.is_clean() {
        let triangles = joined.faces[VERTEX].len();
        let named = (changes.objects.len() + changes.materials.len()) as u64;
        memory.take(named * NAME_BYTES, "for the names of the file's objects")?;
        let library =
            materials::MaterialLibrary::new(bytes, asset_dir, &changes.libraries, &mut report);
        let (materials, material_names, on_textures) = library.resolve(
            changes.materials,
            triangles,
            &mut scene,
            &mut table,
            &mut report,
        );
        joined.material = materials.rows;
        notes = on_textures;
        let objects = (bytes, changes.objects);
        named_runs::name(&mut scene.names, objects, &material_names, triangles);
        remarks::warn_unplaced(&scene, &joined, &mut report);
        uv_baking::bake(&mut joined, &materials.transformed, memory)?;
        smoothing::smooth(&mut joined, &changes.smoothing, memory)?;
    }
    let mut loaded = mesh::finish(scene, joined, options, memory, report)?;
    loaded.notes.extend(notes);
    Ok(loaded)
}

/// Reads all chunks. Faces for which there is no memory are left out.
fn read_chunks(
    bytes: &[u8],
    threads: usize,
    (size, moved): (usize, Option<DVec3>),
    memory: &MemoryLedger,
) -> Vec<ObjChunk> {
    let ranges = workers::chunk_ranges(0..bytes.len(), size, |offset| line_start(bytes, offset));
    let first = ranges
        .iter()
        .map(|range| (range.clone(), IndexLimits::UNKNOWN));
    let read = |memory: &MemoryLedger, (range, limits): (Range<usize>, IndexLimits)| {
        let text = &bytes[..range.end];
        chunk::read(text, range.start, limits, moved, memory.share())
    };
    let chunks = workers::map(threads, first.collect(), |part| read(memory, part));
    let limits = limits_of(&chunks);
    let is_within = |(chunk, limits): (&ObjChunk, &IndexLimits)| {
        let ends = |k: usize| i64::from(chunk.highest[k]) <= limits.total[k];
        let begins = |k: usize| limits.before[k] + chunk.lowest[k] >= 0;
        !chunk.remarks.has_errors() && (0..3).all(|k| ends(k) && begins(k))
    };
    // No second reading if there is not enough memory either.
    if memory.is_over() || chunks.iter().zip(&limits).all(is_within) {
        return chunks;
    }
    drop(chunks);
    // The first reading has checked that there is memory for these.
    let unlimited = MemoryLedger::of(None);
    let parts = ranges.into_iter().zip(limits).collect();
    workers::map(threads, parts, |part| read(&unlimited, part))
}

/// Start of a statement at or after an offset: behind a line end that no `\` continues. Blanks may
/// stand behind the `\`.
fn line_start(bytes: &[u8], offset: usize) -> usize {
    let mut start = offset;
    while let Some(end) = memchr::memchr(b'\n', &bytes[start..]) {
        start += end + 1;
        let mut line = bytes[..start - 1].iter();
        if line.rfind(|&&b| b > b' ' || b == b'\n') != Some(&b'\\') {
            return start;
        }
    }
    bytes.len()
}

/// Limits of the numbers to which each chunk may refer.
fn limits_of(chunks: &[ObjChunk]) -> Vec<IndexLimits> {
    let mut total = [0; 3];
    let before = chunks.iter().map(|chunk| {
        let before = total;
        for (sum, count) in total.iter_mut().zip(chunk.counts()) {
            *sum += count as i64;
        }
        before
    });
    let before: Vec<[i64; 3]> = before.collect();
    let limits = |before| IndexLimits { before, total };
    before.into_iter().map(limits).collect()
}

/// Statements that hold for the triangles after them, by the triangle that they begin at.
#[derive(Default)]
struct StateChanges {
    /// Spans of the materials' names.
    materials: Vec<(usize, Span)>,
    /// Numbers of smoothing groups, 0 for none.
    smoothing: Vec<(usize, u32)>,
    /// Spans of the objects' names.
    objects: Vec<(usize, Span)>,
    /// The operands of each `mtllib`.
    libraries: Vec<Span>,
}

/// Joins the chunks: the columns, the colours, and the changes of state.
fn merge(mut chunks: Vec<ObjChunk>, threads: usize) -> (PolygonMesh, MeshColors, StateChanges) {
    let colors = chunks.iter_mut().map(|chunk| {
        let vertices = chunk.counts()[VERTEX];
        (vertices, std::mem::take(&mut chunk.colors))
    });
    let colors = colors::merge(colors.collect(), threads);
    let limits = limits_of(&chunks);
    let (mut meshes, mut triangles) = (Vec::new(), 0);
    let mut changes = StateChanges::default();
    let mut in_object = false;
    for (chunk, IndexLimits { before, .. }) in chunks.into_iter().zip(limits) {
        let mut mesh = chunk.mesh;
        shift(&mut mesh.not_finite, before[VERTEX]);
        shift(&mut mesh.bad_normals, before[NORMAL]);
        mesh.faces.resolve(before.map(|count| count as u32));
        for (first, name) in chunk.switches {
            named_runs::change(&mut changes.materials, triangles + first, name);
        }
        let groups = chunk.smoothing.iter();
        (changes.smoothing).extend(groups.map(|&(first, group)| (triangles + first, group)));
        for (first, (name, is_object)) in chunk.objects {
            if is_object || !in_object {
                named_runs::change(&mut changes.objects, triangles + first, name);
            }
            in_object |= is_object;
        }
        changes.libraries.extend(chunk.libraries);
        triangles += mesh.faces.len();
        meshes.push(mesh);
    }
    (mesh::chunk::merge(meshes, threads), colors, changes)
}

fn shift(rows: &mut [NotFinite], before: i64) {
    rows.iter_mut().for_each(|row| row.number += before as u32);
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
