//! Shared steps of the readers of meshes: vertices that are not finite, and triangles.

use super::faces::{Faces, NONE, NORMAL, UV, VERTEX};
use super::vertex_colors::MeshColors;
use crate::diagnostics::{ChunkRemarks, DiagnosticSink, Span, WarningTally, counted};
use crate::text::workers;
use phalanx_scene::{Column, MeshMaterial, Vec2s, Vec3s};

/// A row whose numbers are not finite or cannot be used, and its span in the file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NotFinite {
    pub(crate) number: u32,
    pub(crate) span: Span,
}

/// Largest coordinate of a vertex that is taken beside smaller ones. No unit of length explains
/// more, and what lies near 0 would vanish in single precision beside it: real files have 1e30 and
/// the largest of all numbers where nothing was measured.
const FARTHEST: f32 = 1e20;

/// Returns true if all coordinates are finite and at most [`FARTHEST`].
#[inline]
pub(crate) fn is_in_reach(position: [f32; 3]) -> bool {
    position.iter().all(|c| c.abs() <= FARTHEST)
}

/// The position as it is stored: 0 if it is not finite.
pub(crate) fn finite_or_zero(position: [f32; 3]) -> [f32; 3] {
    if position.iter().all(|c| c.is_finite()) { position } else { [0.0; 3] }
}

/// Leaves out the faces with a vertex that is out of reach ([`is_in_reach`]), and warns of them.
/// The triangles become points, so that all rows keep their numbers. Vertices beyond [`FARTHEST`]
/// are kept if most are: then all of the scene is that large. Returns those that are not kept.
fn leave_out_unreachable(
    mut lost: Vec<NotFinite>,
    vertices: &mut Vec3s,
    chunks: &mut [Faces],
    report: &mut DiagnosticSink,
) -> Vec<u32> {
    let is_far = |v: &NotFinite| !is_in_reach(vertices.get(v.number as usize).to_array());
    if 2 * lost.iter().filter(|v| is_far(v)).count() > vertices.len() {
        lost.retain(|v| !is_far(v));
    }
    let Some(first) = lost.first().map(|v| v.span) else {
        return Vec::new();
    };
    for vertex in &lost {
        let row = vertex.number as usize;
        (vertices.x[row], vertices.y[row], vertices.z[row]) = (0.0, 0.0, 0.0);
    }
    let find = |number: &u32| lost.binary_search_by_key(number, |v| v.number);
    let mut corners = chunks
        .iter()
        .flat_map(|faces| faces.columns[VERTEX].as_flattened());
    let home = corners.find(|number| find(number).is_err()).copied();
    let mut used = vec![false; lost.len()];
    let mut is_lost = |number: u32| find(&number).map(|k| used[k] = true).is_ok();
    let triangles = chunks
        .iter_mut()
        .map(|faces| faces.leave_out(home.unwrap_or(0), &mut is_lost));
    let triangles: usize = triangles.sum();
    if home.is_none() && triangles > 0 {
        report.error(first, "no vertex of a face is finite");
    }
    let mut remarks = ChunkRemarks::default();
    let mut missed = WarningTally::default();
    for (vertex, used) in lost.iter().zip(used) {
        if used {
            missed.add(vertex.span)
        } else {
            remarks.warn(
                vertex.span,
                "this vertex is not finite or beyond 1e20; no face uses it",
                "vertices, this one first, are not finite or beyond 1e20; no face uses them",
            )
        }
    }
    if let Some(span) = missed.first {
        let vertices = counted(
            missed.count,
            "this vertex is",
            "vertices, this one first, are",
        );
        let left_out = counted(
            triangles,
            "1 triangle is left out",
            "triangles are left out",
        );
        let message = format!("{vertices} not finite or beyond 1e20: {left_out}");
        report.warning(span, message);
    }
    remarks.emit(report);
    lost.iter().map(|vertex| vertex.number).collect()
}

/// Warns of normals that cannot be used.
fn warn_bad_normals(bad: &[NotFinite], report: &mut DiagnosticSink) {
    let mut remarks = ChunkRemarks::default();
    for normal in bad {
        remarks.warn(
            normal.span,
            "this normal is zero or not finite: faces that use it have none",
            "normals are zero or not finite, this one first: faces that use them have none",
        );
    }
    remarks.emit(report);
}

