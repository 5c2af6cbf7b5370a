//! Primitives and instances that leave a tree: their rows go, and the boxes above them shrink. What
//! remains is neither built nor moved.

use super::leaf_column::RowKey;
use super::tree_parts::TreePart;
use super::{Bvh, Child, Node};
use glam::Vec3;
use phalanx_scene::Bounds;
use std::collections::HashSet;
use std::ops::Range;

/// Number of boxes that are looked for one by one; more are looked for as one.
const MAX_BOXES: usize = 16;

/// A box around everything.
pub(super) const EVERYTHING: Bounds = Bounds {
    lo: Vec3::NEG_INFINITY,
    hi: Vec3::INFINITY,
};

/// What leaves a tree.
#[derive(Default)]
pub(in crate::bvh) struct Leaving {
    /// Runs of primitives; ascending once they are looked for.
    prims: Vec<Range<u32>>,
    instances: HashSet<RowKey>,
    /// Boxes that hold all of it, as it lies in the tree.
    boxes: Vec<Bounds>,
}

impl Leaving {
    /// Adds primitives; `bounds` is their box in the tree.
    pub(super) fn add_prims(&mut self, prims: Range<u32>, bounds: Bounds) {
        let after = self.prims.partition_point(|run| run.start < prims.start);
        self.prims.insert(after, prims);
        self.add_box(bounds);
    }

    /// Adds an instance; `bounds` is its box in the tree.
    pub(super) fn add_instance(&mut self, row: RowKey, bounds: Bounds) {
        self.instances.insert(row);
        self.add_box(bounds);
    }

    fn add_box(&mut self, bounds: Bounds) {
        if self.boxes.len() == MAX_BOXES {
            let all = self.boxes.drain(..).fold(Bounds::EMPTY, Bounds::union);
            self.boxes.push(all);
        }
        self.boxes.push(bounds);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.prims.is_empty() && self.instances.is_empty()
    }

    /// Returns true if something that leaves may be in a box.
    pub(in crate::bvh) fn may_be_in(&self, bounds: &Bounds) -> bool {
        let overlaps =
            |own: &Bounds| own.lo.cmple(bounds.hi).all() && bounds.lo.cmple(own.hi).all();
        self.boxes.iter().any(overlaps)
    }

    /// Returns true if a row stays.
    pub(in crate::bvh) fn spares(&self, row: RowKey) -> bool {
        match row {
            RowKey::Prim(prim) => {
                let after = self.prims.partition_point(|run| run.start <= prim);
                after == 0 || prim >= self.prims[after - 1].end
            }
            instance @ RowKey::Instance(..) => !self.instances.contains(&instance),
        }
    }
}

impl Bvh {
    /// Removes rows from a part.
    pub(super) fn erase(&mut self, part: &mut TreePart, leaving: &Leaving) {
        let slots = &mut self.slots;
        let nodes = self.nodes.make_mut();
        let (mut visited, mut waiting) = (Vec::new(), vec![part.nodes.start as u32]);
        let costs = |nodes: &[Node], visited: &[u32]| {
            let all = visited.iter().map(|&index| &nodes[index as usize]);
            all.map(Node::weighted_cost).sum::<f64>()
        };
        while let Some(index) = waiting.pop() {
            visited.push(index);
            let node = &nodes[index as usize];
            let below = [0, 1]
                .into_iter()
                .filter(|&k| leaving.may_be_in(&node.bounds(k)));
            waiting.extend(below.filter_map(|k| match node.child(k) {
                Child::Node(child) => Some(child),
                Child::Leaf { .. } => None,
            }));
        }
        part.weighted_cost -= costs(nodes, &visited);
        // Children were visited after their parents.
        for &index in visited.iter().rev() {
            for k in 0..2 {
                let node = &nodes[index as usize];
                if !leaving.may_be_in(&node.bounds(k)) {
                    continue;
                }
                let (child, bounds) = match node.child(k) {
                    Child::Node(child) => {
                        (Child::Node(child), nodes[child as usize].child_bounds())
                    }
                    Child::Leaf { kind, first, count } => {
                        let rows = first as usize..(first + count) as usize;
                        let column = slots.leaf_column_mut(kind);
                        let (count, bounds) = column.retain(rows, &|row| leaving.spares(row));
                        (Child::Leaf { kind, first, count }, bounds)
                    }
                };
                let child = if bounds.is_empty() { Child::EMPTY } else { child };
                nodes[index as usize].set_child(k, child);
                nodes[index as usize].set_box(k, bounds);
            }
        }
        part.weighted_cost += costs(nodes, &visited);
        // The rows of triangles have changed places.
        part.corners = Vec::new();
    }
}
