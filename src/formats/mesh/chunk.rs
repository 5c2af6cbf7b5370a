//! Rows of a mesh that one worker has read, and their join.

use super::faces::Faces;
use super::polygon_mesh::{NotFinite, PolygonMesh, finite_or_zero, is_in_reach, merge_floats};
use crate::diagnostics::Span;
use phalanx_scene::{Vec2s, Vec3s};

#[derive(Debug, Default)]
pub(crate) struct MeshChunk {
    pub(crate) vertices: [Vec<f32>; 3],
    pub(crate) normals: [Vec<f32>; 3],
    pub(crate) uvs: [Vec<f32>; 2],
    pub(crate) faces: Faces,
    /// Vertices that are out of reach, ascending.
    pub(crate) not_finite: Vec<NotFinite>,
    /// Normals that are zero or not finite, ascending.
    pub(crate) bad_normals: Vec<NotFinite>,
}

impl MeshChunk {
    /// Adds a vertex. One that is out of reach is noted under its number.
    #[inline]
    pub(crate) fn add_vertex(&mut self, position: [f32; 3], number: u32, span: Span) {
        let position = checked_position(position, number, span, &mut self.not_finite);
        push(&mut self.vertices, position);
    }

    /// Adds a normal. One that is zero or not finite is noted under its number.
    #[inline]
    pub(crate) fn add_normal(&mut self, normal: [f32; 3], number: u32, span: Span) {
        let normal = checked_normal(normal, number, span, &mut self.bad_normals);
        push(&mut self.normals, normal);
    }
}

/// Joins chunks to one mesh, in their order.
pub(crate) fn merge(chunks: Vec<MeshChunk>, threads: usize) -> PolygonMesh {
    let mut columns = Vec::new();
    let mut mesh = PolygonMesh::default();
    for chunk in chunks {
        let ([x, y, z], [nx, ny, nz], [u, v]) = (chunk.vertices, chunk.normals, chunk.uvs);
        columns.push([x, y, z, nx, ny, nz, u, v]);
        mesh.not_finite.extend(chunk.not_finite);
        mesh.bad_normals.extend(chunk.bad_normals);
        mesh.faces.push(chunk.faces);
    }
    let [x, y, z, nx, ny, nz, u, v] = merge_floats(threads, columns);
    let vectors = |x, y, z| Vec3s { x, y, z };
    mesh.vertices = vectors(x, y, z);
    mesh.vertex_normals = vectors(nx, ny, nz);
    mesh.vertex_uvs = Vec2s { x: u, y: v };
    mesh
}

/// A position as it is stored, and a note if it is out of reach.
#[inline]
pub(crate) fn checked_position(
    row: [f32; 3],
    number: u32,
    span: Span,
    bad: &mut Vec<NotFinite>,
) -> [f32; 3] {
    if is_in_reach(row) {
        return row;
    }
    bad.push(NotFinite { number, span });
    finite_or_zero(row)
}

/// A normal, or +z and a note if it is zero or not finite.
#[inline]
pub(crate) fn checked_normal(
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

/// Adds a row to columns.
#[inline]
pub(crate) fn push<const N: usize>(columns: &mut [Vec<f32>; N], row: [f32; N]) {
    for (column, number) in columns.iter_mut().zip(row) {
        column.push(number);
    }
}
