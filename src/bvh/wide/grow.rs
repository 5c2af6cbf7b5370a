//! The wide tree, grown by the plan.

use super::plan::{MOST_ROOTS, Plan, bounds};
use super::{OtherLeaf, SphereBlock, Target, TriangleBlock, Wide, WideNode};
use crate::bvh::pages::onto_large_pages;
use crate::bvh::{Bvh, Child, LeafKind};
use crate::lanes::NATIVE;
use crate::scene::Bounds;

/// A child of a wide node in the making.
#[derive(Clone, Copy)]
struct Item {
    child: Child,
    bounds: Bounds,
}

pub(super) struct Growing<'a> {
    bvh: &'a Bvh,
    plan: Plan,
    wide: Wide,
}

/// A wide node that is still to be filled: its place, the level it is on, and with what.
struct Open {
    place: usize,
    level: usize,
    items: Vec<Item>,
}

impl<'a> Growing<'a> {
    /// The binary tree, widened.
    pub(super) fn of(bvh: &'a Bvh) -> Wide {
        let mut growing = Growing {
            bvh,
            plan: Plan::of(bvh),
            wide: Wide {
                others: vec![OtherLeaf::EMPTY],
                ..Wide::default()
            },
        };
        growing.grow();
        let mut wide = growing.wide;
        onto_large_pages(&mut wide.nodes);
        onto_large_pages(&mut wide.triangles);
        onto_large_pages(&mut wide.spheres);
        wide
    }
}

