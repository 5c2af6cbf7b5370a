//! The elements and properties of a header that are read.

use super::colors::ColorProperties;
use super::header::{Encoding, Header};
use super::uvs::{self, FaceUvProperties};
use crate::diagnostics::{DiagnosticSink, Span};
use crate::memory::MemoryLedger;
use crate::mesh::faces::{self, NONE};
use glam::DVec3;

/// Number of times that the bytes of a row count for what is made of them: a file counts three
/// times, once of them for itself (see `--max-memory`).
const ROW_TIMES: u64 = 2;

/// The elements and properties that are read.
pub(super) struct ReadPlan<'a> {
    pub(super) header: Header,
    pub(super) vertices: VertexPlan,
    /// Colours of the element `face`, unless vertices have them.
    pub(super) face_color: Option<ColorProperties>,
    /// Texture coordinates of the element `face`, which go before those of vertices.
    pub(super) face_uvs: FaceUvProperties,
    /// Memory for faces that take more than their rows account for.
    pub(super) memory: &'a MemoryLedger,
}

/// Indices of the numbers of a vertex among its properties.
pub(super) struct VertexPlan {
    /// Index of the element.
    pub(super) element: usize,
    pub(super) count: u64,
    pub(super) position: [usize; 3],
    /// The origin, subtracted from positions before they are rounded; 0 where they are single
    /// precision anyway.
    pub(super) origin: DVec3,
    /// True for each component of `position` that is single precision, or less.
    pub(super) single: [bool; 3],
    pub(super) normal: Option<[usize; 3]>,
    pub(super) color: Option<ColorProperties>,
    pub(super) uv: Option<[usize; 2]>,
}

/// Use of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementUse {
    Vertices,
    /// Faces, with the index of the list of corners among the properties.
    Faces(usize),
    Strips(usize),
    Nothing,
}

impl<'a> ReadPlan<'a> {
    /// Returns `None`, and errors in the report, if the header lacks something that a mesh needs.
    pub(super) fn new(
        header: Header,
        origin: DVec3,
        memory: &'a MemoryLedger,
        report: &mut DiagnosticSink,
    ) -> Option<ReadPlan<'a>> {
        let Some(element) = header.elements.iter().position(|e| e.name == b"vertex") else {
            let start = Span::new(0, 3);
            report.error(start, "the header has no element `vertex`");
            return None;
        };
        let vertex = &header.elements[element];
        let Some(position) = vertex.numbers([b"x", b"y", b"z"]) else {
            report.error(vertex.span, "the vertices lack an `x`, `y` or `z`");
            return None;
        };
        if vertex.count >= u64::from(NONE) {
            report.error(vertex.span, "more than 2^32 - 2 vertices");
            return None;
        }
        // Decimals keep their precision, whatever type the header declares.
        let single = position.map(|property| {
            let kind = vertex.properties[property].kind;
            header.encoding != Encoding::Ascii && kind.is_single()
        });
        let vertices = VertexPlan {
            element,
            count: vertex.count,
            position,
            origin: DVec3::from_array([0, 1, 2].map(|k| if single[k] { 0.0 } else { origin[k] })),
            single,
            normal: vertex.numbers([b"nx", b"ny", b"nz"]),
            color: ColorProperties::of(vertex),
            uv: uvs::of_vertex(vertex),
        };
        for faces in header.elements.iter().filter(|e| e.name == b"face") {
            if faces.count > 0 && faces.corners().is_none() {
                let message = "the faces have no list `vertex_indices`";
                report.error(faces.span, message);
                return None;
            }
        }
        let faces = header.elements.iter().find(|e| e.name == b"face");
        Some(ReadPlan {
            face_color: match vertices.color {
                Some(_) => None,
                None => faces.and_then(ColorProperties::of),
            },
            face_uvs: faces.map(FaceUvProperties::of).unwrap_or_default(),
            vertices,
            header,
            memory,
        })
    }

    /// Returns true if vertices or faces have texture coordinates that are read.
    pub(super) fn has_uvs(&self) -> bool {
        self.vertices.uv.is_some() || self.face_uvs.list.is_some()
    }

    /// Omits what only pictures need, if there are none; the pictures' numbers, if there is only
    /// one; and coordinates of vertices, if faces have some.
    pub(super) fn keep_uvs_for(&mut self, pictures: usize) {
        if pictures == 0 || self.face_uvs.list.is_some() {
            self.vertices.uv = None;
        }
        if pictures == 0 {
            self.face_uvs.list = None;
        }
        if pictures < 2 {
            self.face_uvs.picture = None;
        }
    }

    /// Bytes that the columns of vertices take beyond those that their rows account for. Columns of
    /// rows of any length exist twice while they are joined. A colour has up to four numbers.
    pub(super) fn vertex_bytes_beyond(&self) -> u64 {
        let VertexPlan {
            normal, color, uv, ..
        } = self.vertices;
        let [normal, color, uv] = [normal.is_some(), color.is_some(), uv.is_some()].map(u64::from);
        let columns = 4 * (3 + 3 * normal + 4 * color + 2 * uv);
        let element = &self.header.elements[self.vertices.element];
        let (row, copies) = match self.header.encoding {
            // A digit and a blank.
            Encoding::Ascii => (2 * element.properties.len(), 2),
            _ => (element.least_bytes(), 1 + u64::from(element.has_lists())),
        };
        let extra = (copies * columns).saturating_sub(ROW_TIMES * row as u64);
        self.vertices.count.saturating_mul(extra)
    }

    /// Bytes that a face of `corners` corners takes beyond those that its list of `length` bytes
    /// accounts for.
    pub(super) fn bytes_beyond(&self, corners: usize, length: usize) -> u64 {
        // Numbers of a triangle's normals, colours or texture coordinates. The colour itself, and
        // the coordinates of its corners with room to grow, twice while they are joined.
        let of_vertices = [
            self.vertices.normal.is_some(),
            self.vertices.color.is_some(),
            self.vertices.uv.is_some(),
            self.face_uvs.picture.is_some(),
        ];
        let of_face =
            3 * u64::from(self.face_color.is_some()) + 7 * u64::from(self.face_uvs.list.is_some());
        let attributes = of_vertices.map(u64::from).iter().sum::<u64>() + of_face;
        faces::extra_bytes(corners, attributes, ROW_TIMES * length as u64)
    }

    pub(super) fn purpose(&self, index: usize) -> ElementUse {
        let element = &self.header.elements[index];
        match (&element.name[..], element.corners()) {
            _ if index == self.vertices.element => ElementUse::Vertices,
            (b"face", Some(list)) => ElementUse::Faces(list),
            (b"tristrips", Some(list)) => ElementUse::Strips(list),
            _ => ElementUse::Nothing,
        }
    }
}
