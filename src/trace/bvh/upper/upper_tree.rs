//! The tree of the divisions, down to the largest nodes of the chunks.

use crate::bvh::clustering::ChunkTree;
use crate::bvh::reinsertion::{MovableTree, TreeBox};
use crate::bvh::{Child, Node};
use phalanx_scene::Bounds;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Number of chunk nodes that become upper nodes: this number, plus a share of all nodes.
const OPENED: usize = 1024;
const NODES_PER_OPENED: usize = 256;

/// A tree over parts of chunks.
pub(in crate::bvh) struct UpperTree {
    pub(super) nodes: Vec<UpperNode>,
    pub(super) root: u32,
    /// The chunk nodes that have become upper nodes, by chunk, ascending.
    pub(super) opened: Vec<Vec<u32>>,
}

pub(super) struct UpperNode {
    pub(super) bounds: Bounds,
    /// Index of the parent; the root's own for the root.
    pub(super) parent: u32,
    pub(super) content: UpperContent,
}

#[derive(Clone, Copy)]
pub(super) enum UpperContent {
    /// The indices of both children.
    Children([u32; 2]),
    /// Everything below a child of a chunk's node.
    Below { chunk: u32, child: Child },
}

/// A node that may be opened, ordered by area, largest first.
#[derive(PartialEq)]
struct NodeByArea {
    area: f32,
    index: u32,
}

impl Eq for NodeByArea {}

impl PartialOrd for NodeByArea {
    fn partial_cmp(&self, other: &NodeByArea) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for NodeByArea {
    fn cmp(&self, other: &NodeByArea) -> Ordering {
        let by_area = self.area.total_cmp(&other.area);
        by_area.then(other.index.cmp(&self.index))
    }
}

impl UpperTree {
    /// The tree of divisions, with the largest nodes of the chunks.
    pub(super) fn new(is_chunk: &[bool], chunks: &[ChunkTree]) -> UpperTree {
        let mut tree = UpperTree {
            nodes: Vec::with_capacity(is_chunk.len()),
            root: 0,
            opened: vec![Vec::new(); chunks.len()],
        };
        tree.add_divisions(&mut is_chunk.iter(), &mut (0..).zip(chunks), 0);
        let all: usize = chunks.iter().map(|chunk| chunk.nodes.len()).sum();
        tree.open(chunks, OPENED + all / NODES_PER_OPENED);
        tree
    }

    /// Adds the next subtree of the remaining divisions; returns its index.
    fn add_divisions<'c>(
        &mut self,
        is_chunk: &mut std::slice::Iter<bool>,
        chunks: &mut impl Iterator<Item = (u32, &'c ChunkTree<'c>)>,
        parent: u32,
    ) -> u32 {
        let index = self.nodes.len() as u32;
        self.nodes.push(UpperNode {
            bounds: Bounds::EMPTY,
            parent,
            content: UpperContent::Children([0; 2]),
        });
        let divided = is_chunk.next() == Some(&false);
        let (bounds, content) = if divided {
            let parts = [(); 2].map(|()| self.add_divisions(is_chunk, chunks, index));
            let [a, b] = parts.map(|part| self.nodes[part as usize].bounds);
            (a.union(b), UpperContent::Children(parts))
        } else {
            let of_chunk = |(chunk, tree): (u32, &ChunkTree)| {
                let child = tree.root;
                (tree.bounds, UpperContent::Below { chunk, child })
            };
            let nothing = (Bounds::EMPTY, UpperContent::Children([0; 2]));
            chunks.next().map_or(nothing, of_chunk)
        };
        let node = &mut self.nodes[index as usize];
        (node.bounds, node.content) = (bounds, content);
        index
    }

