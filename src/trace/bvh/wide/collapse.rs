//! Choice of the binary nodes that become the children of one wide node: by cost, bottom up
//! (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs", HPG 2017, section 3).
//!
//! The departure from it is in the leaves: neighbouring leaves of one kind are merged into a block
//! as long as they fit. Nodes of a level do not depend on each other, so each level is planned on
//! all threads.

use crate::bvh::{Bvh, Child, LeafKind};
use crate::simd::{LANES, NATIVE};
use phalanx_scene::Bounds;
use rayon::prelude::*;
use std::ops::Range;

/// Measured cost of visiting a node, and of a block (`perf/notes/sixteen-children.md`).
const NODE_COST: f32 = 1.0;
const BLOCK_COST: f32 = if NATIVE > LANES { 1.0 } else { 0.7 };

/// Maximum number of roots by which a subtree of the binary tree is represented within its parent;
/// one more fills a node.
pub(super) const MAX_ROOTS: usize = NATIVE - 1;

/// Nodes that a thread plans at a time.
const PARALLEL_GRAIN: usize = 256;

/// Best choice for the subtree below a node.
#[derive(Clone, Copy)]
pub(super) struct CollapseChoice {
    /// Number of roots that go to the first child, out of j + 2; 0 if one root fewer is better. The
    /// last entry is that of a full node.
    pub(super) first: [u8; MAX_ROOTS],
    /// The kind of everything below, if a block of it is cheaper than a node.
    pub(super) block: Option<LeafKind>,
}

/// Costs of a subtree, for its parent's choice.
#[derive(Clone, Copy)]
struct SubtreeCost {
    /// Costs as i + 1 roots or fewer.
    roots: [f32; MAX_ROOTS],
    /// Primitives below, if they are all of one kind that has blocks and fit into one; else 0.
    count: u8,
    kind: LeafKind,
}

/// Contents of a box of the binary tree.
#[derive(Clone, Copy)]
pub(super) enum BoxContents {
    /// A node, by its index in the plan.
    Node(u32),
    /// Primitives of a kind, from a slot on.
    Leaf {
        kind: LeafKind,
        first: u32,
        count: u32,
    },
}

/// A node of the binary tree: its index, and the index in the plan of the first of its children
/// that are nodes, which lie side by side.
#[derive(Clone, Copy)]
struct NodeRef {
    node: u32,
    children: u32,
}

/// The choices for all nodes below a root, level by level; the root has index 0.
pub(super) struct CollapsePlan<'a> {
    bvh: &'a Bvh,
    nodes: Vec<NodeRef>,
    choices: Vec<CollapseChoice>,
}

