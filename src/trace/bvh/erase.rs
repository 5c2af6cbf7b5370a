//! Primitives and instances that leave a tree: their rows go, and the boxes above them shrink. What
//! remains is neither built nor moved.

use super::leaving::Leaving;
use super::subtree::relative_cost;
use super::tree_parts::TreePart;
use super::{Bvh, Child};

impl Bvh {
    /// Removes rows from a part; returns how many.
    pub(super) fn erase(&mut self, part: &mut TreePart, leaving: &Leaving) -> u32 {
        let (slots, nodes) = (&mut self.slots, self.nodes.make_mut());
        let first = part.nodes.start;
        let (mut visited, mut waiting) = (Vec::new(), vec![first as u32]);
        while let Some(index) = waiting.pop() {
            visited.push(index);
            let node = &nodes[index as usize];
            for k in 0..2 {
                if let Child::Node(child) = node.child(k)
                    && leaving.may_be_in(&node.bounds(k))
                {
                    waiting.push(child);
                }
            }
        }
        let before = relative_cost(part.weighted_cost, nodes[first].child_bounds());
        let mut erased = 0;
        let mut shrunk = vec![false; part.nodes.len()];
        // Children were visited after their parents.
        for &index in visited.iter().rev() {
            let node = nodes[index as usize];
            let mut smaller = node;
            for k in (0..2).filter(|&k| leaving.may_be_in(&node.bounds(k))) {
                let rest = match node.child(k) {
                    Child::Node(child) if shrunk[child as usize - first] => {
                        Some((Child::Node(child), nodes[child as usize].child_bounds()))
                    }
                    Child::Node(_) => None,
                    Child::Leaf { kind, first, count } => {
                        let rows = first as usize..(first + count) as usize;
                        let rest = slots.leaf_column_mut(kind).retain(rows, leaving);
                        rest.map(|(staying, bounds)| {
                            erased += count - staying;
                            let count = staying;
                            (Child::Leaf { kind, first, count }, bounds)
                        })
                    }
                };
                if let Some((child, bounds)) = rest {
                    smaller.set_child(k, if bounds.is_empty() { Child::EMPTY } else { child });
                    smaller.set_box(k, bounds);
                    shrunk[index as usize - first] = true;
                }
            }
            if shrunk[index as usize - first] {
                part.weighted_cost += smaller.weighted_cost() - node.weighted_cost();
                nodes[index as usize] = smaller;
            }
        }
        // A fresh tree would be as much cheaper, so that the growth stays what it was.
        let rest = relative_cost(part.weighted_cost, nodes[first].child_bounds());
        if before > 0.0 {
            part.built_cost *= rest / before;
        }
        // The rows of triangles have changed places.
        part.corners = Vec::new();
        erased
    }
}