    /// Turns the largest nodes of the chunks into upper nodes.
    fn open(&mut self, chunks: &[ChunkTree], count: usize) {
        let by_area = |(index, node): (usize, &UpperNode)| NodeByArea {
            area: node.bounds.half_area(),
            index: index as u32,
        };
        let mut largest: BinaryHeap<NodeByArea> =
            self.nodes.iter().enumerate().map(by_area).collect();
        let mut left = count;
        while left > 0 {
            let Some(NodeByArea { index, .. }) = largest.pop() else {
                break;
            };
            let UpperContent::Below {
                chunk,
                child: Child::Node(local),
            } = self.nodes[index as usize].content
            else {
                continue;
            };
            left -= 1;
            self.opened[chunk as usize].push(local);
            let node: &Node = &chunks[chunk as usize].nodes[local as usize];
            let first = self.nodes.len() as u32;
            for k in 0..2 {
                self.nodes.push(UpperNode {
                    bounds: node.bounds(k),
                    parent: index,
                    content: UpperContent::Below {
                        chunk,
                        child: node.child(k),
                    },
                });
                let index = first as usize + k;
                largest.push(by_area((index, &self.nodes[index])));
            }
            self.nodes[index as usize].content = UpperContent::Children([first, first + 1]);
        }
        for opened in &mut self.opened {
            opened.sort_unstable();
        }
    }
}

impl TreeBox for Bounds {
    fn union(self, other: Bounds) -> Bounds {
        self.union(other)
    }

    fn half_area(self) -> f32 {
        self.half_area()
    }
}

impl MovableTree for UpperTree {
    type Box = Bounds;

    fn len(&self) -> usize {
        self.nodes.len()
    }

    fn root(&self) -> u32 {
        self.root
    }

    fn bounds(&self, index: u32) -> Bounds {
        self.nodes[index as usize].bounds
    }

    fn parent(&self, index: u32) -> u32 {
        self.nodes[index as usize].parent
    }

    fn sibling(&self, index: u32) -> u32 {
        match self.children(self.parent(index)) {
            Some([first, second]) if first == index => second,
            Some([first, _]) => first,
            None => index,
        }
    }

    fn children(&self, index: u32) -> Option<[u32; 2]> {
        match self.nodes[index as usize].content {
            UpperContent::Children(children) => Some(children),
            UpperContent::Below { .. } => None,
        }
    }

    /// The node's parent moves with it.
    fn reinsert(&mut self, node: u32, target: u32) {
        let parent = self.parent(node);
        let sibling = self.sibling(node);
        self.replace(parent, sibling);
        let above_sibling = self.parent(sibling);
        self.replace(target, parent);
        self.nodes[target as usize].parent = parent;
        self.nodes[node as usize].parent = parent;
        self.nodes[parent as usize].content = UpperContent::Children([target, node]);
        if sibling != self.root {
            self.refit_from(above_sibling);
        }
        self.refit_from(parent);
    }
}

impl UpperTree {
    /// Puts a node in another's position under its parent, or at the root.
    fn replace(&mut self, old: u32, new: u32) {
        let grandparent = self.parent(old);
        if old == self.root {
            self.root = new;
            self.nodes[new as usize].parent = new;
            return;
        }
        self.nodes[new as usize].parent = grandparent;
        if let UpperContent::Children(children) = &mut self.nodes[grandparent as usize].content {
            let place = children.iter_mut().find(|child| **child == old);
            place.into_iter().for_each(|child| *child = new);
        }
    }

    /// Recomputes the boxes of a node and of all above it.
    fn refit_from(&mut self, mut index: u32) {
        loop {
            if let Some([a, b]) = self.children(index) {
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
    use super::*;
    use crate::bvh::reinsertion::reinsert_largest;
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
            let corner = Vec3::X * (k * 37 % count) as f32;
            let bounds = Bounds::new(corner, corner + Vec3::ONE);
            let child = Child::Node(k);
            let part = push(bounds, UpperContent::Below { chunk: 0, child });
            all = Some(match all {
                None => (part, bounds),
                Some((rest, around)) => {
                    let around = around.union(bounds);
                    (push(around, UpperContent::Children([rest, part])), around)
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
            reinsert_largest(&mut tree, &[1.0, 1.0]);
            let after = check(&tree, count as usize);
            assert!(after <= before, "{count}: {before} to {after}");
            assert!(count < 100 || after < before / 4.0, "{before} to {after}");
        }
    }
}