impl<'a> CollapsePlan<'a> {
    pub(super) fn of(bvh: &'a Bvh, root: u32) -> CollapsePlan<'a> {
        let (nodes, levels) = levels(bvh, root);
        let undecided = CollapseChoice {
            first: [0; MAX_ROOTS],
            block: None,
        };
        let choices = nodes.par_iter().map(|_| undecided).collect();
        let mut plan = CollapsePlan {
            bvh,
            nodes,
            choices,
        };
        let mut below = Vec::new();
        for level in levels.into_iter().rev() {
            below = plan.decide(level, &below);
        }
        plan
    }

    /// The choice for a node.
    pub(super) fn choice(&self, index: u32) -> &CollapseChoice {
        &self.choices[index as usize]
    }

    /// Both children of a node.
    pub(super) fn parts(&self, index: u32) -> [(BoxContents, Bounds); 2] {
        let entry = self.nodes[index as usize];
        let node = &self.bvh.nodes()[entry.node as usize];
        let mut below = entry.children;
        [0, 1].map(|k| {
            let part = match node.child(k) {
                Child::Node(_) => {
                    below += 1;
                    BoxContents::Node(below - 1)
                }
                Child::Leaf { kind, first, count } => BoxContents::Leaf { kind, first, count },
            };
            (part, node.bounds(k))
        })
    }

    /// Chooses for a level, by the costs of the level below, and returns its own costs.
    fn decide(&mut self, level: Range<usize>, below: &[SubtreeCost]) -> Vec<SubtreeCost> {
        let mut choices = std::mem::take(&mut self.choices);
        let choose = |(index, chosen): (usize, &mut CollapseChoice)| {
            let sides = self.parts(index as u32).map(|(part, bounds)| {
                let cost = match part {
                    BoxContents::Node(child) => below[child as usize - level.end],
                    BoxContents::Leaf { kind, count, .. } => of_leaf(kind, count, bounds),
                };
                (cost, bounds)
            });
            let (choice, cost) = choose(&sides);
            *chosen = choice;
            cost
        };
        let rows = choices[level.clone()].par_iter_mut();
        let rows = level.clone().into_par_iter().zip(rows);
        let costs = rows.with_min_len(PARALLEL_GRAIN).map(choose).collect();
        self.choices = choices;
        costs
    }
}

/// All nodes from a root on, parents first, and the range of each level among them.
fn levels(bvh: &Bvh, root: u32) -> (Vec<NodeRef>, Vec<Range<usize>>) {
    let entry = |node: u32| NodeRef { node, children: 0 };
    let mut nodes = vec![entry(root)];
    let mut levels = vec![];
    let mut level = 0..1;
    while !level.is_empty() {
        let below = nodes[level.clone()].par_iter().map(|entry| {
            let node = &bvh.nodes()[entry.node as usize];
            [node.child(0), node.child(1)].map(|child| match child {
                Child::Node(index) => Some(index),
                Child::Leaf { .. } => None,
            })
        });
        let below: Vec<[Option<u32>; 2]> = below.with_min_len(PARALLEL_GRAIN).collect();
        for (k, below) in level.clone().zip(below) {
            nodes[k].children = nodes.len() as u32;
            nodes.extend(below.into_iter().flatten().map(entry));
        }
        let next = level.end..nodes.len();
        levels.push(std::mem::replace(&mut level, next));
    }
    (nodes, levels)
}

/// The best choice for a node of two subtrees in their boxes, and its costs.
fn choose(sides: &[(SubtreeCost, Bounds); 2]) -> (CollapseChoice, SubtreeCost) {
    let [(a, a_box), (b, b_box)] = sides;
    let area = a_box.union(*b_box).half_area();
    // A split into exactly j + 2 roots.
    let split = |j: usize| {
        let ways = (1..j + 2).map(|k| {
            let index = |roots: usize| (roots - 1).min(MAX_ROOTS - 1);
            (a.roots[index(k)] + b.roots[index(j + 2 - k)], k as u8)
        });
        ways.fold(
            (f32::INFINITY, 0),
            |best, way| if way.0 < best.0 { way } else { best },
        )
    };
    let (full, first_of_full) = split(MAX_ROOTS - 1);
    let same_kind = a.count > 0 && b.count > 0 && a.kind == b.kind;
    let fits = same_kind && a.count + b.count <= NATIVE as u8;
    let count = if fits { a.count + b.count } else { 0 };
    let as_node = full + NODE_COST * area;
    let block = count > 0 && BLOCK_COST * area <= as_node;
    let mut cost = SubtreeCost {
        roots: [if block { BLOCK_COST * area } else { as_node }; MAX_ROOTS],
        count,
        kind: a.kind,
    };
    let mut choice = CollapseChoice {
        first: [0; MAX_ROOTS],
        block: block.then_some(a.kind),
    };
    for j in 0..MAX_ROOTS - 1 {
        let (parted, first) = split(j);
        let fewer = cost.roots[j];
        (cost.roots[j + 1], choice.first[j]) =
            if parted < fewer { (parted, first) } else { (fewer, 0) };
    }
    choice.first[MAX_ROOTS - 1] = first_of_full;
    (choice, cost)
}

/// The costs of a leaf.
fn of_leaf(kind: LeafKind, count: u32, bounds: Bounds) -> SubtreeCost {
    let blocks = matches!(kind, LeafKind::TRIANGLE | LeafKind::SPHERE);
    let fits = blocks && count <= NATIVE as u32;
    let cost = BLOCK_COST * bounds.half_area() * count.div_ceil(NATIVE as u32) as f32;
    SubtreeCost {
        roots: [cost; MAX_ROOTS],
        count: if fits { count as u8 } else { 0 },
        kind,
    }
}
