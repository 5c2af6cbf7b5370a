//! Drafts of the wide nodes according to the plan, before they have positions: each level on all
//! threads.

use super::collapse::{BoxContents, CollapsePlan, MAX_ROOTS};
use super::rows::{OtherLeaf, WideNode};
use crate::bvh::LeafKind;
use crate::simd::NATIVE;
use phalanx_scene::Bounds;
use rayon::prelude::*;

/// Draft of a wide node: its row without the children's references, and the kinds of its children.
pub(super) struct WideNodeDraft {
    pub(super) row: WideNode,
    pub(super) children: [ChildKind; NATIVE],
    /// Index, in the next level, of the draft of the first child that is a node; the others follow
    /// it.
    pub(super) first: usize,
}

/// Kind of a child of a wide node.
#[derive(Clone, Copy)]
pub(super) enum ChildKind {
    Empty,
    /// A wide node, made of these contents.
    Node(BoxContents),
    /// A block.
    Block(LeafKind, BlockSlots),
    /// A leaf of a kind that has no blocks.
    Other(OtherLeaf),
}

/// The slots of a block.
#[derive(Clone, Copy)]
pub(super) enum BlockSlots {
    /// All slots below a node of the plan.
    Of(u32),
    /// A run of slots.
    Row { first: u32, count: u32 },
}

/// Contents of a box, and the box.
#[derive(Clone, Copy)]
struct BoxedContents {
    part: BoxContents,
    bounds: Bounds,
}

/// Drafts of all wide nodes, level by level.
pub(super) fn emit_nodes(plan: &CollapsePlan) -> Vec<Vec<WideNodeDraft>> {
    let mut levels = Vec::new();
    // The root's own box is not used.
    let mut open = vec![BoxedContents {
        part: BoxContents::Node(0),
        bounds: Bounds::EMPTY,
    }];
    while !open.is_empty() {
        let level = open.par_iter().map(|item| WideNodeDraft::of(plan, item));
        let mut level: Vec<WideNodeDraft> = level.collect();
        open = level
            .par_iter()
            .flat_map_iter(WideNodeDraft::nodes)
            .collect();
        let mut first = 0;
        for draft in &mut level {
            draft.first = first;
            first += draft.nodes().count();
        }
        levels.push(level);
    }
    levels
}

impl WideNodeDraft {
    fn of(plan: &CollapsePlan, item: &BoxedContents) -> WideNodeDraft {
        let mut items = match item.part {
            BoxContents::Node(index) => children(plan, index),
            BoxContents::Leaf { kind, first, count } => parts(kind, first, count, item.bounds),
        };
        let row = WideNode::over(&mut items, |item| item.bounds);
        let mut below = [ChildKind::Empty; NATIVE];
        for (below, item) in below.iter_mut().zip(&items) {
            *below = ChildKind::of(plan, item.part);
        }
        WideNodeDraft {
            row,
            children: below,
            first: 0,
        }
    }

    /// The children that are nodes.
    fn nodes(&self) -> impl Iterator<Item = BoxedContents> {
        let lanes = self.children.iter().enumerate();
        lanes.filter_map(|(lane, below)| match below {
            ChildKind::Node(part) => Some(BoxedContents {
                part: *part,
                bounds: self.row.bounds(lane),
            }),
            _ => None,
        })
    }
}

impl ChildKind {
    fn of(plan: &CollapsePlan, part: BoxContents) -> ChildKind {
        match part {
            BoxContents::Node(index) => match plan.choice(index).block {
                Some(kind) => ChildKind::Block(kind, BlockSlots::Of(index)),
                None => ChildKind::Node(part),
            },
            BoxContents::Leaf {
                kind: kind @ (LeafKind::TRIANGLE | LeafKind::SPHERE),
                first,
                count,
            } => {
                if count <= NATIVE as u32 {
                    ChildKind::Block(kind, BlockSlots::Row { first, count })
                } else {
                    ChildKind::Node(part)
                }
            }
            BoxContents::Leaf { kind, first, count } => {
                ChildKind::Other(OtherLeaf { kind, first, count })
            }
        }
    }
}

/// The children of the wide node that replaces a binary one.
fn children(plan: &CollapsePlan, index: u32) -> Vec<BoxedContents> {
    let mut items = Vec::with_capacity(NATIVE);
    let mut waiting = Vec::with_capacity(NATIVE);
    let first = plan.choice(index).first[MAX_ROOTS - 1];
    part(plan, index, first, NATIVE, &mut waiting);
    while let Some((item, roots)) = waiting.pop() {
        let BoxContents::Node(index) = item.part else {
            let empty = matches!(item.part, BoxContents::Leaf { count: 0, .. });
            items.extend((!empty).then_some(item));
            continue;
        };
        let choice = plan.choice(index);
        // The largest number of roots that pays off.
        let pays = (2..=roots).rev().find(|roots| choice.first[roots - 2] > 0);
        match pays {
            Some(roots) => part(plan, index, choice.first[roots - 2], roots, &mut waiting),
            None => items.push(item),
        }
    }
    items
}

/// Appends both children of a binary node, as `first` roots and the rest of `roots`.
fn part(
    plan: &CollapsePlan,
    index: u32,
    first: u8,
    roots: usize,
    waiting: &mut Vec<(BoxedContents, usize)>,
) {
    let first = usize::from(first);
    let [a, b] = plan
        .parts(index)
        .map(|(part, bounds)| BoxedContents { part, bounds });
    waiting.extend([
        (b, (roots - first).min(MAX_ROOTS)),
        (a, first.min(MAX_ROOTS)),
    ]);
}

/// Splits a leaf that is too large for a block into parts, the children of a node.
fn parts(kind: LeafKind, first: u32, count: u32, bounds: Bounds) -> Vec<BoxedContents> {
    let part = count.div_ceil(NATIVE as u32).max(NATIVE as u32);
    let starts = (0..count).step_by(part as usize);
    let parts = starts.map(|start| BoxedContents {
        part: BoxContents::Leaf {
            kind,
            first: first + start,
            count: part.min(count - start),
        },
        bounds,
    });
    parts.collect()
}

impl WideNode {
    /// A node over children with boxes, which are sorted along the axis where their middles are
    /// farthest apart. Its references are still empty.
    pub(super) fn over<T>(children: &mut [T], bounds: impl Fn(&T) -> Bounds) -> WideNode {
        // Twice the middle of the box.
        let middle = |child: &T, axis: usize| bounds(child).lo[axis] + bounds(child).hi[axis];
        let spread = |axis: usize| {
            let all = children.iter().map(|child| middle(child, axis));
            all.clone().fold(f32::NEG_INFINITY, f32::max) - all.fold(f32::INFINITY, f32::min)
        };
        let axes = [0, 1, 2].into_iter();
        let axis = axes.max_by(|&a, &b| spread(a).total_cmp(&spread(b)));
        let axis = axis.unwrap_or(0);
        children.sort_by(|a, b| middle(a, axis).total_cmp(&middle(b, axis)));
        let place = |lane: u8, axis: usize| match children.get(usize::from(lane)) {
            Some(child) => middle(child, axis),
            None => f32::INFINITY,
        };
        let order = |axis: usize| {
            let mut lanes = std::array::from_fn(|lane| lane as u8);
            lanes.sort_by(|&a, &b| place(a, axis).total_cmp(&place(b, axis)));
            lanes
        };
        let mut node = WideNode {
            order: [0, 1, 2].map(order),
            axis: axis as u8,
            ..WideNode::EMPTY
        };
        for (lane, child) in children.iter().enumerate() {
            node.set_box(lane, &bounds(child));
        }
        node
    }
}
