//! The reader: rows of either encoding, joined into a mesh.

use super::header::{Element, Encoding};
use super::pictures::NamedPictures;
use super::plan::ReadPlan;
use super::rows::Body;
use super::{ascii, binary, colors, header, rows, uvs};
use crate::diagnostics::{DiagnosticSink, Span};
use crate::folder::Folder;
use crate::memory::MemoryLedger;
use crate::mesh;
use crate::mesh::faces;
use crate::mesh::vertex_colors::MeshColors;
use crate::options::ReadOptions;
use crate::origin::ReadStop;
use crate::read_scene::ReadScene;
use crate::text;
use crate::text::workers;
use phalanx_scene::MaterialTable;

/// The part of a file that is text.
pub(crate) fn text(bytes: &[u8]) -> String {
    let part = match header::read(bytes) {
        Ok(header) if header.encoding == Encoding::Ascii => bytes,
        _ => &bytes[..header::length(bytes)],
    };
    text::lossy_same_length(part)
}

/// Bytes that a thread takes at a time.
const CHUNK_BYTES: usize = 1 << 20;

/// Reads a PLY file.
pub(crate) fn read(
    bytes: &[u8],
    asset_dir: &Folder,
    options: &ReadOptions,
) -> Result<ReadScene, ReadStop> {
    read_in_chunks(bytes, asset_dir, options, CHUNK_BYTES)
}

fn read_in_chunks(
    bytes: &[u8],
    asset_dir: &Folder,
    options: &ReadOptions,
    chunk_bytes: usize,
) -> Result<ReadScene, ReadStop> {
    let threads = workers::thread_count(options.threads);
    let memory = asset_dir.memory();
    let mut plan = plan(bytes, memory, options)?;
    let ascii = plan.header.encoding == Encoding::Ascii;
    let mut report = if ascii { DiagnosticSink::new(bytes) } else { DiagnosticSink::binary() };
    let mut pictures = NamedPictures::read(bytes, &mut plan, asset_dir, &mut report);
    if !report.is_clean() {
        return Err(ReadStop::of(report));
    }
    memory.take(plan.vertex_bytes_beyond(), "for the file's vertices")?;
    let read = if ascii { ascii::read } else { binary::read };
    let chunks = read(bytes, &plan, threads, chunk_bytes, &mut report);
    std::mem::take(&mut plan.header.remarks).emit(&mut report);
    let Body {
        mut mesh,
        colors,
        face_colors,
        face_uvs,
    } = rows::merge(chunks, threads, &mut report);
    let cutting = faces::cutting_bytes(mesh.faces.iter(), threads);
    memory.lend(cutting, faces::PURPOSE)?;
    if !report.is_clean() {
        return Err(ReadStop::of(report));
    }
    let colors = match (&plan.vertices.color, &plan.face_color) {
        (Some(properties), _) => colors::of_vertices(colors, properties, threads),
        (None, Some(properties)) => colors::of_faces(face_colors, &mesh.faces, properties, threads),
        (None, None) => MeshColors::default(),
    };
    let numbered = plan.face_uvs.picture.is_some();
    let of_faces = uvs::join(face_uvs, &mut mesh.faces, numbered, threads, &mut report);
    mesh.normals_by_vertex = plan.vertices.normal.is_some();
    mesh.uvs_by_vertex = plan.vertices.uv.is_some();
    if !mesh.uvs_by_vertex {
        mesh.vertex_uvs = of_faces.uvs;
    }
    let span = plan.header.elements[plan.vertices.element].span;
    uvs::turn(&mut mesh.vertex_uvs, threads, span, &mut report);
    let mut joined = mesh.triangulated(threads, &mut report);
    let notes = std::mem::take(&mut pictures.notes);
    let scene;
    if pictures.is_empty() {
        scene = mesh::scene_for(&colors, options, &mut MaterialTable::default());
    } else {
        let numbers = &of_faces.pictures;
        (scene, joined.material) = pictures.into_scene(numbers, options, span, &mut report);
    }
    joined.single = plan.vertices.single;
    joined.colors = colors;
    let mut loaded = mesh::finish(scene, joined, options, memory, report)?;
    loaded.notes.extend(notes);
    Ok(loaded)
}

/// The header, and what is read of the rest.
fn plan<'a>(
    bytes: &[u8],
    memory: &'a MemoryLedger,
    options: &ReadOptions,
) -> Result<ReadPlan<'a>, ReadStop> {
    let mut report = DiagnosticSink::new(&bytes[..header::length(bytes)]);
    let plan = match header::read(bytes) {
        Ok(header) if header.elements.iter().any(is_splat) => {
            let message =
                "these are Gaussian splats (`f_dc_0`, `scale_0`, `rot_0`), which are not drawn";
            report.error(Span::START, message);
            None
        }
        Ok(header) => ReadPlan::new(header, options.origin.position(), memory, &mut report),
        Err(errors) => {
            errors.emit(&mut report);
            None
        }
    };
    plan.ok_or_else(|| ReadStop::of(report))
}

/// Returns true for the points of 3D Gaussian splatting (Kerbl et al. 2023), which have no faces.
fn is_splat(element: &Element) -> bool {
    let names: [&[u8]; 3] = [b"f_dc_0", b"scale_0", b"rot_0"];
    names.iter().all(|name| element.number(name).is_some())
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
