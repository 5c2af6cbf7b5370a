//! Offsets of a tree's rows in arrays shared with other trees.

use super::{Child, LeafKind, Node};

/// Offsets of a tree's nodes and slots in the shared arrays.
#[derive(Clone, Copy, Default)]
pub(super) struct Offsets {
    pub(super) node: u32,
    pub(super) slot: [u32; LeafKind::COUNT],
}

impl Offsets {
    /// Offsets of nodes only.
    pub(super) fn of_nodes(node: usize) -> Offsets {
        Offsets {
            node: node as u32,
            slot: [0; LeafKind::COUNT],
        }
    }

    /// A reference within a tree, converted to the shared arrays.
    #[inline(always)]
    pub(super) fn rebased(&self, child: Child) -> Child {
        match child {
            Child::Node(index) => Child::Node(self.node.wrapping_add(index)),
            Child::Leaf { count: 0, .. } => child,
            Child::Leaf { kind, first, count } => Child::Leaf {
                kind,
                first: first + self.slot[kind.number()],
                count,
            },
        }
    }

    /// Converts all nodes of a tree to the shared arrays.
    pub(super) fn rebase_nodes(&self, nodes: &mut [Node]) {
        for node in nodes {
            for k in 0..2 {
                node.set_child(k, self.rebased(node.child(k)));
            }
        }
    }
}
