//! Rows of memory asked for before they are needed.

use crate::bvh::{ChildRef, SphereBlock, TriangleBlock, WideBvh, WideNode};

const LINE: usize = 64;

/// Lines of a node; blocks have up to three more.
const NODE: usize = size_of::<WideNode>() / LINE;

/// Lines that a block of triangles has more.
const MORE: usize = size_of::<TriangleBlock>() / LINE - NODE;

const _: () = assert!(
    size_of::<TriangleBlock>() == (NODE + MORE) * LINE
        && size_of::<SphereBlock>() <= (NODE + MORE + 1) * LINE,
    "the first lines and the last ones are almost all of a row"
);

/// Where a tree's rows are, by kind of target. A table and no match: which kind comes next cannot
/// be foretold, and a branch that goes wrong costs more than the row.
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
                // The first of them will do: there are few, and what they lead to is elsewhere.
                0,
            ],
        }
    }

    /// Asks for what a child of a wide node leads to.
    #[inline(always)]
    pub(super) fn prefetch(&self, code: u32) {
        let (kind, index) = ChildRef::parts(code);
        let size = self.size[kind];
        let row = self.start[kind].wrapping_add(index * size);
        node_at(row);
        // The last ones, which are among the others where a row is short: cheaper than to ask
        // whether it is.
        let end = row.wrapping_add(size);
        for line in 1..=MORE {
            line_at(end.wrapping_sub(line * LINE));
        }
    }

    /// The same where it leads to a node. Where it does not, asks for the root, which is near
    /// anyway: no branch.
    #[inline(always)]
    pub(super) fn prefetch_node(&self, code: u32) {
        let (kind, index) = ChildRef::parts(code);
        let index = if kind == 0 { index } else { 0 };
        node_at(self.start[0].wrapping_add(index * size_of::<WideNode>()));
    }
}

#[inline(always)]
fn node_at(row: usize) {
    for line in 0..NODE {
        line_at(row.wrapping_add(line * LINE));
    }
}

/// Has the lines of a row brought to the first cache. Does nothing where the architecture is not
/// x86-64.
#[inline(always)]
pub(super) fn prefetch<T>(rows: &[T], index: u32) {
    let row = rows.as_ptr().wrapping_add(index as usize).addr();
    for line in 0..size_of::<T>().div_ceil(LINE) {
        line_at(row.wrapping_add(LINE * line));
    }
}

#[inline(always)]
fn line_at(address: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let line = std::ptr::without_provenance::<i8>(address);
        // SAFETY: every x86-64 has the instruction, and it has no effect but on caches, whatever
        // the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}
