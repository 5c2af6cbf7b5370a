//! Upper levels of a tree in chunks: how the chunks were divided, and the largest nodes of the
//! chunks themselves. They are few and cost most, so that they are optimised as one tree.

mod reinsertion;
mod upper_tree;
mod whole_tree;

use super::clustering::ChunkTree;
use reinsertion::reinsert_all;
use upper_tree::UpperTree;
pub(super) use whole_tree::WholeTree;

/// Optimises the upper levels of chunks, and joins all to one tree. `is_chunk` is the tree of their
/// divisions: see [`Division::into_tree`](super::division::Division::into_tree).
pub(super) fn whole_tree(is_chunk: &[bool], chunks: &[ChunkTree]) -> WholeTree {
    let mut upper = UpperTree::new(is_chunk, chunks);
    reinsert_all(&mut upper);
    WholeTree::new(&upper, chunks)
}