impl Growing<'_> {
    fn grow(&mut self) {
        let mut waiting = vec![self.open(self.children(0), 1)];
        while let Some(open) = waiting.pop() {
            self.wide.depth = self.wide.depth.max(open.level);
            self.wide.nodes[open.place].order = order(&open.items);
            for (lane, item) in open.items.iter().enumerate() {
                let (target, below) = self.target(*item, open.level + 1);
                waiting.extend(below);
                let node = &mut self.wide.nodes[open.place];
                node.children[lane] = target.code();
                for axis in 0..3 {
                    node.boxes[0][axis][lane] = item.bounds.lo[axis];
                    node.boxes[1][axis][lane] = item.bounds.hi[axis];
                }
            }
        }
    }

    /// A place for a node of these children.
    fn open(&mut self, mut items: Vec<Item>, level: usize) -> Open {
        let axis = widest(&items);
        items.sort_by(|a, b| a.middle(axis).total_cmp(&b.middle(axis)));
        let (lo, hi) = (
            [[f32::INFINITY; NATIVE]; 3],
            [[f32::NEG_INFINITY; NATIVE]; 3],
        );
        self.wide.nodes.push(WideNode {
            boxes: [lo, hi],
            children: [Target::NOTHING.code(); NATIVE],
            order: [[0; NATIVE]; 3],
            axis: axis as u8,
        });
        Open {
            place: self.wide.nodes.len() - 1,
            level,
            items,
        }
    }

    /// The children of the wide node that stands for a binary one.
    fn children(&self, index: u32) -> Vec<Item> {
        let mut items = Vec::with_capacity(NATIVE);
        let first = self.plan.at(index).first[MOST_ROOTS - 1];
        let mut waiting = Vec::with_capacity(NATIVE);
        self.part(index, first as usize, NATIVE, &mut waiting);
        while let Some((item, roots)) = waiting.pop() {
            let Child::Node(index) = item.child else {
                let empty = matches!(item.child, Child::Leaf { count: 0, .. });
                items.extend((!empty).then_some(item));
                continue;
            };
            let choice = self.plan.at(index);
            // As many roots as pay.
            let pays = (2..=roots).rev().find(|roots| choice.first[roots - 2] > 0);
            match pays {
                Some(roots) => {
                    self.part(index, choice.first[roots - 2] as usize, roots, &mut waiting)
                }
                None => items.push(item),
            }
        }
        items
    }

    /// Both children of a binary node, as `first` roots and the rest of `roots`.
    fn part(&self, index: u32, first: usize, roots: usize, waiting: &mut Vec<(Item, usize)>) {
        let node = &self.bvh.nodes()[index as usize];
        let item = |k: usize| Item {
            child: node.child(k),
            bounds: bounds(&node.boxes[k]),
        };
        waiting.extend([
            (item(1), (roots - first).min(MOST_ROOTS)),
            (item(0), first.min(MOST_ROOTS)),
        ]);
    }

    /// Where an item leads, and the node that has to be filled for that.
    fn target(&mut self, item: Item, level: usize) -> (Target, Option<Open>) {
        match item.child {
            Child::Node(index) if self.plan.at(index).block => {
                let kind = self.plan.at(index).kind;
                let slots = self.slots_below(index);
                (self.block(kind, &slots), None)
            }
            Child::Node(index) => {
                let items = self.children(index);
                self.node(items, level)
            }
            Child::Leaf {
                kind: kind @ (LeafKind::Triangle | LeafKind::Sphere),
                first,
                count,
            } => {
                if count <= NATIVE as u32 {
                    let slots: Vec<u32> = (first..first + count).collect();
                    return (self.block(kind, &slots), None);
                }
                // A leaf that is too large is a node of parts of it.
                let part = count.div_ceil(NATIVE as u32).max(NATIVE as u32);
                let parts = (0..count).step_by(part as usize).map(|start| Item {
                    child: Child::Leaf {
                        kind,
                        first: first + start,
                        count: part.min(count - start),
                    },
                    bounds: item.bounds,
                });
                let parts = parts.collect();
                self.node(parts, level)
            }
            Child::Leaf { kind, first, count } => {
                self.wide.others.push(OtherLeaf { kind, first, count });
                (Target::Other(self.wide.others.len() as u32 - 1), None)
            }
        }
    }

    fn node(&mut self, items: Vec<Item>, level: usize) -> (Target, Option<Open>) {
        let open = self.open(items, level);
        (Target::Node(open.place as u32), Some(open))
    }

    /// The slots of all leaves below a node.
    fn slots_below(&self, index: u32) -> Vec<u32> {
        let (mut slots, mut waiting) = (Vec::with_capacity(NATIVE), vec![index]);
        while let Some(index) = waiting.pop() {
            let node = &self.bvh.nodes()[index as usize];
            for k in [1, 0] {
                match node.child(k) {
                    Child::Node(child) => waiting.push(child),
                    Child::Leaf { first, count, .. } => slots.extend(first..first + count),
                }
            }
        }
        slots
    }

    fn block(&mut self, kind: LeafKind, slots: &[u32]) -> Target {
        match kind {
            LeafKind::Sphere => {
                let all = self.bvh.spheres();
                self.wide
                    .spheres
                    .push(SphereBlock::of(slots.iter().map(|&s| &all[s as usize])));
                Target::Spheres(self.wide.spheres.len() as u32 - 1)
            }
            _ => {
                let all = self.bvh.triangles();
                self.wide
                    .triangles
                    .push(TriangleBlock::of(slots.iter().map(|&s| &all[s as usize])));
                Target::Triangles(self.wide.triangles.len() as u32 - 1)
            }
        }
    }
}

impl Item {
    /// Twice the middle of its box.
    fn middle(&self, axis: usize) -> f32 {
        self.bounds.lo[axis] + self.bounds.hi[axis]
    }
}

/// The axis along which the middles of boxes are farthest apart.
fn widest(items: &[Item]) -> usize {
    let spread = |axis: usize| {
        let all = items.iter().map(|item| item.middle(axis));
        all.clone().fold(f32::NEG_INFINITY, f32::max) - all.fold(f32::INFINITY, f32::min)
    };
    let axes = [0, 1, 2].into_iter();
    axes.max_by(|&a, &b| spread(a).total_cmp(&spread(b)))
        .unwrap_or(0)
}

/// [`WideNode::order`] of these children.
fn order(items: &[Item]) -> [[u8; NATIVE]; 3] {
    let middle = |lane: u8, axis: usize| match items.get(usize::from(lane)) {
        Some(item) => item.middle(axis),
        None => f32::INFINITY,
    };
    [0, 1, 2].map(|axis| {
        let mut lanes = std::array::from_fn(|lane| lane as u8);
        lanes.sort_by(|&a, &b| middle(a, axis).total_cmp(&middle(b, axis)));
        lanes
    })
}
