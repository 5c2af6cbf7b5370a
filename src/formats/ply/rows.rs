//! Rows of either encoding: their result, their errors, and the conversion of faces.

use super::colors::FaceColors;
use super::header::Element;
use super::uvs::FaceUvs;
use crate::diagnostics::Span;
use crate::faces::{Faces, MAX_CORNERS};
use crate::mesh::{self, NotFinite, Occurrences, ParseError};
use phalanx_scene::{Vec2s, Vec3s};

/// The result of the rows.
#[derive(Default)]
pub(super) struct Body {
    pub(super) vertices: Vec3s,
    pub(super) normals: Option<Vec3s>,
    /// Colours of vertices, as in the file.
    pub(super) colors: Option<Vec3s>,
    /// Texture coordinates of vertices, as in the file.
    pub(super) uvs: Option<Vec2s>,
    /// Faces, in chunks.
    pub(super) faces: Vec<Faces>,
    /// Colours of the faces, in the same chunks.
    pub(super) face_colors: Vec<FaceColors>,
    /// Texture coordinates of the faces, in the same chunks.
    pub(super) face_uvs: Vec<FaceUvs>,
    /// Vertices that are out of reach, ascending.
    pub(super) not_finite: Vec<NotFinite>,
    /// Normals that are zero or not finite, ascending.
    pub(super) bad_normals: Vec<NotFinite>,
    /// Faces of fewer than three corners.
    pub(super) skipped: Occurrences,
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

/// Destination of faces.
#[derive(Debug, Default)]
pub(super) struct FaceSink {
    pub(super) faces: Faces,
    pub(super) colors: FaceColors,
    pub(super) uvs: FaceUvs,
    /// Faces of fewer than three corners.
    pub(super) skipped: Occurrences,
    scratch: Vec<u32>,
}

impl FaceSink {
    /// Adds a face over `vertices` vertices, which has no more than [`MAX_CORNERS`] corners. It is
    /// an error if a corner is not one of the vertices.
    pub(super) fn add(
        &mut self,
        face: FaceRow,
        vertices: u64,
        span: Span,
    ) -> Result<(), ParseError> {
        let corners = face.corners;
        check_range(corners.iter().copied(), vertices, span)?;
        let start = self.faces.len();
        match (corners, face.uvs) {
            ([] | [_] | [_, _], _) => {
                self.skipped.add(span);
                return Ok(());
            }
            (_, Some(uvs)) => self.uvs.add(corners, uvs, span, &mut self.faces),
            (&[a, b, c], _) => self.faces.add_plain([a as u32, b as u32, c as u32]),
            _ => {
                self.scratch.clear();
                self.scratch.extend(corners.iter().map(|&c| c as u32));
                self.faces.add_plain_polygon(&self.scratch);
            }
        }
        if let Some(rgb) = face.color {
            self.colors.add(rgb, self.faces.len());
        }
        if let Some(picture) = face.picture {
            self.uvs.set_picture(picture, start, self.faces.len());
        }
        Ok(())
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
                self.faces
                    .add_plain(if turned { [b, a, c] } else { [a, b, c] });
            }
        }
        Ok(())
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

/// Refuses a face of too many corners, before they are collected.
pub(super) fn check_corners(count: usize, span: Span) -> Result<(), ParseError> {
    match count > MAX_CORNERS {
        true => {
            let message = format!("a face of {count} corners: at most {MAX_CORNERS}");
            Err(ParseError::new(span, message))
        }
        false => Ok(()),
    }
}

/// The error of fewer rows than the header declares; `row` counts from 0.
pub(super) fn too_short(element: &Element, row: u64, end: usize) -> ParseError {
    let (name, count) = (element.quoted_name(), element.count);
    let span = Span::at(end);
    ParseError::new(
        span,
        format!("the file ends after {row} of the {count} rows of {name}"),
    )
}

/// Replaces a position that is not finite, and notes one that is out of reach.
pub(super) fn checked_position(
    row: [f32; 3],
    number: u32,
    span: Span,
    bad: &mut Vec<NotFinite>,
) -> [f32; 3] {
    if mesh::is_in_reach(row) {
        return row;
    }
    bad.push(NotFinite { number, span });
    mesh::stored(row)
}

/// Replaces a normal that is zero or not finite, and notes it.
pub(super) fn checked_normal(
    row: [f32; 3],
    number: u32,
    span: Span,
    bad: &mut Vec<NotFinite>,
) -> [f32; 3] {
    if row.iter().all(|c| c.is_finite()) && row != [0.0; 3] {
        return row;
    }
    bad.push(NotFinite { number, span });
    [0.0, 0.0, 1.0]
}
