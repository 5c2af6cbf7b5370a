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
            let at = self.vertices.stored_position(corner as usize);
            (0..3).all(|axis| crate::origin::is_exact(at[axis], origin[axis]))
        };
        self.corners.iter().flatten().all(exact)
    }
}
