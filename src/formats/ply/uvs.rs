//! Texture coordinates: those of vertices share the vertices' numbers, those of faces' corners have
//! numbers of their own (MeshLab).
//!
//! A file's v is 0 at the bottom of the picture, the scene's at its top.

use super::header::{Element, PropertyKind};
use crate::diagnostics::{DiagnosticSink, Span, counted};
use crate::mesh;
use crate::mesh::faces::{FaceCorner, Faces, MAX_CORNERS, NONE, UV};
use crate::text::workers;
use phalanx_scene::Vec2s;

/// Names of the properties of a vertex.
const VERTEX_NAMES: [[&[u8]; 2]; 5] = [
    [b"s", b"t"],
    [b"u", b"v"],
    [b"texture_u", b"texture_v"],
    [b"texture_s", b"texture_t"],
    [b"tx", b"ty"],
];

/// Names of the list of a face: two numbers for each corner.
const FACE_NAMES: [&[u8]; 3] = [b"texcoord", b"texture_coordinates", b"t"];

/// The number of a face's picture, if it has none.
pub(super) const NO_PICTURE: u32 = u32::MAX;

/// Most coordinates of a face that are read: more than any has.
pub(super) const MAX_UVS: usize = 2 * MAX_CORNERS + 1;

/// The two numbers of a vertex, as indices of its properties.
pub(super) fn of_vertex(vertex: &Element) -> Option<[usize; 2]> {
    let mut names = VERTEX_NAMES.into_iter();
    names.find_map(|names| vertex.numbers(names))
}

/// The properties of faces that say where on a picture they are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FaceUvProperties {
    /// The list of the corners' coordinates.
    pub(super) list: Option<usize>,
    /// The number of the picture.
    pub(super) picture: Option<usize>,
}

impl FaceUvProperties {
    pub(super) fn of(face: &Element) -> FaceUvProperties {
        let list = |name: &&[u8]| {
            let is_list = |kind| matches!(kind, PropertyKind::List { .. });
            let mut properties = face.properties.iter();
            properties.position(|p| p.name == **name && is_list(p.kind))
        };
        FaceUvProperties {
            list: FACE_NAMES.iter().find_map(list),
            picture: face.number(b"texnumber"),
        }
    }
}

/// Texture coordinates of faces, in a chunk.
#[derive(Debug, Default)]
pub(super) struct FaceUvs {
    /// Coordinates as in the file. [`Faces`] has their numbers, which count within the chunk.
    columns: [Vec<f32>; 2],
    /// The number of the picture of each triangle; those at the end may be missing.
    pictures: Vec<u32>,
    scratch: Vec<FaceCorner>,
}

impl FaceUvs {
    /// Adds a face of at least three corners and its coordinates, if they are complete.
    pub(super) fn add(&mut self, corners: &[i64], uvs: &[f32], faces: &mut Faces) {
        let complete = uvs.len() == 2 * corners.len();
        let first = self.columns[0].len() as u32;
        self.scratch.clear();
        let corner = |(uv, &corner): (u32, &i64)| FaceCorner {
            numbers: [corner as u32, if complete { uv } else { NONE }, NONE],
            relative: 0,
        };
        self.scratch.extend((first..).zip(corners).map(corner));
        faces.add(&self.scratch);
        if complete {
            for uv in uvs.chunks_exact(2) {
                self.columns[0].push(uv[0]);
                self.columns[1].push(uv[1]);
            }
        }
    }

    /// Sets the picture of the last triangles, from the `start`-th up to the `end`-th.
    pub(super) fn set_picture(&mut self, picture: f32, start: usize, end: usize) {
        // Negative numbers stand for none.
        let number = if picture >= 0.0 { picture as u32 } else { NO_PICTURE };
        self.pictures.resize(start, NO_PICTURE);
        self.pictures.resize(end, number);
    }
}

/// Texture coordinates of faces, joined.
#[derive(Default)]
pub(super) struct JoinedFaceUvs {
    pub(super) uvs: Vec2s,
    /// The number of the picture of each triangle, if faces say it.
    pub(super) pictures: Vec<u32>,
}

/// Joins the chunks of `faces`, whose numbers become those of the whole.
pub(super) fn join(
    chunks: Vec<FaceUvs>,
    faces: &mut [Faces],
    numbered: bool,
    threads: usize,
    report: &mut DiagnosticSink,
) -> JoinedFaceUvs {
    let mut joined = JoinedFaceUvs::default();
    let mut columns = Vec::new();
    let (mut before, mut triangles) = (0u64, 0);
    for (chunk, faces) in chunks.into_iter().zip(faces) {
        let rows = faces.columns[UV].as_flattened_mut().iter_mut();
        rows.filter(|number| **number != NONE)
            .for_each(|number| *number = number.wrapping_add(before as u32));
        before += chunk.columns[0].len() as u64;
        triangles += faces.len();
        if numbered {
            joined.pictures.extend(chunk.pictures);
            joined.pictures.resize(triangles, NO_PICTURE);
        }
        columns.push(chunk.columns);
    }
    if before >= u64::from(NONE) {
        report.error(Span::START, "more than 2^32 - 2 texture coordinates");
        return JoinedFaceUvs::default();
    }
    let [x, y] = mesh::merge_floats(threads, columns);
    joined.uvs = Vec2s { x, y };
    joined
}

/// Coordinates that a thread turns at a time.
const BLOCK: usize = 1 << 16;

/// Turns v upside down, on several threads. Coordinates that are not finite become (0, 0).
pub(super) fn turn(uvs: &mut Vec2s, threads: usize, span: Span, report: &mut DiagnosticSink) {
    let pairs = uvs.x.chunks_mut(BLOCK).zip(uvs.y.chunks_mut(BLOCK));
    let bad: usize = workers::map(threads, pairs.collect(), |(u, v)| {
        let mut bad = 0;
        for (u, v) in u.iter_mut().zip(v) {
            if u.is_finite() && v.is_finite() {
                *v = 1.0 - *v
            } else {
                (*u, *v) = (0.0, 0.0);
                bad += 1;
            }
        }
        bad
    })
    .into_iter()
    .sum();
    if bad > 0 {
        let message = counted(
            bad,
            "one texture coordinate is not finite: it is taken as the picture's corner",
            "texture coordinates are not finite: they are taken as the picture's corner",
        );
        report.warning(span, message);
    }
}
