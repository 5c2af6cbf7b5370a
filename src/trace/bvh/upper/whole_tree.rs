//! The complete tree: upper nodes first, then the rest of each chunk in its existing order.

use super::upper_tree::{UpperContent, UpperNode, UpperTree};
use crate::bvh::clustering::ChunkTree;
use crate::bvh::offsets::Offsets;
use crate::bvh::{Child, LeafKind, Node, weighted_cost};
use phalanx_scene::Bounds;
use phalanx_scene::huge_pages::{PartWriter, write_parts};
use std::ops::Range;

/// Nodes of a complete tree, with statistics. Its slots are those of the chunks, one after another.
#[derive(Default)]
pub(in crate::bvh) struct WholeTree {
    /// Nodes; the root is first.
    pub(in crate::bvh) nodes: Vec<Node>,
    pub(in crate::bvh) bounds: Bounds,
    /// Number of nodes on the longest path.
    pub(in crate::bvh) depth: usize,
    /// Σ area · cost over the children of all nodes.
    pub(in crate::bvh) weighted_cost: f64,
    /// Chunks, in order; the upper nodes are those before the first.
    pub(in crate::bvh) chunks: Vec<ChunkRows>,
}

/// First rows of a chunk, which end where those of the next one begin. Its nodes have children
/// among themselves only, and leaves among its triangles.
#[derive(Clone, Copy, Debug)]
pub(in crate::bvh) struct ChunkRows {
    pub(in crate::bvh) node: usize,
    pub(in crate::bvh) triangle: usize,
}

/// Consecutive nodes of a chunk: one node and everything below it.
struct MovedPart {
    from: Range<u32>,
    to: u32,
}

/// New positions of a chunk's nodes.
struct ChunkMove {
    /// Ascending.
    parts: Vec<MovedPart>,
    slots: [u32; LeafKind::COUNT],
}

/// Statistics of a chunk's moved nodes.
#[derive(Default)]
struct MovedFigures {
    /// Number of nodes on the longest path, by part.
    depths: Vec<usize>,
    weighted_cost: f64,
}

impl WholeTree {
    /// Joins upper levels and the chunks below them.
    pub(in crate::bvh) fn new(tree: &UpperTree, chunks: &[ChunkTree]) -> WholeTree {
        let inner = |node: &&UpperNode| matches!(node.content, UpperContent::Children(_));
        // A tree that is a single leaf still has a node.
        let upper = tree.nodes.iter().filter(inner).count().max(1);
        let moves = tree.moves(chunks, upper as u32);
        let len = |moved: &ChunkMove| moved.parts.iter().map(|part| part.from.len()).sum();
        let lens: Vec<usize> = [upper].into_iter().chain(moves.iter().map(len)).collect();
        let (mut nodes, figures) = write_parts(&lens, |k, part| match k.checked_sub(1) {
            Some(k) => moves[k].run(chunks[k].nodes, part),
            None => {
                (0..upper).for_each(|_| part.push(Node::EMPTY));
                MovedFigures::default()
            }
        });
        let figures = &figures[1..];
        let (depth, cost) = tree.emit(&moves, figures, &mut nodes[..upper]);
        WholeTree {
            nodes,
            bounds: tree.nodes[tree.root as usize].bounds,
            depth,
            weighted_cost: cost + figures.iter().map(|f| f.weighted_cost).sum::<f64>(),
            chunks: chunk_rows(&lens, &moves),
        }
    }
}

/// First rows of all chunks; `lens` are the numbers of upper nodes and of each chunk's nodes.
fn chunk_rows(lens: &[usize], moves: &[ChunkMove]) -> Vec<ChunkRows> {
    let mut node = lens[0];
    let chunks = lens[1..].iter().zip(moves).map(|(len, moved)| {
        let triangle = moved.slots[LeafKind::TRIANGLE.number()] as usize;
        let rows = ChunkRows { node, triangle };
        node += len;
        rows
    });
    chunks.collect()
}

