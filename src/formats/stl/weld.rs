//! Welds corners: those with the same bits become one vertex, numbered in the order in which they
//! first appear.

use crate::diagnostics::Span;
use crate::mesh::faces::{Faces, VERTEX};
use crate::mesh::first_equal::first_equal;
use crate::mesh::{self, NotFinite, PolygonMesh};
use phalanx_scene::Vec3s;

/// Triangles over shared vertices.
pub(super) struct Welded {
    pub(super) vertices: Vec3s,
    pub(super) corners: Vec<[u32; 3]>,
    /// Vertices that are out of reach, and the corner where each occurs first.
    bad: Vec<(u32, usize)>,
}

impl Welded {
    /// The mesh. All vertices that are out of reach have the span of the first.
    pub(super) fn into_mesh(self, span: impl Fn(usize) -> Span) -> PolygonMesh {
        let span = self.bad.first().map_or(Span::START, |bad| span(bad.1));
        let bad = self.bad.into_iter();
        let mut faces = Faces::default();
        faces.columns[VERTEX] = self.corners;
        PolygonMesh {
            vertices: self.vertices,
            faces: vec![faces],
            not_finite: bad.map(|(number, _)| NotFinite { number, span }).collect(),
            ..PolygonMesh::default()
        }
    }

    fn add(&mut self, position: [f32; 3], corner: usize) {
        if !mesh::is_in_reach(position) {
            self.bad.push((self.vertices.len() as u32, corner));
        }
        self.vertices.push(mesh::finite_or_zero(position).into());
    }
}

/// Welds the corners of `facets` facets, given by their bits.
pub(super) fn weld(
    facets: usize,
    threads: usize,
    corner: impl Fn(usize) -> [u32; 3] + Sync,
) -> Welded {
    // For each corner, the first one with the same bits; then its vertex's number.
    let mut numbers = first_equal(3 * facets, threads, |row| {
        let [x, y, z] = corner(row);
        [x, y, z, 0]
    });
    let mut welded = Welded {
        vertices: Vec3s::default(),
        corners: Vec::with_capacity(facets),
        bad: Vec::new(),
    };
    for facet in 0..facets {
        let row = [0, 1, 2].map(|k| {
            let corner_index = facet * 3 + k;
            let first = numbers[corner_index] as usize;
            if first == corner_index {
                numbers[corner_index] = welded.vertices.len() as u32;
                welded.add(corner(corner_index).map(f32::from_bits), corner_index);
            } else {
                numbers[corner_index] = numbers[first];
            }
            numbers[corner_index]
        });
        welded.corners.push(row);
    }
    welded
}
