//! The tree of the divisions, down to the largest nodes of the chunks.

use crate::bvh::clustering::ChunkTree;
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
        chunks: &mut impl Iterator<Item = (u32, &'c ChunkTree)>,
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
                let [lo, hi] = node.boxes[k].map(glam::Vec3::from);
                self.nodes.push(UpperNode {
                    bounds: Bounds::new(lo, hi),
                    parent: index,
                    content: UpperContent::Below {
                        chunk,
                        child: node.child(k),
                    },
                });
                largest.push(by_area((
                    first as usize + k,
                    &self.nodes[first as usize + k],
                )));
            }
            self.nodes[index as usize].content = UpperContent::Children([first, first + 1]);
        }
        for opened in &mut self.opened {
            opened.sort_unstable();
        }
    }
}