impl UpperTree {
    /// New positions of all chunks, with the first node at `to`.
    fn moves(&self, chunks: &[ChunkTree], mut to: u32) -> Vec<ChunkMove> {
        // The starts of parts, and nodes that have become upper nodes.
        let mut marks: Vec<Vec<(u32, bool)>> = Vec::with_capacity(chunks.len());
        marks.extend(self.opened.iter().map(|opened| {
            let gone = opened.iter().map(|&node| (node, false));
            gone.collect()
        }));
        for node in &self.nodes {
            if let UpperContent::Below {
                chunk,
                child: Child::Node(root),
            } = node.content
            {
                marks[chunk as usize].push((root, true));
            }
        }
        let mut slots = [0; LeafKind::COUNT];
        let moves = marks.into_iter().zip(chunks).map(|(mut marks, chunk)| {
            marks.sort_unstable();
            let ends = marks.iter().skip(1).map(|&(node, _)| node);
            let ends = ends.chain([chunk.nodes.len() as u32]);
            let parts = marks.iter().zip(ends).filter(|((_, stays), _)| *stays);
            let parts = parts.map(|(&(start, _), end)| {
                let part = MovedPart {
                    from: start..end,
                    to,
                };
                to += end - start;
                part
            });
            let moved = ChunkMove {
                parts: parts.collect(),
                slots,
            };
            for (first, own) in slots.iter_mut().zip(chunk.leaves.slots) {
                *first += own;
            }
            moved
        });
        moves.collect()
    }

    /// Writes the upper nodes depth first. Returns the depth of the whole, and Σ area · cost over
    /// the children of the upper nodes.
    fn emit(&self, moves: &[ChunkMove], below: &[MovedFigures], top: &mut [Node]) -> (usize, f64) {
        let mut depth = 0;
        let mut cost = 0.0;
        let mut len = 0;
        // (upper node, its parent and its index in it, its depth)
        let mut stack = vec![(self.root, None, 1)];
        while let Some((index, parent, level)) = stack.pop() {
            let node = &self.nodes[index as usize];
            let child = match node.content {
                UpperContent::Children(children) => {
                    let own = len as u32;
                    top[len] = Node::EMPTY;
                    len += 1;
                    depth = depth.max(level);
                    let [mut a, mut b] = children;
                    let [first, second] =
                        children.map(|k| self.nodes[k as usize].bounds.half_area());
                    if first < second {
                        (a, b) = (b, a);
                    }
                    stack.push((b, Some((own, 1)), level + 1));
                    stack.push((a, Some((own, 0)), level + 1));
                    Child::Node(own)
                }
                UpperContent::Below { chunk, child } => {
                    let chunk = chunk as usize;
                    if let Child::Node(root) = child {
                        let part = moves[chunk].part_of(root);
                        depth = depth.max(level - 1 + below[chunk].depths[part]);
                    }
                    moves[chunk].moved(child)
                }
            };
            if let Some((parent, k)) = parent {
                let parent: &mut Node = &mut top[parent as usize];
                parent.set_child(k, child);
                parent.set_box(k, node.bounds);
                cost += weighted_cost(child, node.bounds);
            } else if let Child::Leaf { .. } = child {
                top[0] = Node::new([(child, node.bounds), (Child::EMPTY, Bounds::EMPTY)]);
                (depth, cost) = (1, weighted_cost(child, node.bounds));
            }
        }
        (depth, cost)
    }
}

impl ChunkMove {
    /// The part that contains a node.
    fn part_of(&self, node: u32) -> usize {
        self.parts.partition_point(|part| part.from.start <= node) - 1
    }

    /// Offsets for a part's references.
    fn offsets(&self, part: usize) -> Offsets {
        let MovedPart { from, to } = &self.parts[part];
        Offsets {
            node: to.wrapping_sub(from.start),
            slot: self.slots,
        }
    }

    /// A leaf, or the root of a part.
    fn moved(&self, child: Child) -> Child {
        let offsets = match child {
            Child::Node(root) => self.offsets(self.part_of(root)),
            Child::Leaf { .. } => Offsets {
                node: 0,
                slot: self.slots,
            },
        };
        offsets.rebased(child)
    }

    /// Writes a chunk's nodes in their new order.
    fn run(&self, nodes: &[Node], moved: &mut PartWriter<Node>) -> MovedFigures {
        let mut figures = MovedFigures {
            depths: Vec::with_capacity(self.parts.len()),
            weighted_cost: 0.0,
        };
        let mut levels: Vec<u16> = Vec::new();
        for (k, part) in self.parts.iter().enumerate() {
            let offsets = self.offsets(k);
            let old = &nodes[part.from.start as usize..part.from.end as usize];
            levels.clear();
            levels.resize(old.len(), 1);
            let mut deepest = 1;
            for (k, old) in old.iter().enumerate() {
                let mut new = *old;
                for side in 0..2 {
                    let child = old.child(side);
                    figures.weighted_cost += weighted_cost(child, old.bounds(side));
                    new.set_child(side, offsets.rebased(child));
                    if let Child::Node(index) = child {
                        let level = levels[k] + 1;
                        levels[(index - part.from.start) as usize] = level;
                        deepest = deepest.max(level);
                    }
                }
                moved.push(new);
            }
            figures.depths.push(usize::from(deepest));
        }
        figures
    }
}
