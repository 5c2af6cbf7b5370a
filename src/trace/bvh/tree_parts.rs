//! The trees that a [`Bvh`](super::Bvh) consists of, which change on their own.

use super::settings::BuildSettings;
use super::subtree::{Subtree, relative_cost};
use super::upper::ChunkRows;
use phalanx_scene::Edits;
use std::ops::Range;

/// The tree of the world, or of a mesh, among all.
#[derive(Clone, Debug, Default)]
pub(super) struct TreePart {
    pub(super) nodes: Range<usize>,
    /// Rows of triangles; other primitives do not move.
    pub(super) triangles: Range<usize>,
    /// Chunks, whose rows are counted from the first node and the first triangle.
    pub(super) chunks: Vec<ChunkRows>,
    /// Rows of the scene's vertices, by triangle; empty until the part is first refitted.
    pub(super) corners: Vec<[u32; 3]>,
    pub(super) depth: usize,
    /// Σ area · cost over the children of all nodes.
    pub(super) weighted_cost: f64,
    /// That by the area of the whole, when the part was built.
    pub(super) built_cost: f64,
}

/// Parts of a tree that change on their own, and the edits that it has followed.
#[derive(Clone, Debug)]
pub(super) struct TreeParts {
    pub(super) settings: BuildSettings,
    pub(super) edits: Edits,
    /// The primitives of the world; the instances are among them until one has moved.
    pub(super) world: TreePart,
    pub(super) meshes: Vec<TreePart>,
    /// First node of the instances' own tree, if they have one.
    pub(super) top: Option<usize>,
}

impl TreePart {
    /// A tree whose nodes and triangles begin at these rows.
    pub(super) fn at(node: usize, triangle: usize, built: &Subtree) -> TreePart {
        TreePart {
            nodes: node..node + built.tree.nodes.len(),
            triangles: triangle..triangle + built.slots.triangles.len(),
            chunks: built.tree.chunks.clone(),
            corners: Vec::new(),
            depth: built.tree.depth,
            weighted_cost: built.tree.weighted_cost,
            built_cost: relative_cost(built.tree.weighted_cost, built.tree.bounds),
        }
    }
}

impl TreeParts {
    /// Roots of the trees over the world's primitives and over the instances, where both have one.
    pub(super) fn roots(&self, nodes: usize) -> Option<[u32; 2]> {
        let top = self.top.filter(|&top| top < nodes)?;
        (!self.world.nodes.is_empty()).then_some([self.world.nodes.start as u32, top as u32])
    }
}
