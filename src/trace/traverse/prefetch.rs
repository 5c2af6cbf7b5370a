//! Prefetching of a tree's rows.

use crate::bvh::leaf::LeafTriangle;
use crate::bvh::{ChildRef, Node, SphereBlock, TriangleBlock, WideBvh, WideNode};
use crate::prefetch::{LINE, line_at};

/// Cache lines of a node; blocks have up to three more.
const NODE: usize = size_of::<WideNode>() / LINE;

/// Cache lines of a block of triangles beyond those of a node.
const MORE: usize = size_of::<TriangleBlock>() / LINE - NODE;

const _: () = assert!(
    size_of::<TriangleBlock>() == (NODE + MORE) * LINE
        && size_of::<SphereBlock>() <= (NODE + MORE + 1) * LINE,
    "the first lines and the last ones are almost all of a row"
);

/// Addresses of a tree's rows, by kind of target. A table instead of a match, because the next kind
/// is unpredictable, and a mispredicted branch costs more than the row.
#[derive(Clone, Copy)]
pub(super) struct PrefetchTable {
    start: [usize; 4],
    size: [usize; 4],
}

impl PrefetchTable {
    pub(super) fn of(wide: &WideBvh) -> PrefetchTable {
        PrefetchTable {
            start: [
                wide.nodes().as_ptr().addr(),
                wide.triangles().as_ptr().addr(),
                wide.spheres().as_ptr().addr(),
                wide.others().as_ptr().addr(),
            ],
            size: [
                size_of::<WideNode>(),
                size_of::<TriangleBlock>(),
                size_of::<SphereBlock>(),
                // The first of them is enough: there are few, and their targets are elsewhere.
                0,
            ],
        }
    }

    /// Prefetches the target of a child of a wide node.
    #[inline(always)]
    pub(super) fn prefetch(&self, code: u32) {
        let (kind, index) = ChildRef::parts(code);
        let size = self.size[kind];
        let row = self.start[kind].wrapping_add(index * size);
        node_at(row);
        // The last lines, which overlap the first ones if a row is short: cheaper than a check.
        let end = row.wrapping_add(size);
        for line in 1..=MORE {
            line_at(end.wrapping_sub(line * LINE));
        }
    }

    /// Prefetches the target of a child if it is a node, else the root, which is cached anyway. So
    /// there is no branch.
    #[inline(always)]
    pub(super) fn prefetch_node(&self, code: u32) {
        let (kind, index) = ChildRef::parts(code);
        let index = if kind == 0 { index } else { 0 };
        node_at(self.start[0].wrapping_add(index * size_of::<WideNode>()));
    }
}

/// Prefetches the first line of both children of a binary node while its boxes are tested. For
/// leaves, only triangles are prefetched; any address will do for other kinds. There is no branch.
#[inline(always)]
pub(super) fn prefetch_children(node: &Node, nodes: &[Node], triangles: &[LeafTriangle]) {
    for k in [0, 1] {
        let (first, tag) = node.packed(k);
        let [below, leaf] = [
            nodes.as_ptr().wrapping_add(first as usize).addr(),
            triangles.as_ptr().wrapping_add(first as usize).addr(),
        ];
        line_at(if tag == 0 { below } else { leaf });
    }
}

#[inline(always)]
fn node_at(row: usize) {
    for line in 0..NODE {
        line_at(row.wrapping_add(line * LINE));
    }
}
