//! Meshes in parts, as a builder gets them to prepare them on several threads.

use glam::DVec3;
use phalanx_scene::Mesh;

/// Part of a mesh: vertices, and triangles of these and of some before them.
#[derive(Clone, Copy, Debug)]
pub struct MeshSlice<'a> {
    /// All vertices that the triangles use.
    pub(crate) vertices: &'a [DVec3],
    /// Number of vertices at the start that belong to the part before.
    pub(crate) shared: usize,
    /// Vertices of each triangle; `base` is the number of the first vertex.
    pub(crate) triangles: &'a [[u32; 3]],
    pub(crate) base: u32,
    /// Number of vertices in the parts before.
    pub(crate) before: usize,
}

impl<'a> MeshSlice<'a> {
    /// A mesh in one part.
    pub(crate) fn complete(vertices: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        MeshSlice {
            vertices,
            shared: 0,
            triangles,
            base: 0,
            before: 0,
        }
    }

    /// The vertices that this part adds to the mesh.
    pub fn vertices(&self) -> &'a [DVec3] {
        &self.vertices[self.shared..]
    }

    /// The triangles, by the numbers of their vertices if the mesh's first vertex is `first`.
    pub fn triangles(&self, first: u32) -> impl ExactSizeIterator<Item = [u32; 3]> + 'a {
        let first = first.wrapping_add((self.before - self.shared) as u32);
        let shift = first.wrapping_sub(self.base);
        let triangles = self.triangles.iter();
        triangles.map(move |corners| corners.map(|v| v.wrapping_add(shift)))
    }

    /// The corners of the triangles.
    pub fn corners(&self) -> impl ExactSizeIterator<Item = [DVec3; 3]> + 'a {
        let (vertices, base) = (self.vertices, self.base);
        let triangles = self.triangles.iter();
        triangles.map(move |corners| corners.map(|v| vertices[(v - base) as usize]))
    }
}

/// A mesh as a builder has prepared it. Builders use the parts that they need.
#[derive(Debug, Default)]
pub struct PreparedMesh {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// The mesh, without its material.
    pub mesh: Mesh,
    /// Bytes of a file.
    pub bytes: Vec<u8>,
}

impl PreparedMesh {
    /// A mesh of these parts, of which only the size is known.
    pub fn sized(parts: &[MeshSlice]) -> PreparedMesh {
        PreparedMesh {
            vertices: parts.iter().map(|part| part.vertices().len()).sum(),
            triangles: parts.iter().map(|part| part.triangles.len()).sum(),
            ..PreparedMesh::default()
        }
    }
}

/// Prepares a mesh of these parts; the second argument is the number of vertices of the meshes
/// before it in the same sequence of meshes.
pub type Prepare = dyn Fn(&[MeshSlice], u64) -> PreparedMesh + Send + Sync;
