//! PLY: a header that describes the elements, then rows as text or as numbers of either byte order.
//!
//! The reader uses the vertices' `x y z` and `nx ny nz`, the faces' `vertex_indices` (or
//! `vertex_index`) and triangle strips. Everything else is passed, including colours and UVs.
//! Counts of the header are trusted only as far as there are bytes. Surplus operands of an ascii
//! row are a warning, unlike elsewhere: files of a widespread program have them.

mod ascii;
mod binary;
mod columns;
mod header;
mod rows;

use super::diagnostics::{DiagnosticSink, Span};
use super::faces::{self, Faces, NONE, NORMAL, VERTEX};
use super::memory_budget::{MemoryBudget, SharedBudget};
use super::mesh::{self, MergedMesh, NotFinite, Occurrences};
use super::origin::ReadStop;
use super::workers;
use super::{Loaded, Options};
use glam::DVec3;
use header::{Encoding, Header};
use phalanx_scene::{MaterialTable, Vec3s};

/// The part of a file that is text.
pub(super) fn text_part(bytes: &[u8]) -> &[u8] {
    match header::read(bytes) {
        Ok(header) if header.encoding == Encoding::Ascii => bytes,
        _ => &bytes[..header::length(bytes)],
    }
}

/// Bytes that a thread takes at a time.
const CHUNK_BYTES: usize = 1 << 20;

/// Reads a PLY file.
pub(super) fn read(
    bytes: &[u8],
    budget: &MemoryBudget,
    options: &Options,
) -> Result<Loaded, ReadStop> {
    read_in_chunks(bytes, budget, options, CHUNK_BYTES)
}

fn read_in_chunks(
    bytes: &[u8],
    budget: &MemoryBudget,
    options: &Options,
    piece: usize,
) -> Result<Loaded, ReadStop> {
    let threads = workers::thread_count(options.threads);
    let mut report = DiagnosticSink::new(&bytes[..header::length(bytes)]);
    let plan = match header::read(bytes) {
        Ok(header) => {
            let made = budget.shared();
            ReadPlan::new(header, options.origin.position(), made, &mut report)
        }
        Err(errors) => {
            errors.emit(&mut report);
            None
        }
    };
    let Some(plan) = plan else {
        return Err(ReadStop::of(report));
    };
    let (body, mut report) = match plan.header.encoding {
        Encoding::Ascii => {
            let mut report = DiagnosticSink::new(bytes);
            let body = ascii::read(bytes, &plan, threads, piece, &mut report);
            (body, report)
        }
        _ => {
            let mut report = DiagnosticSink::binary();
            let body = binary::read(bytes, &plan, threads, piece, &mut report);
            (body, report)
        }
    };
    let cutting = faces::cutting_bytes(body.faces.iter(), threads);
    let needed = plan.made.used().saturating_add(cutting);
    if let Err(message) = budget.lend(needed, faces::purpose) {
        report.error(Span::START, message);
    }
    if report.is_clean() {
        let corners = body.faces.iter().map(|f| &f.columns[VERTEX][..]);
        mesh::report_not_finite(&body.not_finite, corners, &mut report);
    }
    if !report.is_clean() {
        return Err(ReadStop::of(report));
    }
    let mut loaded = finish(body, plan.vertices.single, threads, options, report)?;
    if plan.colors {
        let note = "the file's colours are not used (see --material)";
        loaded.notes.push(note.into());
    }
    Ok(loaded)
}

/// The elements and properties that are read.
struct ReadPlan {
    header: Header,
    vertices: VertexPlan,
    /// True if vertices have colours.
    colors: bool,
    /// Memory for faces that take more than their rows account for.
    made: SharedBudget,
}

/// Indices of the numbers of a vertex among its properties.
struct VertexPlan {
    /// Index of the element.
    element: usize,
    count: u64,
    position: [usize; 3],
    /// The origin, subtracted from positions before they are rounded; 0 where they are single
    /// precision anyway.
    origin: DVec3,
    /// True for each component of `position` that is single precision, or less.
    single: [bool; 3],
    normal: Option<[usize; 3]>,
}

