//! Conversion of obvhs's tree: nodes depth first, leaves of one kind, objects in leaf order.

use crate::bvh::Child;
use crate::bvh::clustering::{BinaryTree, ChunkTree, EmittedNodes, LeafObjects};
use crate::bvh::prim_ref::PrimRef;
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
pub(super) enum Pending {
    /// obvhs's node at this index.
    Obvhs(usize),
    /// Objects of a leaf, sorted by kind and number.
    Leaf(Vec<PrimRef>),
}

impl<'a> ObvhsTree<'a> {
    pub(super) fn new(tree: &'a Bvh2, objects: &'a [PrimRef]) -> ObvhsTree<'a> {
        ObvhsTree { tree, objects }
    }

    /// Converts all nodes.
    pub(super) fn convert<'n>(mut self, arena: &'n Bump) -> ChunkTree<'n> {
        let (root, objects) = (self.pending(0), self.objects.len());
        EmittedNodes::default().run(&mut self, root, objects, arena)
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
}

impl BinaryTree for ObvhsTree<'_> {
    type Subtree = Pending;

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

    fn place_leaf(&mut self, pending: &Pending, leaves: &mut LeafObjects) -> Option<Child> {
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
}
