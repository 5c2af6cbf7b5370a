//! Refit: the boxes of a tree's nodes follow the vertices of its triangles, bottom up; the tree
//! itself stays.

use super::build_input::BuildInput;
use super::leaf::LeafTriangle;
use super::node::weighted_cost;
use super::tree_parts::TreePart;
use super::upper::ChunkRows;
use super::{Bvh, Child, LeafKind, Node};
use phalanx_scene::huge_pages::consecutive;
use phalanx_scene::{Bounds, map_on_pool, on_pool};
use rayon::prelude::*;

impl Node {
    /// The box around both children.
    pub(super) fn child_bounds(&self) -> Bounds {
        let child = |k: usize| match self.child(k) {
            Child::Leaf { count: 0, .. } => Bounds::EMPTY,
            _ => self.bounds(k),
        };
        child(0).union(child(1))
    }

    /// Σ area · cost over both children.
    pub(super) fn weighted_cost(&self) -> f64 {
        let child = |k| weighted_cost(self.child(k), self.bounds(k));
        child(0) + child(1)
    }
}

impl Bvh {
    /// Moves the triangles of a part, and the boxes around them, to where the scene has them now.
    /// Returns its Σ area · cost.
    pub(super) fn refit(&mut self, input: &BuildInput, part: &mut TreePart) -> f64 {
        let first_triangle = part.triangles().start;
        let triangles = &mut self.slots.triangles.make_mut()[part.triangles()];
        if part.corners.is_empty() {
            // In leaf order: later refits read what they need in one sweep.
            let corners = triangles.par_iter().map(|row| input.corners(row.prim_id));
            part.corners = on_pool(|| corners.collect());
        }
        let nodes = &mut self.nodes.make_mut()[part.nodes.clone()];
        let upper = part.chunks.first().map_or(nodes.len(), |chunk| chunk.node);
        let starts = |row: fn(&ChunkRows) -> usize| part.chunks.iter().map(row);
        let node_slices = split(&mut nodes[upper..], starts(|chunk| chunk.node));
        let triangle_slices = split(triangles, starts(|chunk| chunk.triangle));
        let chunks = part.chunks.iter().zip(node_slices).zip(triangle_slices);
        let weighted = map_on_pool(chunks, |((chunk, nodes), triangles)| {
            // The boxes read what has just been written.
            for (row, corners) in triangles.iter_mut().zip(&part.corners[chunk.triangle..]) {
                row.vertices = corners.map(|corner| input.vertex(corner).to_array());
            }
            let first = [
                part.nodes.start + chunk.node,
                first_triangle + chunk.triangle,
            ];
            let count = nodes.len();
            refit_nodes((nodes, count), triangles, first)
        });
        // In order, so that the sum does not depend on threads.
        let below: f64 = weighted.iter().sum();
        let first = [part.nodes.start, first_triangle];
        below + refit_nodes((nodes, upper), triangles, first)
    }
}

/// Consecutive slices that begin at these rows, the first of which is the first row of all.
fn split<T>(rows: &mut [T], starts: impl Iterator<Item = usize> + Clone) -> Vec<&mut [T]> {
    let first = starts.clone().next().unwrap_or(0);
    let ends = starts.clone().skip(1).chain([first + rows.len()]);
    consecutive(rows, starts.zip(ends).map(|(start, end)| end - start))
}

/// Makes the boxes of the first `count` nodes fit; those of the others do so already. Nodes and
/// triangles are counted from these `first` ones. Returns Σ area · cost.
fn refit_nodes(
    (nodes, count): (&mut [Node], usize),
    triangles: &[LeafTriangle],
    first: [usize; 2],
) -> f64 {
    let mut weighted = 0.0;
    // Children stand behind their parents.
    for index in (0..count).rev() {
        for k in 0..2 {
            let child = nodes[index].child(k);
            let bounds = match child {
                Child::Node(child) => nodes[child as usize - first[0]].child_bounds(),
                Child::Leaf {
                    kind: LeafKind::TRIANGLE,
                    first: slot,
                    count,
                } if count > 0 => {
                    let rows = &triangles[slot as usize - first[1]..][..count as usize];
                    let boxes = rows.iter().map(LeafTriangle::bounds);
                    boxes.fold(Bounds::EMPTY, Bounds::union)
                }
                Child::Leaf { .. } => nodes[index].bounds(k),
            };
            nodes[index].set_box(k, bounds);
            weighted += weighted_cost(child, bounds);
        }
    }
    weighted
}
