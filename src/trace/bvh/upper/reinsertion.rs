//! Optimisation by reinsertion: a node and its parent are removed, and reinserted where the tree's
//! area grows least (Bittner, Hapala and Havran, "Fast Insertion-Based Optimization of Bounding
//! Volume Hierarchies", 2013; the search is that of Meister and Bittner, "Parallel Reinsertion for
//! Bounding Volume Hierarchy Optimization", 2018).
//!
//! Nodes are processed one after another, largest first, and each sees the tree that its
//! predecessors left. So there are no conflicts, and the tree does not depend on threads.

use super::upper_tree::{UpperContent, UpperTree};
use phalanx_scene::Bounds;

/// Number of passes over all nodes.
const PASSES: usize = 2;

/// Reinserts every node for which that saves area.
pub(super) fn reinsert_all(tree: &mut UpperTree) {
    let mut waiting = Vec::new();
    for _ in 0..PASSES {
        let mut by_area: Vec<u32> = (0..tree.nodes.len() as u32).collect();
        let area = |&k: &u32| tree.nodes[k as usize].bounds.half_area();
        by_area.sort_by(|a, b| area(b).total_cmp(&area(a)));
        for node in by_area {
            if let Some(at) = tree.best_position(node, &mut waiting) {
                tree.reinsert(node, at);
            }
        }
    }
}

impl UpperTree {
    fn bounds(&self, index: u32) -> Bounds {
        self.nodes[index as usize].bounds
    }

    fn parent(&self, index: u32) -> u32 {
        self.nodes[index as usize].parent
    }

    /// The other child of a node's parent.
    fn sibling(&self, index: u32) -> u32 {
        match self.nodes[self.parent(index) as usize].content {
            UpperContent::Children([first, second]) if first == index => second,
            UpperContent::Children([first, _]) => first,
            UpperContent::Below { .. } => index,
        }
    }

    /// The sibling that saves most area for a node; `None` if its current position is best.
    /// `waiting` is memory for the search.
    fn best_position(&self, node: u32, waiting: &mut Vec<(u32, f32)>) -> Option<u32> {
        if node == self.root {
            return None;
        }
        let bounds = self.bounds(node);
        let least = bounds.half_area();
        let mut best = (0.0, None);
        let parent = self.parent(node);
        // The area that the removal saves above the position being searched.
        let mut saved = self.bounds(parent).half_area();
        let mut pivot = parent;
        let mut outside = self.sibling(node);
        // The pivot's box without the node.
        let mut rest = self.bounds(outside);
        loop {
            waiting.push((outside, saved));
            while let Some((at, saved)) = waiting.pop() {
                if saved - least <= best.0 {
                    continue;
                }
                let own = self.bounds(at);
                let left = saved - own.union(bounds).half_area();
                if left > best.0 {
                    best = (left, Some(at));
                }
                if let UpperContent::Children(children) = self.nodes[at as usize].content {
                    let below = left + own.half_area();
                    waiting.extend(children.map(|child| (child, below)));
                }
            }
            if pivot != parent {
                rest = rest.union(self.bounds(outside));
                saved += self.bounds(pivot).half_area() - rest.half_area();
            }
            if pivot == self.root {
                return best.1;
            }
            outside = self.sibling(pivot);
            pivot = self.parent(pivot);
        }
    }

    /// Makes a node the sibling of another, which is not below it. Its parent moves with it.
    fn reinsert(&mut self, node: u32, at: u32) {
        let parent = self.parent(node);
        let sibling = self.sibling(node);
        self.replace(parent, sibling);
        let above_sibling = self.parent(sibling);
        self.replace(at, parent);
        self.nodes[at as usize].parent = parent;
        self.nodes[node as usize].parent = parent;
        self.nodes[parent as usize].content = UpperContent::Children([at, node]);
        if sibling != self.root {
            self.refit_from(above_sibling);
        }
        self.refit_from(parent);
    }

    /// Puts a node in another's position under its parent, or at the root.
    fn replace(&mut self, old: u32, new: u32) {
        let above = self.parent(old);
        if old == self.root {
            self.root = new;
            self.nodes[new as usize].parent = new;
            return;
        }
        self.nodes[new as usize].parent = above;
        if let UpperContent::Children(children) = &mut self.nodes[above as usize].content {
            let place = children.iter_mut().find(|child| **child == old);
            place.into_iter().for_each(|child| *child = new);
        }
    }

    /// Recomputes the boxes of a node and of all above it.
    fn refit_from(&mut self, mut index: u32) {
        loop {
            if let UpperContent::Children([a, b]) = self.nodes[index as usize].content {
                self.nodes[index as usize].bounds = self.bounds(a).union(self.bounds(b));
            }
            if index == self.root {
                return;
            }
            index = self.parent(index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::upper_tree::UpperNode;
    use super::*;
    use crate::bvh::Child;
    use glam::Vec3;

    /// Checks that the tree holds `leaves` parts once, and that its boxes and parents are right.
    /// Returns the sum of the areas of its inner nodes.
    fn check(tree: &UpperTree, leaves: usize) -> f32 {
        let mut seen = vec![0; tree.nodes.len()];
        let mut area = 0.0;
        let mut waiting = vec![tree.root];
        while let Some(index) = waiting.pop() {
            seen[index as usize] += 1;
            let node = &tree.nodes[index as usize];
            if let UpperContent::Children(children) = node.content {
                let [a, b] = children.map(|child| tree.bounds(child));
                assert_eq!(node.bounds, a.union(b));
                assert!(children.iter().all(|&child| tree.parent(child) == index));
                area += node.bounds.half_area();
                waiting.extend(children);
            }
        }
        assert!(seen.iter().all(|&count| count == 1));
        let parts = tree.nodes.iter();
        let parts = parts.filter(|node| matches!(node.content, UpperContent::Below { .. }));
        assert_eq!(parts.count(), leaves);
        area
    }

    /// A tree that joins boxes along a row one after another, in an order that has nothing to do
    /// with the row.
    fn chain(count: u32) -> UpperTree {
        let mut tree = UpperTree {
            nodes: Vec::new(),
            root: 0,
            opened: Vec::new(),
        };
        let mut push = |bounds, content| {
            let node = UpperNode {
                bounds,
                parent: 0,
                content,
            };
            tree.nodes.push(node);
            tree.nodes.len() as u32 - 1
        };
        let mut all: Option<(u32, Bounds)> = None;
        for k in 0..count {
            let at = Vec3::X * (k * 37 % count) as f32;
            let bounds = Bounds::new(at, at + Vec3::ONE);
            let child = Child::Node(k);
            let part = push(bounds, UpperContent::Below { chunk: 0, child });
            all = Some(match all {
                None => (part, bounds),
                Some((whole, around)) => {
                    let around = around.union(bounds);
                    (push(around, UpperContent::Children([whole, part])), around)
                }
            });
        }
        tree.root = all.map_or(0, |(root, _)| root);
        for index in 0..tree.nodes.len() {
            if let UpperContent::Children(children) = tree.nodes[index].content {
                for child in children {
                    tree.nodes[child as usize].parent = index as u32;
                }
            }
        }
        let root = tree.root;
        tree.nodes[root as usize].parent = root;
        tree
    }

    #[test]
    fn reinsertion_saves_area_and_loses_nothing() {
        for count in [1, 2, 3, 4, 9, 100] {
            let mut tree = chain(count);
            let before = check(&tree, count as usize);
            reinsert_all(&mut tree);
            let after = check(&tree, count as usize);
            assert!(after <= before, "{count}: {before} to {after}");
            assert!(count < 100 || after < before / 4.0, "{before} to {after}");
        }
    }
}
