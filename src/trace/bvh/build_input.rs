//! Input of a tree build: primitives, and in the world's tree also instances.

use super::node::LeafKind;
use super::prim_ref::{PrimIndex, PrimRef};
use glam::Vec3;
use phalanx_scene::huge_pages::write_parts;
use phalanx_scene::{Bounds, Prim, PrimKind, Scene};
use std::ops::Range;

/// Objects that a thread takes at a time.
const BLOCK: PrimIndex = 1 << 14;

/// Access to the boxes, kinds and rows of objects.
pub(super) struct BuildInput<'a> {
    pub(super) scene: &'a Scene,
    /// The scene's columns as slices, for loops over all triangles.
    prims: &'a [Prim],
    corners: &'a [[u32; 3]],
    vertices: [&'a [f32]; 3],
    /// Bounds of every mesh, in its own space.
    mesh_bounds: Vec<Bounds>,
}

impl<'a> BuildInput<'a> {
    /// Access to a scene with meshes of these padded bounds; instances need them.
    pub(super) fn new(scene: &'a Scene, mesh_bounds: Vec<Bounds>) -> BuildInput<'a> {
        let vertices = &scene.triangles.vertices;
        BuildInput {
            scene,
            prims: &scene.prims,
            corners: &scene.triangles.corners,
            vertices: [&vertices.x, &vertices.y, &vertices.z],
            mesh_bounds,
        }
    }

    /// The objects of the world.
    pub(super) fn world(&self) -> Vec<PrimRef> {
        self.objects(&self.scene.world_objects())
    }

    /// The objects of a mesh.
    pub(super) fn mesh(&self, mesh: usize) -> Vec<PrimRef> {
        self.objects(&[self.scene.meshes.prims(mesh)])
    }

    /// The objects of several runs.
    pub(super) fn objects(&self, runs: &[Range<PrimIndex>]) -> Vec<PrimRef> {
        let blocks = runs.iter().flat_map(|run| {
            let firsts = run.clone().step_by(BLOCK as usize);
            firsts.map(|first| first..run.end.min(first.saturating_add(BLOCK)))
        });
        let blocks: Vec<Range<PrimIndex>> = blocks.collect();
        let lens: Vec<usize> = blocks.iter().map(|block| block.len()).collect();
        let (all, _) = write_parts(&lens, |k, part| {
            for object in blocks[k].clone() {
                part.push(PrimRef::new(object, self.kind(object), self.bounds(object)));
            }
        });
        all
    }

    #[inline(always)]
    pub(super) fn kind(&self, object: PrimIndex) -> LeafKind {
        match self.prims.get(object as usize) {
            Some(prim) => LeafKind::Prim(prim.kind()),
            None => LeafKind::Instance,
        }
    }

    /// The padded box, from which every enclosing box is computed.
    #[inline(always)]
    fn bounds(&self, object: PrimIndex) -> Bounds {
        match self.prims.get(object as usize) {
            Some(prim) if prim.kind() == PrimKind::Triangle => {
                triangle_bounds(self.vertices(prim.index()))
            }
            _ => self.bounds_of_others(object),
        }
    }

    #[inline(never)]
    fn bounds_of_others(&self, object: PrimIndex) -> Bounds {
        if (object as usize) < self.prims.len() {
            return self.scene.prim_bounds(object).padded();
        }
        let k = self.row(object);
        let mesh = self.scene.instances.mesh[k] as usize;
        let bounds = self.scene.instances.bounds(k, self.mesh_bounds[mesh]);
        bounds.padded()
    }

    /// The vertices of the triangle in this row.
    #[inline(always)]
    pub(super) fn vertices(&self, row: usize) -> [Vec3; 3] {
        self.corners[row].map(|corner| self.vertex(corner))
    }

    /// Rows of the vertices of a triangle. Rows that have left a tree keep their numbers, which
    /// another scene may lack: theirs may be any.
    pub(super) fn corners(&self, object: PrimIndex) -> [u32; 3] {
        match self.prims.get(object as usize) {
            Some(prim) if prim.kind() == PrimKind::Triangle => self.corners[prim.index()],
            _ => [0; 3],
        }
    }

    #[inline(always)]
    pub(super) fn vertex(&self, index: u32) -> Vec3 {
        let index = index as usize;
        let [x, y, z] = self.vertices;
        Vec3::new(x[index], y[index], z[index])
    }

    /// The row of an object among the primitives of its kind, or among the instances.
    #[inline(always)]
    pub(super) fn row(&self, object: PrimIndex) -> usize {
        match self.prims.get(object as usize) {
            Some(prim) => prim.index(),
            None => object as usize - self.prims.len(),
        }
    }

    /// The padded box, as rows hold it.
    pub(super) fn prim_aabb(&self, object: PrimIndex) -> [[f32; 3]; 2] {
        let bounds = self.bounds(object);
        [bounds.lo.to_array(), bounds.hi.to_array()]
    }
}

/// The padded box of a triangle.
#[inline(always)]
pub(super) fn triangle_bounds([a, b, c]: [Vec3; 3]) -> Bounds {
    Bounds::new(a.min(b).min(c), a.max(b).max(c)).padded()
}
