//! Chunks built by obvhs, for the best quality: `ploc` clusters and optimises, `convert` turns the
//! result into nodes. This is the only module that uses obvhs.

mod convert;
mod ploc;

use super::clustering::ChunkTree;
use super::prim_ref::PrimRef;
use bumpalo::Bump;
use convert::ObvhsTree;
use obvhs::aabb::Aabb;
use phalanx_scene::Bounds;

/// Maximum number of objects in a chunk. Smaller and larger chunks gave trees 1 to 5 % worse: see
/// `perf/notes/parallel-build.md`.
pub(super) const CHUNK_PRIMS: usize = 1 << 15;

/// The tree over a chunk, with its nodes in the arena.
pub(super) fn chunk_tree<'a>(chunk: &[PrimRef], arena: &'a Bump) -> ChunkTree<'a> {
    let boxes: Vec<Aabb> = chunk.iter().map(|item| aabb(item.bounds())).collect();
    let tree = ploc::build(&boxes);
    ObvhsTree::new(&tree, chunk).convert(arena)
}

/// Converts a box to obvhs's type.
fn aabb(b: Bounds) -> Aabb {
    Aabb::new(b.lo.into(), b.hi.into())
}
