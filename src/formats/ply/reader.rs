//! The reader: rows of either encoding, joined into a mesh.

use super::header::{Element, Encoding};
use super::pictures::NamedPictures;
use super::plan::ReadPlan;
use super::rows::Body;
use super::{ascii, binary, colors, header, uvs};
use crate::diagnostics::{DiagnosticSink, Span};
use crate::faces::{self, Faces, NONE, NORMAL, UV, VERTEX};
use crate::folder::Folder;
use crate::loaded::Loaded;
use crate::memory_budget::MemoryBudget;
use crate::mesh::{self, MergedMesh, NotFinite};
use crate::options::Options;
use crate::origin::ReadStop;
use crate::text;
use crate::vertex_colors::MeshColors;
use crate::workers;

use phalanx_scene::{MaterialTable, MeshMaterial};

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
    options: &Options,
) -> Result<Loaded, ReadStop> {
    read_in_chunks(bytes, asset_dir, options, CHUNK_BYTES)
}

fn read_in_chunks(
    bytes: &[u8],
    asset_dir: &Folder,
    options: &Options,
    chunk_bytes: usize,
) -> Result<Loaded, ReadStop> {
    let threads = workers::thread_count(options.threads);
    let budget = asset_dir.allowance();
    let mut plan = plan(bytes, budget, options)?;
    let mut report = match plan.header.encoding {
        Encoding::Ascii => DiagnosticSink::new(bytes),
        _ => DiagnosticSink::binary(),
    };
    let pictures = NamedPictures::read(bytes, &mut plan, asset_dir, &mut report);
    if !report.is_clean() {
        return Err(ReadStop::of(report));
    }
    plan.made = budget.shared();
    let mut body = match plan.header.encoding {
        Encoding::Ascii => ascii::read(bytes, &plan, threads, chunk_bytes, &mut report),
        _ => binary::read(bytes, &plan, threads, chunk_bytes, &mut report),
    };
    plan.header.ignored.warn(&mut report, |count| match count {
        1 => "this is no line of a header: it is ignored".into(),
        _ => format!("{count} lines, this one first, are none of a header: they are ignored"),
    });
    let cutting = faces::cutting_bytes(body.faces.iter(), threads);
    let needed = plan.made.used().saturating_add(cutting);
    if let Err(message) = budget.lend(needed, faces::purpose) {
        report.error(Span::START, message);
    }
    if report.is_clean() {
        let mut faces: Vec<&mut Faces> = body.faces.iter_mut().collect();
        let lost = std::mem::take(&mut body.not_finite);
        mesh::leave_out_unreachable(lost, &mut body.vertices, &mut faces, &mut report);
    }
    if !report.is_clean() {
        return Err(ReadStop::of(report));
    }
    let read = ReadMesh {
        plan,
        body,
        pictures,
    };
    read.finish(threads, options, report)
}

/// The header, and what is read of the rest.
fn plan(bytes: &[u8], budget: &MemoryBudget, options: &Options) -> Result<ReadPlan, ReadStop> {
    let mut report = DiagnosticSink::new(&bytes[..header::length(bytes)]);
    let plan = match header::read(bytes) {
        Ok(header) if header.elements.iter().any(is_splat) => {
            let message =
                "these are Gaussian splats (`f_dc_0`, `scale_0`, `rot_0`), which are not drawn";
            report.error(Span::START, message);
            None
        }
        Ok(header) => {
            let made = budget.shared();
            ReadPlan::new(header, options.origin.position(), made, &mut report)
        }
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

/// A file's contents, chunk by chunk.
struct ReadMesh {
    plan: ReadPlan,
    body: Body,
    pictures: NamedPictures,
}

impl ReadMesh {
    fn finish(
        self,
        threads: usize,
        options: &Options,
        mut report: DiagnosticSink,
    ) -> Result<Loaded, ReadStop> {
        let ReadMesh {
            plan,
            body,
            mut pictures,
        } = self;
        body.skipped.warn(&mut report, |count| match count {
            1 => "this face of fewer than three corners is skipped".into(),
            _ => format!("{count} faces of fewer than three corners are skipped, this one first"),
        });
        mesh::warn_bad_normals(&body.bad_normals, &mut report);
        let vertices = body.vertices;
        let cut = |mut faces: Faces| {
            faces.triangulate(&vertices);
            faces
        };
        let mut chunks = workers::map(threads, body.faces, cut);
        let colors = match (body.colors, &plan.vertices.color, &plan.face_color) {
            (Some(rgb), Some(properties), _) => colors::of_vertices(rgb, properties, threads),
            (_, _, Some(properties)) => {
                colors::of_faces(body.face_colors, &chunks, properties, threads)
            }
            _ => MeshColors::default(),
        };
        let numbered = plan.face_uvs.picture.is_some();
        let of_faces = uvs::join(body.face_uvs, &mut chunks, numbered, threads, &mut report);
        let mut faces = mesh::merge_faces(threads, chunks);
        if body.normals.is_some() {
            faces[NORMAL] = normal_rows(&faces[VERTEX], &body.bad_normals);
        }
        if body.uvs.is_some() {
            faces[UV] = faces[VERTEX].clone();
        }
        let mut vertex_uvs = body.uvs.unwrap_or(of_faces.uvs);
        let span = plan.header.elements[plan.vertices.element].span;
        uvs::turn(&mut vertex_uvs, threads, span, &mut report);
        let notes = std::mem::take(&mut pictures.notes);
        let (scene, material) = match pictures.is_empty() {
            true => {
                let scene = mesh::scene_for(&colors, options, &mut MaterialTable::default());
                (scene, MeshMaterial::default())
            }
            false => pictures.into_scene(&of_faces.pictures, options),
        };
        let joined = MergedMesh {
            vertices,
            single: plan.vertices.single,
            colors,
            vertex_normals: body.normals.unwrap_or_default(),
            vertex_uvs,
            faces,
            material,
        };
        let mut loaded = mesh::finish(scene, joined, options, report)?;
        loaded.notes.extend(notes);
        Ok(loaded)
    }
}

/// Rows of normals. Normals belong to vertices, so the rows are the corners' own; but a triangle
/// with a bad normal has none.
fn normal_rows(corners: &[[u32; 3]], bad: &[NotFinite]) -> Vec<[u32; 3]> {
    let mut rows = corners.to_vec();
    if !bad.is_empty() {
        let is_bad = |number: &u32| bad.binary_search_by_key(number, |b| b.number).is_ok();
        for row in rows.iter_mut().filter(|row| row.iter().any(is_bad)) {
            *row = [NONE; 3];
        }
    }
    rows
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
