//! Rows of either encoding: their result, their errors, and the conversion of faces.

use super::colors::FaceColors;
use super::header::Element;
use super::uvs::FaceUvs;
use crate::diagnostics::{ChunkRemarks, DiagnosticSink, ParseError, Span, quoted_bytes};
use crate::mesh::chunk::{MeshChunk, merge as merge_chunks};
use crate::mesh::{self, PolygonMesh};
use phalanx_scene::Vec3s;

/// Contents of some rows.
#[derive(Default)]
pub(super) struct PlyChunk {
    /// The vertices and faces, with texture coordinates as in the file.
    pub(super) mesh: MeshChunk,
    /// Colours of vertices, as in the file.
    pub(super) colors: [Vec<f32>; 3],
    pub(super) face_colors: FaceColors,
    pub(super) face_uvs: FaceUvs,
    /// The first line after the last row, if it is in this chunk.
    pub(super) surplus: Option<Span>,
    /// True if a row has more operands than the header announces.
    pub(super) surplus_operands: bool,
    pub(super) remarks: ChunkRemarks,
}

/// All rows.
pub(super) struct Body {
    pub(super) mesh: PolygonMesh,
    /// Colours of vertices, as in the file.
    pub(super) colors: Vec3s,
    /// Colours of the faces, in the same chunks.
    pub(super) face_colors: Vec<FaceColors>,
    /// Texture coordinates of the faces, in the same chunks.
    pub(super) face_uvs: Vec<FaceUvs>,
}

/// A face as its row has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceRow<'a> {
    pub(super) corners: &'a [i64],
    /// The colour, if faces have one.
    pub(super) color: Option<[f32; 3]>,
    /// Texture coordinates of the corners, if faces have them.
    pub(super) uvs: Option<&'a [f32]>,
    /// The number of the picture, if faces have one.
    pub(super) picture: Option<f32>,
}

impl PlyChunk {
    /// Adds a face over `vertices` vertices, whose number of corners has been checked. It is an
    /// error if a corner is not one of the vertices.
    pub(super) fn add_face(
        &mut self,
        face: FaceRow,
        vertices: u64,
        span: Span,
    ) -> Result<(), ParseError> {
        let corners = face.corners;
        check_range(corners.iter().copied(), vertices, span)?;
        let start = self.mesh.faces.len();
        match (corners, face.uvs) {
            ([] | [_] | [_, _], _) => {
                self.remarks.warn(
                    span,
                    "this face of fewer than three corners is skipped",
                    "faces of fewer than three corners are skipped, this one first",
                );
                return Ok(());
            }
            (_, Some(uvs)) => {
                self.note_incomplete(corners, uvs, span);
                self.face_uvs.add(corners, uvs, &mut self.mesh.faces);
            }
            (&[a, b, c], _) => self.mesh.faces.add_plain([a as u32, b as u32, c as u32]),
            _ => self.mesh.faces.add_plain_polygon(corners),
        }
        if let Some(rgb) = face.color {
            self.face_colors.add(rgb, self.mesh.faces.len());
        }
        if let Some(picture) = face.picture {
            self.face_uvs
                .set_picture(picture, start, self.mesh.faces.len());
        }
        Ok(())
    }

    /// Warns of a face with another number of coordinates than corners need. None at all are no
    /// fault.
    fn note_incomplete(&mut self, corners: &[i64], uvs: &[f32], span: Span) {
        if !uvs.is_empty() && uvs.len() != 2 * corners.len() {
            self.remarks.warn(
                span,
                "this face has not two texture coordinates for each corner: it is shown without a picture",
                "faces, this one first, have not two texture coordinates for each corner: they are shown without a picture",
            );
        }
    }

    /// Adds the triangles of strips: every other one is turned around, and -1 begins a new strip.
    pub(super) fn add_strips(
        &mut self,
        corners: &[i64],
        vertices: u64,
        span: Span,
    ) -> Result<(), ParseError> {
        check_range(corners.iter().copied().filter(|&c| c != -1), vertices, span)?;
        for strip in corners.split(|&corner| corner < 0) {
            for (k, t) in strip.windows(3).enumerate() {
                let [a, b, c] = [t[0] as u32, t[1] as u32, t[2] as u32];
                let turned = k % 2 == 1;
                self.mesh
                    .faces
                    .add_plain(if turned { [b, a, c] } else { [a, b, c] });
            }
        }
        Ok(())
    }
}

/// Joins chunks, and reports their errors.
pub(super) fn merge(chunks: Vec<PlyChunk>, threads: usize, report: &mut DiagnosticSink) -> Body {
    let (mut meshes, mut colors) = (Vec::new(), Vec::new());
    let (mut face_colors, mut face_uvs) = (Vec::new(), Vec::new());
    let (mut surplus, mut surplus_operands) = (None, false);
    let mut remarks = ChunkRemarks::default();
    for chunk in chunks {
        remarks.merge(chunk.remarks);
        meshes.push(chunk.mesh);
        colors.push(chunk.colors);
        face_colors.push(chunk.face_colors);
        face_uvs.push(chunk.face_uvs);
        surplus = surplus.or(chunk.surplus);
        surplus_operands |= chunk.surplus_operands;
    }
    if surplus_operands {
        // MeshLab writes colours of corners where it announces those of faces.
        face_colors.clear();
    }
    remarks.emit(report);
    if let Some(span) = surplus {
        report.warning(span, "this line and what follows the last row is ignored");
    }
    let [x, y, z] = mesh::merge_floats(threads, colors);
    Body {
        mesh: merge_chunks(meshes, threads),
        colors: Vec3s { x, y, z },
        face_colors,
        face_uvs,
    }
}

fn check_range(
    mut corners: impl Iterator<Item = i64>,
    vertices: u64,
    span: Span,
) -> Result<(), ParseError> {
    let wrong = corners.find(|&c| c < 0 || c as u64 >= vertices);
    wrong.map_or(Ok(()), |corner| Err(out_of_range(corner, vertices, span)))
}

pub(super) fn out_of_range(corner: i64, vertices: u64, span: Span) -> ParseError {
    let message = format!("vertex {corner} is out of range: there are {vertices}, numbered from 0");
    ParseError::new(span, message)
}

/// The error of fewer rows than the header declares; `row` counts from 0.
pub(super) fn too_short(element: &Element, row: u64, end: usize) -> ParseError {
    let (name, count) = (quoted_bytes(&element.name), element.count);
    let span = Span::at(end);
    ParseError::new(
        span,
        format!("the file ends after {row} of the {count} rows of {name}"),
    )
}
