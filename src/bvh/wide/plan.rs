//! Which nodes of the binary tree become the children of one wide node: by cost, bottom up (Ylitie, Karras and Laine,
//! "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3).
//!
//! We depart from it in what a leaf is: neighbouring leaves of one kind are merged into a block while they fit.

use crate::bvh::{Bvh, Child, LeafKind};
use crate::lanes::{LANES, NATIVE};
use crate::scene::Bounds;
use glam::Vec3;

/// Cost of visiting a node, and of a block; by measurement (`perf/notes/sixteen-children.md`).
const NODE_COST: f32 = 1.0;
const BLOCK_COST: f32 = if NATIVE > LANES { 1.0 } else { 0.7 };

/// Subtrees of the binary tree are seen as at most so many roots within their parent; one more makes a node full.
pub(super) const MOST_ROOTS: usize = NATIVE - 1;

/// What is best done with the subtree below a node.
#[derive(Clone, Copy)]
pub(super) struct Choice {
    /// Cost as i + 1 roots or fewer.
    cost: [f32; MOST_ROOTS],
    /// How many of j + 2 roots go to the first child; 0 where one root fewer is better. The last is that of a full node.
    pub(super) first: [u8; MOST_ROOTS],
    /// Primitives below, if they are all of one kind that has blocks and fit into one; else 0.
    count: u8,
    pub(super) kind: LeafKind,
    /// Whether a block of them is cheaper than a node.
    pub(super) block: bool,
}

/// The choices for all nodes that the world's root leads to.
pub(super) struct Plan(Vec<Choice>);

impl Plan {
    pub(super) fn of(bvh: &Bvh) -> Plan {
        let nothing = Choice {
            cost: [0.0; MOST_ROOTS],
            first: [0; MOST_ROOTS],
            count: 0,
            kind: LeafKind::Triangle,
            block: false,
        };
        let mut plan = Plan(vec![nothing; bvh.nodes().len()]);
        // Parents come before their children in this list.
        let mut order = vec![0u32];
        let mut done = 0;
        while let Some(&index) = order.get(done) {
            done += 1;
            let node = &bvh.nodes()[index as usize];
            order.extend([0, 1].into_iter().filter_map(|k| match node.child(k) {
                Child::Node(child) => Some(child),
                Child::Leaf { .. } => None,
            }));
        }
        for &index in order.iter().rev() {
            plan.0[index as usize] = plan.choose(bvh, index);
        }
        plan
    }

    /// What is best done with a binary node.
    pub(super) fn at(&self, index: u32) -> &Choice {
        &self.0[index as usize]
    }

    fn choose(&self, bvh: &Bvh, index: u32) -> Choice {
        let node = &bvh.nodes()[index as usize];
        let children = [0, 1].map(|k| self.view(node.child(k), area(bounds(&node.boxes[k]))));
        let boxes = [0, 1].map(|k| bounds(&node.boxes[k]));
        let area = area(boxes[0].union(boxes[1]));
        // Into exactly j + 2 roots.
        let split = |j: usize| {
            let ways = (1..j + 2).map(|k| {
                let at = |roots: usize| (roots - 1).min(MOST_ROOTS - 1);
                (
                    children[0].cost[at(k)] + children[1].cost[at(j + 2 - k)],
                    k as u8,
                )
            });
            ways.fold(
                (f32::INFINITY, 0),
                |best, way| if way.0 < best.0 { way } else { best },
            )
        };
        let (full, first_of_full) = split(MOST_ROOTS - 1);
        let [a, b] = &children;
        let count = match a.count > 0 && b.count > 0 && a.kind == b.kind {
            true if a.count + b.count <= NATIVE as u8 => a.count + b.count,
            _ => 0,
        };
        let as_node = full + NODE_COST * area;
        let block = count > 0 && BLOCK_COST * area <= as_node;
        let mut choice = Choice {
            cost: [if block { BLOCK_COST * area } else { as_node }; MOST_ROOTS],
            first: [0; MOST_ROOTS],
            count,
            kind: a.kind,
            block,
        };
        for j in 0..MOST_ROOTS - 1 {
            let (cost, first) = split(j);
            let fewer = choice.cost[j];
            (choice.cost[j + 1], choice.first[j]) = match cost < fewer {
                true => (cost, first),
                false => (fewer, 0),
            };
        }
        choice.first[MOST_ROOTS - 1] = first_of_full;
        choice
    }

    /// What a child looks like to its parent.
    fn view(&self, child: Child, area: f32) -> Choice {
        match child {
            Child::Node(index) => self.0[index as usize],
            Child::Leaf { kind, count, .. } => {
                let blocks = matches!(kind, LeafKind::Triangle | LeafKind::Sphere);
                let fits = blocks && count <= NATIVE as u32;
                Choice {
                    cost: [BLOCK_COST * area * count.div_ceil(NATIVE as u32) as f32; MOST_ROOTS],
                    first: [0; MOST_ROOTS],
                    count: if fits { count as u8 } else { 0 },
                    kind,
                    block: true,
                }
            }
        }
    }
}

pub(super) fn bounds(corners: &[[f32; 3]; 2]) -> Bounds {
    let [lo, hi] = corners.map(Vec3::from_array);
    Bounds::new(lo, hi)
}

fn area(bounds: Bounds) -> f32 {
    bounds.half_area()
}
