//! Conversion of a binary tree over a chunk, such as its merges, to nodes, depth first, and to
//! objects in leaf order.

use super::clusters::ClusterRef;
use super::merge::Merges;
use crate::bvh::prim_ref::{PrimIndex, PrimRef};
use crate::bvh::{Child, LeafKind, Node};
use bumpalo::Bump;
use phalanx_scene::Bounds;

/// A tree over a chunk. Its nodes are stored depth first, so that a node is followed by everything
/// below it; nodes and slots are numbered from the chunk's start.
pub(in crate::bvh) struct ChunkTree<'a> {
    pub(in crate::bvh) root: Child,
    pub(in crate::bvh) bounds: Bounds,
    pub(in crate::bvh) nodes: &'a [Node],
    pub(in crate::bvh) leaves: LeafObjects,
}

/// The objects of a chunk in leaf order.
pub(in crate::bvh) struct LeafObjects {
    pub(in crate::bvh) objects: Vec<PrimIndex>,
    /// Number of objects by kind.
    pub(in crate::bvh) slots: [u32; LeafKind::COUNT],
}

impl LeafObjects {
    pub(in crate::bvh) fn with_room(objects: usize) -> LeafObjects {
        LeafObjects {
            objects: Vec::with_capacity(objects),
            slots: [0; LeafKind::COUNT],
        }
    }

    /// The leaf of the objects from `start` on, which are of one kind.
    pub(in crate::bvh) fn leaf_from(&mut self, start: usize, kind: LeafKind) -> Child {
        let count = (self.objects.len() - start) as u32;
        let slot = &mut self.slots[kind.number()];
        let first = *slot;
        *slot += count;
        Child::Leaf { kind, first, count }
    }
}

/// A binary tree over the objects of a chunk, to be converted to nodes.
pub(in crate::bvh) trait BinaryTree {
    /// A subtree.
    type Subtree;

    fn bounds(&self, subtree: &Self::Subtree) -> Bounds;

    /// Places the objects of a leaf, which are of one kind; `None` for a subtree that has to be
    /// split.
    fn place_leaf(&mut self, subtree: &Self::Subtree, leaves: &mut LeafObjects) -> Option<Child>;

    /// The two parts of a subtree that is not a leaf, in the order of the node's children.
    fn split(&self, subtree: Self::Subtree) -> [Self::Subtree; 2];
}

/// Reusable memory for the nodes of a chunk.
pub(in crate::bvh) struct EmittedNodes<S> {
    nodes: Vec<Node>,
    /// Subtrees that become nodes, with their parent and their index in it.
    stack: Vec<(S, Option<(u32, usize)>)>,
}

impl<S> Default for EmittedNodes<S> {
    fn default() -> EmittedNodes<S> {
        EmittedNodes {
            nodes: Vec::new(),
            stack: Vec::new(),
        }
    }
}

impl<S> EmittedNodes<S> {
    /// The nodes and the objects of a tree over `objects` objects. Nodes are written depth first
    /// with an explicit stack: a tree may be deeper than the thread's stack allows.
    pub(in crate::bvh) fn run<'a>(
        &mut self,
        tree: &mut impl BinaryTree<Subtree = S>,
        root: S,
        objects: usize,
        arena: &'a Bump,
    ) -> ChunkTree<'a> {
        let mut leaves = LeafObjects::with_room(objects);
        let bounds = tree.bounds(&root);
        self.nodes.clear();
        let root = tree.place_leaf(&root, &mut leaves).unwrap_or_else(|| {
            self.stack.push((root, None));
            Child::Node(0)
        });
        while let Some((subtree, parent)) = self.stack.pop() {
            let index = self.nodes.len() as u32;
            let mut children = [(Child::EMPTY, Bounds::EMPTY); 2];
            let pushed = self.stack.len();
            for (k, part) in tree.split(subtree).into_iter().enumerate() {
                let bounds = tree.bounds(&part);
                let child = tree.place_leaf(&part, &mut leaves).unwrap_or_else(|| {
                    self.stack.push((part, Some((index, k))));
                    // The index is set when the node is written.
                    Child::Node(0)
                });
                children[k] = (child, bounds);
            }
            self.nodes.push(Node::new(children));
            if let Some((parent, k)) = parent {
                self.nodes[parent as usize].set_child(k, Child::Node(index));
            }
            // The first child is popped next, so that it follows its parent in memory.
            self.stack[pushed..].reverse();
        }
        ChunkTree {
            root,
            bounds,
            leaves,
            nodes: arena.alloc_slice_copy(&self.nodes),
        }
    }
}

/// The tree of a chunk's merges, which refer to objects in `sorted`.
pub(super) struct MergeTree<'a> {
    pub(super) merges: &'a Merges,
    pub(super) sorted: &'a [PrimRef],
    /// Reusable memory for clusters of a leaf whose objects are still to be placed.
    pub(super) waiting: &'a mut Vec<ClusterRef>,
}

impl BinaryTree for MergeTree<'_> {
    type Subtree = ClusterRef;

    fn bounds(&self, cluster: &ClusterRef) -> Bounds {
        match cluster.index() {
            Ok(merge) => {
                let [x0, y0, z0, x1, y1, z1] = self.merges.get(merge).planes;
                Bounds::new([x0, y0, z0].into(), [x1, y1, z1].into())
            }
            Err(object) => self.sorted[object].bounds(),
        }
    }

    fn place_leaf(&mut self, cluster: &ClusterRef, leaves: &mut LeafObjects) -> Option<Child> {
        let merge = cluster.index();
        if merge.is_ok_and(|merge| !self.merges.get(merge).is_leaf) {
            return None;
        }
        let start = leaves.objects.len();
        let mut kind = LeafKind::TRIANGLE;
        self.waiting.push(*cluster);
        while let Some(cluster) = self.waiting.pop() {
            match cluster.index() {
                Ok(merge) => {
                    let [first, second] = self.merges.get(merge).parts;
                    self.waiting.extend([second, first]);
                }
                Err(object) => {
                    kind = self.sorted[object].kind();
                    leaves.objects.push(self.sorted[object].object);
                }
            }
        }
        Some(leaves.leaf_from(start, kind))
    }

    /// The larger part comes first.
    fn split(&self, cluster: ClusterRef) -> [ClusterRef; 2] {
        let Ok(merge) = cluster.index() else {
            unreachable!("objects are leaves");
        };
        let mut parts = self.merges.get(merge).parts;
        let [first, second] = parts.map(|part| self.bounds(&part).half_area());
        if first < second {
            parts.reverse();
        }
        parts
    }
}
