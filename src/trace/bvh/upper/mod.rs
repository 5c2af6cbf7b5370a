//! Upper levels of a chunked tree: the divisions into chunks, and the largest nodes within chunks.
//! They are few and dominate the cost, so they are optimised as one tree.

mod upper_tree;
mod whole_tree;

use super::clustering::ChunkTree;
use super::reinsertion::reinsert_largest;
use upper_tree::UpperTree;
pub(super) use whole_tree::{ChunkRows, WholeTree};

/// Shares of the nodes that are reinserted, pass by pass.
const REINSERTED: [f32; 2] = [1.0, 1.0];

/// The upper levels above chunks, optimised. `is_chunk` is the tree of divisions: see
/// [`Division::into_tree`](super::division::Division::into_tree).
pub(super) fn upper_tree(is_chunk: &[bool], chunks: &[ChunkTree]) -> UpperTree {
    let mut tree = UpperTree::new(is_chunk, chunks);
    reinsert_largest(&mut tree, &REINSERTED);
    tree
}