/// A mesh as it is read: columns of the whole file, and faces in chunks, which may be polygons.
#[derive(Default)]
pub(crate) struct PolygonMesh {
    pub(crate) vertices: Vec3s,
    pub(crate) vertex_normals: Vec3s,
    pub(crate) vertex_uvs: Vec2s,
    pub(crate) faces: Vec<Faces>,
    /// True if normals and UVs have the numbers of the vertices that they belong to.
    pub(crate) normals_by_vertex: bool,
    pub(crate) uvs_by_vertex: bool,
    /// Vertices that are out of reach, ascending.
    pub(crate) not_finite: Vec<NotFinite>,
    /// Normals that cannot be used, ascending.
    pub(crate) bad_normals: Vec<NotFinite>,
}

/// A mesh of triangles.
#[derive(Debug, Default)]
pub(crate) struct MergedMesh {
    pub(crate) vertices: Vec3s,
    pub(crate) vertex_normals: Vec3s,
    pub(crate) vertex_uvs: Vec2s,
    pub(crate) faces: [Vec<[u32; 3]>; 3],
    pub(crate) colors: MeshColors,
    pub(crate) material: MeshMaterial,
    /// Vertices that are out of reach, ascending.
    pub(crate) lost: Vec<u32>,
    /// Axes of `vertices` that are single-precision numbers in the file and have not been changed.
    pub(crate) single: [bool; 3],
}

impl PolygonMesh {
    /// Cuts the faces into triangles, and leaves out what cannot be used, with warnings.
    pub(crate) fn triangulated(
        mut self,
        threads: usize,
        report: &mut DiagnosticSink,
    ) -> MergedMesh {
        let mut lost = Vec::new();
        // A file with errors has no triangles that are worth a remark.
        if report.is_clean() {
            lost =
                leave_out_unreachable(self.not_finite, &mut self.vertices, &mut self.faces, report);
            warn_bad_normals(&self.bad_normals, report);
        }
        let cut = |mut faces: Faces| {
            faces.triangulate(&self.vertices);
            faces
        };
        let mut faces = merge_faces(threads, workers::map(threads, self.faces, cut));
        for (attribute, by_vertex) in [(NORMAL, self.normals_by_vertex), (UV, self.uvs_by_vertex)] {
            if by_vertex {
                faces[attribute] = faces[VERTEX].clone();
            }
        }
        if !self.bad_normals.is_empty() {
            let find = |number: &u32| self.bad_normals.binary_search_by_key(number, |n| n.number);
            let rows = faces[NORMAL].iter_mut();
            rows.filter(|row| row.iter().any(|number| find(number).is_ok()))
                .for_each(|row| *row = [NONE; 3]);
        }
        MergedMesh {
            vertices: self.vertices,
            vertex_normals: self.vertex_normals,
            vertex_uvs: self.vertex_uvs,
            faces,
            lost,
            ..MergedMesh::default()
        }
    }
}

/// Joins columns of floats, which are given in chunks, on several threads.
pub(crate) fn merge_floats<const N: usize>(
    threads: usize,
    chunks: impl IntoIterator<Item = [Vec<f32>; N]>,
) -> [Column<f32>; N] {
    let mut columns = [const { Vec::new() }; N];
    for chunk in chunks {
        for (column, part) in columns.iter_mut().zip(chunk) {
            column.push(part);
        }
    }
    let mut joined = workers::map(threads, columns.into(), workers::join).into_iter();
    std::array::from_fn(|_| joined.next().unwrap_or_default().into())
}

/// Joins the faces of all chunks. A column that only some chunks have gets rows without numbers for
/// the others.
fn merge_faces(threads: usize, chunks: Vec<Faces>) -> [Vec<[u32; 3]>; 3] {
    let mut columns: [Vec<Vec<[u32; 3]>>; 3] = Default::default();
    let has = [VERTEX, UV, NORMAL]
        .map(|attribute| chunks.iter().any(|p| !p.columns[attribute].is_empty()));
    for mut chunk in chunks {
        let rows = chunk.len();
        for (attribute, parts) in columns.iter_mut().enumerate().filter(|(k, _)| has[*k]) {
            let mut part = std::mem::take(&mut chunk.columns[attribute]);
            part.resize(rows, [NONE; 3]);
            parts.push(part);
        }
    }
    let mut joined = workers::map(threads, columns.into(), workers::join).into_iter();
    std::array::from_fn(|_| joined.next().unwrap_or_default())
}
