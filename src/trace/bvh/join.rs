//! Pieces become one: the nodes above them first, then each piece in the order in which those lead there.

use super::piece::{Base, Piece, weighted_cost};
use super::{Child, Node, Slots};
use obvhs::bvh2::Bvh2;
use phalanx_scene::Bounds;
use rayon::prelude::*;

/// One piece from several, by a tree of obvhs over them with one piece a leaf.
pub(super) fn join(mut pieces: Vec<Piece>, above: &Bvh2) -> Piece {
    let order = leaves(above);
    // A binary tree has one inner node less than leaves.
    let mut end = Base {
        node: order.len() as u32 - 1,
        ..Base::default()
    };
    let mut bases = vec![end; pieces.len()];
    for &k in &order {
        bases[k] = end;
        end = end.after(&pieces[k]);
    }
    let mut whole = top(above, &pieces, &bases);
    whole.weighted_cost += pieces.iter().map(|p| p.weighted_cost).sum::<f64>();
    pieces
        .par_iter_mut()
        .zip(&bases)
        .for_each(|(piece, base)| base.move_nodes(&mut piece.nodes));
    whole
        .nodes
        .reserve_exact(end.node as usize - whole.nodes.len());
    whole.slots.reserve(&end);
    let mut pieces: Vec<Option<Piece>> = pieces.into_iter().map(Some).collect();
    for piece in order.iter().filter_map(|&k| pieces[k].take()) {
        whole.nodes.extend(piece.nodes);
        whole.slots.append(piece.slots);
    }
    whole
}

/// The pieces at the leaves, in the order of a walk that goes to first children first.
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

/// The nodes above the pieces.
fn top(tree: &Bvh2, pieces: &[Piece], bases: &[Base]) -> Piece {
    let mut whole = Piece {
        root: Child::Node(0),
        bounds: pieces
            .iter()
            .fold(Bounds::EMPTY, |all, p| all.union(p.bounds)),
        nodes: Vec::with_capacity(pieces.len()),
        slots: Slots::default(),
        depth: 0,
        weighted_cost: 0.0,
    };
    // (their node, its place in its parent, depth)
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
            whole.depth = whole.depth.max(depth - 1 + pieces[piece].depth);
            bases[piece].moved(pieces[piece].root)
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
