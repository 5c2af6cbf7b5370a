//! Optimisation by reinsertion: a node and its parent are removed, and reinserted where the tree's
//! area grows least (Bittner, Hapala and Havran, "Fast Insertion-Based Optimization of Bounding
//! Volume Hierarchies", 2013; the search is that of Meister and Bittner, "Parallel Reinsertion for
//! Bounding Volume Hierarchy Optimization", 2018).
//!
//! Nodes are processed one after another, largest first, and each sees the tree that its
//! predecessors left. So there are no conflicts, the tree does not depend on threads, and it costs
//! less than after as much work on batches of nodes (`perf/notes/builder.md`).

/// A box as a tree stores it.
pub(super) trait TreeBox: Copy {
    /// The box around both.
    fn union(self, other: Self) -> Self;
    /// Half the surface area.
    fn half_area(self) -> f32;
}

/// A binary tree whose nodes can be reinserted.
pub(super) trait MovableTree {
    /// Its boxes.
    type Box: TreeBox;
    /// Number of nodes.
    fn len(&self) -> usize;
    /// Index of the root.
    fn root(&self) -> u32;
    /// Box of a node.
    fn bounds(&self, node: u32) -> Self::Box;
    /// Index of the parent; any for the root.
    fn parent(&self, node: u32) -> u32;
    /// The other child of a node's parent.
    fn sibling(&self, node: u32) -> u32;
    /// Indices of both children; `None` for a leaf.
    fn children(&self, node: u32) -> Option<[u32; 2]>;
    /// Makes a node the sibling of another, which is not below it, and refits all boxes.
    fn reinsert(&mut self, node: u32, target: u32);
}

/// Reinserts the largest nodes for which that saves area, in one pass for each share of all nodes.
pub(super) fn reinsert_largest(tree: &mut impl MovableTree, shares: &[f32]) {
    let mut waiting = Vec::new();
    for share in shares {
        let nodes = 0..tree.len() as u32;
        let mut by_area: Vec<(f32, u32)> = nodes
            .map(|node| (tree.bounds(node).half_area(), node))
            .collect();
        by_area.sort_by(|a, b| b.0.total_cmp(&a.0));
        by_area.truncate((share * by_area.len() as f32) as usize);
        for (_, node) in by_area {
            if let Some(position) = best_position(tree, node, &mut waiting) {
                tree.reinsert(node, position);
            }
        }
    }
}

/// The sibling that saves most area for a node; `None` if its current position is best. `waiting`
/// is memory for the search.
fn best_position(tree: &impl MovableTree, node: u32, waiting: &mut Vec<(u32, f32)>) -> Option<u32> {
    if node == tree.root() {
        return None;
    }
    let bounds = tree.bounds(node);
    let least = bounds.half_area();
    let mut best = (0.0, None);
    let parent = tree.parent(node);
    // The area that the removal saves above the position being searched.
    let mut saved = tree.bounds(parent).half_area();
    let mut pivot = parent;
    let mut outside = tree.sibling(node);
    // The pivot's box without the node.
    let mut rest = tree.bounds(outside);
    loop {
        waiting.push((outside, saved));
        while let Some((position, saved)) = waiting.pop() {
            if saved - least <= best.0 {
                continue;
            }
            let own = tree.bounds(position);
            let left = saved - own.union(bounds).half_area();
            if left > best.0 {
                best = (left, Some(position));
            }
            let below = left + own.half_area();
            if below - least > best.0
                && let Some([first, second]) = tree.children(position)
            {
                waiting.push((first, below));
                waiting.push((second, below));
            }
        }
        if pivot != parent {
            rest = rest.union(tree.bounds(outside));
            saved += tree.bounds(pivot).half_area() - rest.half_area();
        }
        if pivot == tree.root() {
            return best.1;
        }
        outside = tree.sibling(pivot);
        pivot = tree.parent(pivot);
    }
}