/// Use of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ElementUse {
    Vertices,
    /// Faces, with the index of the list of corners among the properties.
    Faces(usize),
    Strips(usize),
    Nothing,
}

impl ReadPlan {
    /// Returns `None`, and errors in the report, if the header lacks something that a mesh needs.
    fn new(
        header: Header,
        origin: DVec3,
        made: SharedBudget,
        report: &mut DiagnosticSink,
    ) -> Option<ReadPlan> {
        let Some(element) = header.elements.iter().position(|e| e.name == b"vertex") else {
            let start = Span {
                offset: 0,
                length: 3,
            };
            report.error(start, "the header has no element `vertex`");
            return None;
        };
        let vertex = &header.elements[element];
        let three = |names: [&[u8]; 3]| {
            let [x, y, z] = names.map(|name| vertex.number(name));
            Some([x?, y?, z?])
        };
        let Some(place) = three([b"x", b"y", b"z"]) else {
            report.error(vertex.place, "the vertices lack an `x`, `y` or `z`");
            return None;
        };
        if vertex.count >= u64::from(NONE) {
            report.error(vertex.place, "more than 2^32 - 2 vertices");
            return None;
        }
        // Decimals keep their precision, whatever type the header declares.
        let single = place.map(|property| {
            let kind = vertex.properties[property].kind;
            header.encoding != Encoding::Ascii && kind.is_single()
        });
        let vertices = VertexPlan {
            element,
            count: vertex.count,
            position: place,
            origin: DVec3::from_array([0, 1, 2].map(|k| if single[k] { 0.0 } else { origin[k] })),
            single,
            normal: three([b"nx", b"ny", b"nz"]),
        };
        for faces in header.elements.iter().filter(|e| e.name == b"face") {
            if faces.count > 0 && faces.corners().is_none() {
                let message = "the faces have no list `vertex_indices` of whole numbers";
                report.error(faces.place, message);
                return None;
            }
        }
        Some(ReadPlan {
            colors: vertex.number(b"red").is_some(),
            vertices,
            header,
            made,
        })
    }

    /// Bytes that a face of `corners` corners takes beyond those that its list of `length` bytes
    /// accounts for. A file counts six times, once of them for itself (see `--max-memory`).
    fn bytes_beyond(&self, corners: usize, length: usize) -> u64 {
        let attributes = u64::from(self.vertices.normal.is_some());
        faces::extra_bytes(corners, attributes, 5 * length as u64)
    }

    fn purpose(&self, index: usize) -> ElementUse {
        let element = &self.header.elements[index];
        match (&element.name[..], element.corners()) {
            _ if index == self.vertices.element => ElementUse::Vertices,
            (b"face", Some(list)) => ElementUse::Faces(list),
            (b"tristrips", Some(list)) => ElementUse::Strips(list),
            _ => ElementUse::Nothing,
        }
    }
}

/// The result of the rows.
#[derive(Default)]
struct Body {
    vertices: Vec3s,
    normals: Option<Vec3s>,
    /// Faces, in chunks.
    faces: Vec<Faces>,
    /// Vertices that are not finite, ascending; their rows are zero.
    not_finite: Vec<NotFinite>,
    /// Normals that are zero or not finite, ascending.
    bad_normals: Vec<NotFinite>,
    /// Faces of fewer than three corners.
    skipped: Occurrences,
}

fn finish(
    body: Body,
    single: [bool; 3],
    threads: usize,
    options: &Options,
    mut report: DiagnosticSink,
) -> Result<Loaded, ReadStop> {
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
    let pieces = workers::map(threads, body.faces, cut);
    let mut faces = mesh::merge_faces(threads, pieces);
    if body.normals.is_some() {
        faces[NORMAL] = normal_rows(&faces[VERTEX], &body.bad_normals);
    }
    let joined = MergedMesh {
        vertices,
        single,
        vertex_normals: body.normals.unwrap_or_default(),
        faces,
        ..MergedMesh::default()
    };
    let scene = mesh::bare_scene(options, &mut MaterialTable::default());
    mesh::finish(scene, joined, options, report)
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
mod tests;
