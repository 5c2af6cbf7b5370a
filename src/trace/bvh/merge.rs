//! Merging of subtrees: the nodes above them come first, then each subtree in the order in which
//! those nodes lead there.

use super::subtree::{Offsets, Subtree, weighted_cost};
use super::{Child, LeafPrims, Node};
use obvhs::bvh2::Bvh2;
use phalanx_scene::Bounds;
use rayon::prelude::*;

/// Merges several subtrees, by a tree of obvhs over them with one subtree a leaf.
pub(super) fn merge(mut subtrees: Vec<Subtree>, above: &Bvh2) -> Subtree {
    let order = leaves(above);
    // A binary tree has one inner node less than leaves.
    let mut end = Offsets {
        node: order.len() as u32 - 1,
        ..Offsets::default()
    };
    let mut bases = vec![end; subtrees.len()];
    for &k in &order {
        bases[k] = end;
        end = end.advanced_by(&subtrees[k]);
    }
    let mut whole = top(above, &subtrees, &bases);
    whole.weighted_cost += subtrees.iter().map(|p| p.weighted_cost).sum::<f64>();
    subtrees
        .par_iter_mut()
        .zip(&bases)
        .for_each(|(subtree, offsets)| offsets.rebase_nodes(&mut subtree.nodes));
    whole
        .nodes
        .reserve_exact(end.node as usize - whole.nodes.len());
    whole.slots.reserve(&end.slot);
    let mut subtrees: Vec<Option<Subtree>> = subtrees.into_iter().map(Some).collect();
    for subtree in order.iter().filter_map(|&k| subtrees[k].take()) {
        whole.nodes.extend(subtree.nodes);
        whole.slots.append(subtree.slots);
    }
    whole
}

/// The subtrees at the leaves, in the order of a traversal that visits first children first.
fn leaves(tree: &Bvh2) -> Vec<usize> {
    let mut order = Vec::new();
    let mut stack = vec![0];
    while let Some(at) = stack.pop() {
        let node = &tree.nodes[at];
        let first = node.first_index as usize;
        match node.prim_count {
            0 => stack.extend([first + 1, first]),
            _ => order.push(tree.primitive_indices[first] as usize),
        }
    }
    order
}

/// The nodes above the subtrees.
fn top(tree: &Bvh2, subtrees: &[Subtree], bases: &[Offsets]) -> Subtree {
    let mut whole = Subtree {
        root: Child::Node(0),
        bounds: subtrees
            .iter()
            .fold(Bounds::EMPTY, |all, p| all.union(p.bounds)),
        nodes: Vec::with_capacity(subtrees.len()),
        slots: LeafPrims::default(),
        depth: 0,
        weighted_cost: 0.0,
    };
    // (obvhs's node, parent and child index in it, depth)
    let mut stack = vec![(0, None, 1)];
    while let Some((at, parent, depth)) = stack.pop() {
        let theirs = &tree.nodes[at];
        let first = theirs.first_index as usize;
        let child = if theirs.prim_count == 0 {
            let index = whole.nodes.len() as u32;
            whole
                .nodes
                .push(Node::new([(Child::EMPTY, Bounds::EMPTY); 2]));
            whole.depth = whole.depth.max(depth);
            stack.extend([1, 0].map(|k| (first + k, Some((index, k)), depth + 1)));
            Child::Node(index)
        } else {
            let piece = tree.primitive_indices[first] as usize;
            whole.depth = whole.depth.max(depth - 1 + subtrees[piece].depth);
            bases[piece].rebased(subtrees[piece].root)
        };
        let b = theirs.aabb();
        let bounds = Bounds::new(b.min.into(), b.max.into());
        match parent {
            Some((parent, k)) => {
                let parent: &mut Node = &mut whole.nodes[parent as usize];
                parent.set_child(k, child);
                parent.set_box(k, bounds);
                whole.weighted_cost += weighted_cost(child, bounds);
            }
            None => whole.root = child,
        }
    }
    whole
}
