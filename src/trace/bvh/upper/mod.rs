//! Upper levels of a chunked tree: the divisions into chunks, and the largest nodes within chunks.
//! They are few and dominate the cost, so they are optimised as one tree.

mod reinsertion;
mod upper_tree;
mod whole_tree;

use super::clustering::ChunkTree;
use reinsertion::reinsert_all;
use upper_tree::UpperTree;
pub(super) use whole_tree::{ChunkRows, WholeTree};

/// The upper levels above chunks, optimised. `is_chunk` is the tree of divisions: see
/// [`Division::into_tree`](super::division::Division::into_tree).
pub(super) fn upper_tree(is_chunk: &[bool], chunks: &[ChunkTree]) -> UpperTree {
    let mut tree = UpperTree::new(is_chunk, chunks);
    reinsert_all(&mut tree);
    tree
}
