//! Layout of the wide tree from its drafts: positions in order, then all rows at once, on all
//! threads, in their final memory.

use super::collapse::{BoxContents, CollapsePlan};
use super::emit::{BlockSlots, ChildKind, WideNodeDraft, emit_nodes};
use super::rows::{ChildRef, OtherLeaf, SphereBlock, TriangleBlock, WideNode};
use crate::bvh::{Bvh, LeafKind};
use crate::simd::NATIVE;
use phalanx_scene::huge_pages::collect_on_huge_pages;
use rayon::prelude::*;

/// Rows of a tree of its own, the root first.
pub(super) struct WideRows {
    pub(super) nodes: Vec<WideNode>,
    pub(super) triangles: Vec<TriangleBlock>,
    pub(super) spheres: Vec<SphereBlock>,
    /// The first one is empty.
    pub(super) others: Vec<OtherLeaf>,
    pub(super) depth: usize,
}

/// Widens the binary tree below a node.
pub(super) fn widen(bvh: &Bvh, root: u32) -> WideRows {
    let plan = CollapsePlan::of(bvh, root);
    let mut levels = emit_nodes(&plan);
    let rows = RowContents::of(&mut levels);
    let slots_of = |slots: &BlockSlots| slots_of(&plan, *slots);
    let nodes = rows
        .nodes
        .par_iter()
        .map(|&(level, k)| levels[level][k].row);
    let triangles = rows.triangles.par_iter().map(|slots| {
        let slots = slots_of(slots).into_iter();
        TriangleBlock::of(slots.map(|s| &bvh.leaf_prims().triangles[s as usize]))
    });
    let spheres = rows.spheres.par_iter().map(|slots| {
        let slots = slots_of(slots).into_iter();
        SphereBlock::of(slots.map(|s| &bvh.leaf_prims().spheres[s as usize]))
    });
    WideRows {
        nodes: collect_on_huge_pages(nodes),
        triangles: collect_on_huge_pages(triangles),
        spheres: collect_on_huge_pages(spheres),
        others: rows.others,
        depth: levels.len(),
    }
}

/// Contents of each row, in order.
struct RowContents {
    /// Levels of the drafts, and indices among those of their level.
    nodes: Vec<(usize, usize)>,
    triangles: Vec<BlockSlots>,
    spheres: Vec<BlockSlots>,
    others: Vec<OtherLeaf>,
}

impl RowContents {
    /// Assigns all rows their positions, and enters them in the drafts. The children of a node are
    /// adjacent, and the rows below the last child come first.
    fn of(levels: &mut [Vec<WideNodeDraft>]) -> RowContents {
        let mut rows = RowContents {
            nodes: vec![(0, 0)],
            triangles: Vec::new(),
            spheres: Vec::new(),
            others: vec![OtherLeaf::EMPTY],
        };
        let mut waiting = vec![(0, 0)];
        while let Some((level, k)) = waiting.pop() {
            let draft = &mut levels[level][k];
            let mut child = (level + 1, draft.first);
            for (below, code) in draft.children.iter().zip(&mut draft.row.children) {
                if let ChildKind::Node(_) = below {
                    waiting.push(child);
                }
                *code = rows.next(*below, &mut child).code();
            }
        }
        rows
    }

    /// Assigns the next position to a child. If it is a node, `child` is the index of its draft,
    /// and is advanced to that of the next node.
    fn next(&mut self, below: ChildKind, child: &mut (usize, usize)) -> ChildRef {
        match below {
            ChildKind::Empty => ChildRef::NOTHING,
            ChildKind::Node(_) => {
                child.1 += 1;
                ChildRef::Node(add(&mut self.nodes, (child.0, child.1 - 1)))
            }
            ChildKind::Block(LeafKind::SPHERE, slots) => {
                ChildRef::Spheres(add(&mut self.spheres, slots))
            }
            ChildKind::Block(_, slots) => ChildRef::Triangles(add(&mut self.triangles, slots)),
            ChildKind::Other(leaf) => ChildRef::Other(add(&mut self.others, leaf)),
        }
    }
}

/// Appends a row, and returns its index.
fn add<T>(rows: &mut Vec<T>, row: T) -> u32 {
    rows.push(row);
    rows.len() as u32 - 1
}

/// The slots of a block one by one.
fn slots_of(plan: &CollapsePlan, slots: BlockSlots) -> Vec<u32> {
    let mut all = Vec::with_capacity(NATIVE);
    match slots {
        BlockSlots::Row { first, count } => all.extend(first..first + count),
        BlockSlots::Of(index) => {
            let mut waiting = vec![index];
            while let Some(index) = waiting.pop() {
                for (part, _) in plan.parts(index).into_iter().rev() {
                    match part {
                        BoxContents::Node(child) => waiting.push(child),
                        BoxContents::Leaf { first, count, .. } => all.extend(first..first + count),
                    }
                }
            }
        }
    }
    all
}
