//! Trees joined below one root: divided from the top by the surface area heuristic, and opened
//! where they reach into each other, so that a ray meets them together (Benthin, Woop, Wald and
//! Áfra, "Improved Two-Level BVHs using Partial Re-Braiding", HPG 2017).
//!
//! Unlike the paper, it opens a tree by its share of the area, and only as many nodes as there is
//! time for in an update.

use phalanx_scene::Bounds;
use std::collections::VecDeque;

/// Maximum number of nodes that are opened: one number, and another for each root.
const OPENED: usize = 64;
const OPENED_PER_ROOT: usize = 8;

/// Share of the area of several subtrees from which on one of them is opened.
const OPENED_SHARE: f32 = 0.5;

/// Levels from which on sets are halved by count, so that none is divided too often.
const MAX_SWEEPS: usize = 24;

/// A subtree, and its box.
pub(in crate::bvh) type BraidItem<T> = (T, Bounds);

/// A child of a joining node.
#[derive(Clone, Copy, Debug)]
pub(in crate::bvh) enum BraidChild<T> {
    /// A subtree.
    Subtree(T),
    /// The joining node of this number, counted from 0.
    Node(usize),
}

impl<T> BraidChild<T> {
    /// The subtree, or what stands for a joining node.
    pub(in crate::bvh) fn subtree_or(self, node: impl FnOnce(usize) -> T) -> T {
        match self {
            BraidChild::Subtree(subtree) => subtree,
            BraidChild::Node(number) => node(number),
        }
    }
}

/// Nodes that join subtrees; the first is the root, and children stand behind their parents.
#[derive(Debug)]
pub(in crate::bvh) struct Braid<T> {
    pub(in crate::bvh) nodes: Vec<Vec<BraidItem<BraidChild<T>>>>,
    /// Number of nodes on the longest path.
    pub(in crate::bvh) depth: usize,
    /// Nodes of subtrees that are reached no more.
    pub(in crate::bvh) opened: Vec<T>,
}

/// Joins subtrees by nodes of up to `width` children. `children` are those of a node; none of a
/// leaf.
pub(in crate::bvh) fn braid<T: Copy>(
    mut roots: Vec<BraidItem<T>>,
    width: usize,
    children: impl Fn(T) -> Vec<BraidItem<T>>,
) -> Braid<T> {
    roots.retain(|(_, bounds)| !bounds.is_empty());
    let mut left = OPENED + OPENED_PER_ROOT * roots.len();
    let mut all = Braid {
        nodes: Vec::new(),
        depth: 0,
        opened: Vec::new(),
    };
    let mut waiting = VecDeque::from([(roots, 1)]);
    while let Some((mut set, level)) = waiting.pop_front() {
        all.depth = level;
        let area = bounds_of(&set).half_area();
        let opens = |(_, bounds): &BraidItem<T>| bounds.half_area() > OPENED_SHARE * area;
        let mut k = 0;
        while k < set.len() && set.len() > 1 && left > 0 {
            let below = if opens(&set[k]) { children(set[k].0) } else { Vec::new() };
            if below.is_empty() {
                k += 1;
            } else {
                left -= 1;
                all.opened.push(set.swap_remove(k).0);
                set.extend(below);
            }
        }
        let node =
            groups(&mut set, width, level > MAX_SWEEPS)
                .into_iter()
                .map(|group| match group {
                    [only] => (BraidChild::Subtree(only.0), only.1),
                    more => {
                        waiting.push_back((more.to_vec(), level + 1));
                        let number = all.nodes.len() + waiting.len();
                        (BraidChild::Node(number), bounds_of(more))
                    }
                });
        let node = node.collect();
        all.nodes.push(node);
    }
    all
}

fn bounds_of<T>(set: &[BraidItem<T>]) -> Bounds {
    let boxes = set.iter().map(|(_, bounds)| *bounds);
    boxes.fold(Bounds::EMPTY, Bounds::union)
}

/// Divides a set into as many groups as a node has children, or into one for each subtree.
fn groups<T>(set: &mut [BraidItem<T>], width: usize, halves: bool) -> Vec<&mut [BraidItem<T>]> {
    let mut groups = vec![set];
    while groups.len() < width {
        let many = (0..groups.len()).filter(|&k| groups[k].len() > 1);
        let area = |k: usize| bounds_of(groups[k]).half_area();
        let Some(largest) = many.max_by(|&a, &b| area(a).total_cmp(&area(b))) else {
            break;
        };
        let group = groups.swap_remove(largest);
        let middle = if halves { group.len() / 2 } else { divide(group) };
        let (left, right) = group.split_at_mut(middle);
        groups.extend([left, right]);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// Sorts two subtrees or more along the axis where they are farthest apart; returns the number of
/// those that go to the left.
fn divide<T>(set: &mut [BraidItem<T>]) -> usize {
    let center = |(_, bounds): &BraidItem<T>| bounds.lo + bounds.hi;
    let centers = set
        .iter()
        .map(|root| Bounds::new(center(root), center(root)));
    let extent = centers.fold(Bounds::EMPTY, Bounds::union);
    let axis = (extent.hi - extent.lo).max_position();
    set.sort_by(|a, b| center(a)[axis].total_cmp(&center(b)[axis]));
    let union = |all: &mut Bounds, (_, bounds): &BraidItem<T>| {
        *all = all.union(*bounds);
        Some(all.half_area())
    };
    let mut right: Vec<f32> = set.iter().rev().scan(Bounds::EMPTY, union).collect();
    right.reverse();
    let left = set.iter().scan(Bounds::EMPTY, union).zip(1..set.len());
    let costs = left.map(|(area, count)| {
        let rest = (set.len() - count) as f32;
        (area * count as f32 + right[count] * rest, count)
    });
    // Equal boxes cost the same in any division: the most even one is the shallowest.
    let half = set.len() / 2;
    let best = costs.min_by(|a, b| {
        let by_cost = a.0.total_cmp(&b.0);
        by_cost.then(a.1.abs_diff(half).cmp(&b.1.abs_diff(half)))
    });
    best.map_or(1, |(_, count)| count)
}
