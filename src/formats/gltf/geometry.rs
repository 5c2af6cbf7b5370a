//! Primitives: accessors to triangles, in their mesh's own space or baked into the world.

use super::document::Primitive;
use super::materials::PrimitiveMaterial;
use super::source::GltfSource;
use super::triangle_indices::triangles;
use super::vertex_columns::BLOCK;
use super::vertices::PrimitiveVertices;
use crate::memory::OverLimit;
use crate::text::workers;
use glam::DVec3;
use phalanx_scene::Bounds;
use phalanx_scene::huge_pages::room;
use std::collections::HashMap;

/// Triangles of one material, in the form of the file's accessors.
pub(super) struct PrimitiveGeometry<'a> {
    pub(super) vertices: PrimitiveVertices<'a>,
    pub(super) corners: Vec<[u32; 3]>,
    pub(super) material: u32,
    /// Number of the material's name in the scene.
    pub(super) name: u32,
}

/// Bytes of a triangle of a shape.
pub(super) const CORNERS_BYTES: u64 = 12;

impl<'a> PrimitiveGeometry<'a> {
    /// Reads the indices of a primitive: no more than `most` triangles, and only if `room` grants
    /// memory for them and for the resulting columns.
    pub(super) fn open(
        source: &'a GltfSource,
        primitive: &Primitive,
        (material, name): (&PrimitiveMaterial, u32),
        vertices: PrimitiveVertices<'a>,
        (most, threads): (u64, usize),
        room: impl FnOnce(u64, u64) -> Result<(), OverLimit>,
    ) -> Result<PrimitiveGeometry<'a>, String> {
        let mut shape = PrimitiveGeometry {
            vertices,
            corners: Vec::new(),
            material: material.material,
            name,
        };
        let room = |count: u64| Ok(room(count, shape.bytes_of(count))?);
        shape.corners = triangles(source, primitive, shape.vertices.count, most, threads, room)?;
        Ok(shape)
    }

    /// Number of triangles.
    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    /// Upper bound on the bytes of its columns.
    pub(super) fn mesh_bytes(&self) -> u64 {
        self.bytes_of(self.len() as u64)
    }

    /// Upper bound on the bytes of the columns of `triangles` of its triangles: they grow by
    /// doubling.
    fn bytes_of(&self, triangles: u64) -> u64 {
        let per = |column: bool, bytes: u64| if column { bytes } else { 0 };
        let has = self.vertices.attributes();
        let mapped = per(has.uvs > 0, 12) + per(has.tangents, 12);
        let triangle = 32 + per(has.normals, 12) + mapped + per(has.colors, 12);
        let mapped = has.uvs as u64 * 8 + per(has.tangents, 16);
        let vertex = 12 + per(has.normals, 12) + mapped + per(has.colors, 16);
        2 * (triangles * triangle + self.most_vertices(triangles) * vertex)
    }

    /// Upper bound on the vertices that `triangles` of its triangles use.
    fn most_vertices(&self, triangles: u64) -> u64 {
        (self.vertices.count as u64).min(3 * triangles)
    }

    /// Upper bound on the displacements that its vertices add up: for the triangles, and for their
    /// bounds.
    pub(super) fn displacements(&self) -> u64 {
        let vertices = 3 * self.len() as u64;
        vertices.saturating_mul(self.vertices.target_count() as u64)
    }

    /// Bounds of the corners, in the mesh's own space and without its joints.
    pub(super) fn bounds(&self, threads: usize) -> Bounds {
        let rows = self.renumbered(false, &[]).rows;
        let of_block = |rows: &[u32]| {
            let mut bounds = Bounds::EMPTY;
            self.vertices.each_position(rows, |_, position| {
                let position = position.as_vec3();
                bounds = bounds.union(Bounds::new(position, position));
            });
            bounds
        };
        let blocks = workers::map(threads, rows.chunks(BLOCK).collect(), of_block);
        blocks.into_iter().fold(Bounds::EMPTY, Bounds::union)
    }

    /// Returns true if subtracting an origin rounds no corner.
    pub(super) fn is_exact_at(&self, origin: DVec3) -> bool {
        let exact = |&corner: &u32| {
            let position = self.vertices.stored_position(corner as usize);
            (0..3).all(|axis| crate::origin::is_exact(position[axis], origin[axis]))
        };
        self.corners.iter().flatten().all(exact)
    }
}

/// Triangles of a primitive with the vertices' new numbers.
pub(super) struct Renumbered {
    /// Row of each vertex in the accessors.
    pub(super) rows: Vec<u32>,
    pub(super) corners: Vec<[u32; 3]>,
}

/// New numbers of vertices by their rows: a table if most are used, a map if few are.
enum NumberTable {
    Table(Vec<u32>),
    Map(HashMap<u32, u32>),
}

/// Stands for a vertex without a number so far.
const UNUSED: u32 = u32::MAX;
/// Stands for a vertex that gets no number.
const LOST: u32 = u32::MAX - 1;

impl NumberTable {
    #[inline]
    fn slot(&mut self, row: u32) -> &mut u32 {
        match self {
            NumberTable::Table(table) => &mut table[row as usize],
            NumberTable::Map(map) => map.entry(row).or_insert(UNUSED),
        }
    }
}

impl Renumbered {
    /// Numbers the corners of triangles of `vertices` vertices. Triangles with one of the `lost`
    /// rows are left out, but their other vertices are not.
    pub(super) fn of(
        triangles: impl ExactSizeIterator<Item = [u32; 3]>,
        vertices: usize,
        lost: &[u32],
    ) -> Renumbered {
        // The table's size is at most a few times what is read anyway.
        let mut numbers = if vertices <= 12 * triangles.len() {
            NumberTable::Table(vec![UNUSED; vertices])
        } else {
            NumberTable::Map(HashMap::new())
        };
        for &row in lost {
            *numbers.slot(row) = LOST;
        }
        let mut rows = Vec::new();
        let mut corners = room(triangles.len());
        for triangle in triangles {
            let triangle = triangle.map(|row| {
                let number = numbers.slot(row);
                if *number == UNUSED {
                    *number = rows.len() as u32;
                    rows.push(row);
                }
                *number
            });
            if !triangle.contains(&LOST) {
                corners.push(triangle);
            }
        }
        Renumbered { rows, corners }
    }
}
