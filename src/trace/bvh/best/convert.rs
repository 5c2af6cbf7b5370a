//! Conversion of obvhs's tree: nodes depth first, leaves of one kind, objects in leaf order.

use crate::bvh::clustering::{ChunkTree, LeafObjects};
use crate::bvh::prim_ref::PrimRef;
use crate::bvh::{Child, Node};
use bumpalo::Bump;
use obvhs::bvh2::Bvh2;
use phalanx_scene::Bounds;

/// obvhs's tree over a chunk.
pub(super) struct ObvhsTree<'a> {
    tree: &'a Bvh2,
    /// Objects in the order in which obvhs received them.
    objects: &'a [PrimRef],
}

/// A child that still has to be converted.
enum Pending {
    /// obvhs's node at this index.
    Obvhs(usize),
    /// Objects of a leaf, sorted by kind and number.
    Leaf(Vec<PrimRef>),
}

impl<'a> ObvhsTree<'a> {
    pub(super) fn new(tree: &'a Bvh2, objects: &'a [PrimRef]) -> ObvhsTree<'a> {
        ObvhsTree { tree, objects }
    }

    /// Converts the whole tree.
    pub(super) fn convert<'n>(&self, arena: &'n Bump) -> ChunkTree<'n> {
        let whole = self.pending(0);
        let bounds = self.bounds(&whole);
        let mut leaves = LeafObjects::with_room(self.objects.len());
        let (root, nodes) = match self.leaf(&whole, &mut leaves) {
            Some(leaf) => (leaf, Vec::new()),
            None => (Child::Node(0), self.nodes(whole, &mut leaves)),
        };
        ChunkTree {
            root,
            bounds,
            nodes: arena.alloc_slice_copy(&nodes),
            leaves,
        }
    }

    /// Converts nodes depth first with an explicit stack: a tree may be deeper than the thread's
    /// stack allows. Their objects go to `leaves`.
    fn nodes(&self, whole: Pending, leaves: &mut LeafObjects) -> Vec<Node> {
        let mut nodes: Vec<Node> = Vec::with_capacity(self.tree.nodes.len() / 2);
        // (node to make, parent and child index in it)
        let mut stack = vec![(whole, None)];
        while let Some((pending, parent)) = stack.pop() {
            let index = nodes.len() as u32;
            let mut children = [(Child::EMPTY, Bounds::EMPTY); 2];
            let mut deferred = Vec::new();
            for (k, part) in self.split(pending).into_iter().enumerate() {
                let bounds = self.bounds(&part);
                let child = match self.leaf(&part, leaves) {
                    Some(leaf) => leaf,
                    None => {
                        deferred.push((part, Some((index, k))));
                        Child::Node(u32::MAX)
                    }
                };
                children[k] = (child, bounds);
            }
            nodes.push(Node::new(children));
            if let Some((parent, k)) = parent {
                let parent: &mut Node = &mut nodes[parent as usize];
                parent.set_child(k, Child::Node(index));
            }
            // The first child is popped next, so that it follows its parent in memory.
            stack.extend(deferred.into_iter().rev());
        }
        nodes
    }

    /// The two parts of a subtree that is not a leaf of one kind.
    fn split(&self, pending: Pending) -> [Pending; 2] {
        match pending {
            Pending::Obvhs(index) => {
                let first = self.tree.nodes[index].first_index as usize;
                [first, first + 1].map(|child| self.pending(child))
            }
            Pending::Leaf(mut items) => {
                let kind = items[0].kind();
                let same = |item: &PrimRef| item.kind() == kind;
                let rest = items.split_off(items.partition_point(same));
                [Pending::Leaf(items), Pending::Leaf(rest)]
            }
        }
    }

    fn pending(&self, index: usize) -> Pending {
        let node = &self.tree.nodes[index];
        if node.prim_count == 0 {
            return Pending::Obvhs(index);
        }
        let first = node.first_index as usize;
        let theirs = &self.tree.primitive_indices[first..first + node.prim_count as usize];
        let mut items: Vec<PrimRef> = theirs.iter().map(|&i| self.objects[i as usize]).collect();
        items.sort_by_key(|item| (item.kind(), item.object));
        Pending::Leaf(items)
    }

    fn bounds(&self, pending: &Pending) -> Bounds {
        match pending {
            Pending::Obvhs(index) => {
                let b = self.tree.nodes[*index].aabb();
                Bounds::new(b.min.into(), b.max.into())
            }
            Pending::Leaf(items) => {
                let boxes = items.iter().map(|item| item.bounds());
                boxes.fold(Bounds::EMPTY, Bounds::union)
            }
        }
    }

    /// Places the objects of a leaf of one kind; `None` if the part has to be split further.
    fn leaf(&self, pending: &Pending, leaves: &mut LeafObjects) -> Option<Child> {
        let Pending::Leaf(items) = pending else {
            return None;
        };
        let kind = items[0].kind();
        if items.iter().any(|item| item.kind() != kind) {
            return None;
        }
        let start = leaves.objects.len();
        leaves.objects.extend(items.iter().map(|item| item.object));
        Some(leaves.leaf_from(start, kind))
    }
}
