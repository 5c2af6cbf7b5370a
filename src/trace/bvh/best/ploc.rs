//! obvhs's clustering of a chunk (PLOC: Meister and Bittner, "Parallel Locally-Ordered Clustering
//! for Bounding Volume Hierarchy Construction", 2018), with a bound on its work.
//!
//! In each round two clusters merge if each is the other's cheapest neighbour. In ordinary scenes a
//! third of them do, and all rounds together visit three to five clusters per box.
//!
//! Among equal costs, the rightmost neighbour is taken. So of boxes at one position, equal boxes in
//! a row, and nested boxes only the last two agree: every round merges one pair, and the time is
//! quadratic. Therefore the rounds are implemented here. Up to [`MAX_VISITS_PER_BOX`] they give the
//! same bits as obvhs's own; beyond it, neighbours merge in pairs.

use crate::bvh::reinsertion::{MovableTree, TreeBox, reinsert_largest};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::reinsert_node;
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH};
use obvhs::ploc::morton::morton_encode_u128_unorm;

/// Limit on the clusters that all rounds together visit, per box. Grids of equal boxes need up to
/// 12.
const MAX_VISITS_PER_BOX: usize = 32;

/// Shares of the nodes that are reinserted, pass by pass: before leaves are made, and again after.
const REINSERTED: [f32; 2] = [1.0, 0.2];

/// The tree over at least one box.
pub(super) fn build(boxes: &[Aabb]) -> Bvh2 {
    let preset = preset();
    let Clustered { mut tree, stalled } = cluster(boxes);
    tree.children_are_ordered_after_parents = false;
    // If boxes coincide or are nested, no other position is better, and searching for one takes as
    // long as merging did.
    let passes = if stalled { &[][..] } else { &REINSERTED };
    tree.init_parents_if_uninit();
    reinsert_largest(&mut tree, passes);
    collapse(
        &mut tree,
        preset.max_prims_per_leaf.clamp(1, 255),
        preset.collapse_traversal_cost,
    );
    reinsert_largest(&mut tree, passes);
    tree
}

impl TreeBox for Aabb {
    fn union(self, other: Aabb) -> Aabb {
        Aabb::union(&self, &other)
    }

    fn half_area(self) -> f32 {
        Aabb::half_area(&self)
    }
}

impl MovableTree for Bvh2 {
    type Box = Aabb;

    fn len(&self) -> usize {
        self.nodes.len()
    }

    fn root(&self) -> u32 {
        0
    }

    fn bounds(&self, node: u32) -> Aabb {
        *self.nodes[node as usize].aabb()
    }

    fn parent(&self, node: u32) -> u32 {
        self.parents[node as usize]
    }

    fn sibling(&self, node: u32) -> u32 {
        Bvh2Node::get_sibling_id32(node)
    }

    fn children(&self, node: u32) -> Option<[u32; 2]> {
        let node = &self.nodes[node as usize];
        (!node.is_leaf()).then_some([node.first_index, node.first_index + 1])
    }

    fn reinsert(&mut self, node: u32, target: u32) {
        reinsert_node(self, node as usize, target as usize);
    }
}

/// A tree with one box per leaf.
struct Clustered {
    tree: Bvh2,
    /// True if merging by cost was stopped by the bound.
    stalled: bool,
}

/// Leaves along the Morton curve.
fn sorted(boxes: &[Aabb]) -> Vec<Bvh2Node> {
    let mut all = Aabb::empty();
    for b in boxes {
        all.extend(b.min);
        all.extend(b.max);
    }
    let scale = 1.0 / all.diagonal().as_dvec3();
    let offset = -all.min.as_dvec3() * scale;
    let key = |b: &Aabb| morton_encode_u128_unorm(b.center().as_dvec3() * scale + offset);
    let rows = boxes.iter().enumerate();
    let mut rows: Vec<SortRow> = rows
        .map(|(k, b)| SortRow {
            key: key(b),
            index: k as u128,
        })
        .collect();
    rows.sort_unstable_by_key(|row| row.key);
    let leaf = |row: SortRow| Bvh2Node::new(boxes[row.index as usize], 1, row.index as u32);
    rows.into_iter().map(leaf).collect()
}

/// A position along the curve and the box there. Rows have the size of obvhs's own, because the
/// order of equal keys depends on it.
#[derive(Clone, Copy)]
#[repr(C)]
struct SortRow {
    key: u128,
    index: u128,
}

/// Neighbours on each side that are compared: obvhs's medium search distance.
const REACH: usize = 14;
/// Rounds in which only adjacent neighbours are compared.
const NEAR_ROUNDS: usize = 1;

/// obvhs's most thorough preset.
pub(super) fn preset() -> BvhBuildParams {
    BvhBuildParams::very_slow_build()
}

/// Merges clusters until one is left.
fn cluster(boxes: &[Aabb]) -> Clustered {
    let leaves = sorted(boxes);
    let boxes = leaves.len();
    let mut tree = Bvh2::zeroed(boxes);
    tree.primitive_indices = (0..boxes as u32).collect();
    let mut clusters = leaves;
    let mut merged = Vec::with_capacity(boxes);
    let mut partners = vec![0i8; boxes];
    let mut costs = Costs([[0.0; REACH]; REACH]);
    let mut free = tree.nodes.len();
    let mut looks_left = MAX_VISITS_PER_BOX * boxes;
    let mut rounds = 0;
    while clusters.len() > 1 {
        let partners = &mut partners[..clusters.len()];
        if looks_left == 0 {
            pair_up(partners);
        } else if rounds < NEAR_ROUNDS {
            choose_near(&clusters, partners);
        } else {
            costs.choose(&clusters, partners);
        }
        looks_left = looks_left.saturating_sub(clusters.len());
        merge(&clusters, partners, &mut merged, &mut tree, &mut free);
        std::mem::swap(&mut clusters, &mut merged);
        merged.clear();
        rounds += 1;
    }
    tree.nodes[0] = clusters[0];
    tree.max_depth = DEFAULT_MAX_STACK_DEPTH.max(rounds + 1);
    tree.children_are_ordered_after_parents = true;
    Clustered {
        tree,
        stalled: looks_left == 0,
    }
}

/// Merges clusters that have chosen each other, from the end of the tree's free nodes.
fn merge(
    clusters: &[Bvh2Node],
    partners: &[i8],
    merged: &mut Vec<Bvh2Node>,
    tree: &mut Bvh2,
    free: &mut usize,
) {
    let partner = |k: usize| k.wrapping_add_signed(isize::from(partners[k]));
    for (k, &cluster) in clusters.iter().enumerate() {
        let other = partner(k);
        if partner(other) != k {
            merged.push(cluster);
        } else if other < k {
            *free -= 2;
            tree.nodes[*free] = cluster;
            tree.nodes[*free + 1] = clusters[other];
            let bounds = cluster.aabb().union(clusters[other].aabb());
            merged.push(Bvh2Node::new(bounds, 0, *free as u32));
        }
    }
}

/// Chooses the cheaper of the two adjacent neighbours, for each cluster as an offset.
fn choose_near(clusters: &[Bvh2Node], partners: &mut [i8]) {
    let mut before = f32::INFINITY;
    for (pair, partner) in clusters.windows(2).zip(partners.iter_mut()) {
        let cost = pair[0].aabb().union(pair[1].aabb()).half_area();
        *partner = if before < cost { -1 } else { 1 };
        before = cost;
    }
    partners[clusters.len() - 1] = -1;
}

/// Pairs each cluster with its adjacent neighbour, at any cost. If their number is odd, the last
/// one remains: its neighbour has chosen another.
fn pair_up(partners: &mut [i8]) {
    let last = partners.len() - 1;
    for (k, partner) in partners.iter_mut().enumerate() {
        let first = k.is_multiple_of(2) && k < last;
        *partner = if first { 1 } else { -1 };
    }
}

/// Costs of unions of the last `REACH` clusters with those after them: each cost is used from both
/// sides.
struct Costs([[f32; REACH]; REACH]);

impl Costs {
    /// Chooses the cheapest neighbour within `REACH`, for each cluster as an offset; among equal
    /// costs, the last.
    fn choose(&mut self, clusters: &[Bvh2Node], partners: &mut [i8]) {
        for (k, partner) in partners.iter_mut().enumerate() {
            let mut best = (f32::INFINITY, k);
            for other in k.saturating_sub(REACH)..k {
                let cost = self.0[other % REACH][k % REACH];
                if cost <= best.0 {
                    best = (cost, other);
                }
            }
            let own = clusters[k].aabb();
            let end = (k + REACH + 1).min(clusters.len());
            for (other, cluster) in clusters[..end].iter().enumerate().skip(k + 1) {
                let cost = own.union(cluster.aabb()).half_area();
                self.0[k % REACH][other % REACH] = cost;
                if cost <= best.0 {
                    best = (cost, other);
                }
            }
            *partner = (best.1 as isize - k as isize) as i8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::full_or::full_or;
    use glam::Vec3A;
    use obvhs::Boundable;
    use obvhs::bvh2::builder::build_bvh2;
    use std::time::Duration;

    struct TestBox(Aabb);

    impl Boundable for TestBox {
        fn aabb(&self) -> Aabb {
            self.0
        }
    }

    /// Random numbers from 0 to 1.
    fn numbers(mut seed: u32) -> impl FnMut() -> f32 {
        move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        }
    }

    fn rows(tree: &Bvh2) -> Vec<([f32; 6], u32, u32)> {
        let row = |node: &Bvh2Node| {
            let (lo, hi) = (node.aabb().min, node.aabb().max);
            let planes = [lo.x, lo.y, lo.z, hi.x, hi.y, hi.z];
            (planes, node.prim_count, node.first_index)
        };
        tree.nodes.iter().map(row).collect()
    }

    #[test]
    fn clusters_are_those_of_obvhs() {
        let preset = BvhBuildParams {
            reinsertion_batch_ratio: 0.0,
            post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
            max_prims_per_leaf: 1,
            ..preset()
        };
        let mut unit = numbers(7);
        for count in [1, 2, 3, 9, 100, 3000] {
            // Many boxes with one centre, whose order must not differ either.
            let mut position = || Vec3A::new(unit(), unit(), (unit() * 9.0).floor());
            let boxes: Vec<Aabb> = (0..count)
                .flat_map(|_| {
                    let (corner, size) = (position(), position() * 0.01);
                    let twice = Aabb::new(corner - size, corner + size);
                    [twice, twice, Aabb::new(corner, corner + position() * 0.02)]
                })
                .collect();
            let theirs: Vec<TestBox> = boxes.iter().copied().map(TestBox).collect();
            let expected = build_bvh2(&theirs, preset, &mut Duration::default());
            let tree = cluster(&boxes).tree;
            assert_eq!(rows(&tree), rows(&expected), "{count}");
            assert_eq!(tree.primitive_indices, expected.primitive_indices);
            assert_eq!(tree.max_depth, expected.max_depth);
        }
    }

    /// Checks that the tree holds every box once, within the boxes of all nodes above.
    fn check(tree: &Bvh2, boxes: &[Aabb]) {
        let mut seen = vec![false; boxes.len()];
        let mut waiting = vec![0];
        while let Some(node) = waiting.pop() {
            let node = &tree.nodes[node];
            let holds = |inner: &Aabb| node.aabb().union(inner) == *node.aabb();
            let first = node.first_index as usize;
            if node.prim_count == 0 {
                assert!((first..first + 2).all(|child| holds(tree.nodes[child].aabb())));
                waiting.extend([first, first + 1]);
            }
            for slot in first..first + node.prim_count as usize {
                let k = tree.primitive_indices[slot] as usize;
                assert!(holds(&boxes[k]) && !std::mem::replace(&mut seen[k], true));
            }
        }
        assert!(seen.into_iter().all(|seen| seen));
    }

    /// Checks boxes that cannot be separated: without the bound each case takes 10^9 visits.
    #[test]
    fn boxes_that_cannot_be_told_apart_are_merged_in_time() {
        let count = 1 << full_or(15, 12);
        let cube = |center: Vec3A, size: f32| Aabb::new(center - size, center + size);
        type TestShape = fn(f32) -> (Vec3A, f32);
        let shapes: [(&str, TestShape); 6] = [
            ("one place", |_| (Vec3A::ONE, 1.0)),
            ("one point", |_| (Vec3A::ONE, 0.0)),
            ("a row", |k| (Vec3A::X * k, 0.5)),
            ("nested", |k| (Vec3A::ONE, 1.0 + k)),
            ("two places", |k| (Vec3A::X * (k % 2.0) * 99.0, 1.0)),
            ("ever farther", |k| (Vec3A::X * k * k, 0.5)),
        ];
        for (name, shape) in shapes {
            let place = |k: usize| {
                let (center, size) = shape(k as f32);
                cube(center, size)
            };
            let boxes: Vec<Aabb> = (0..count).map(place).collect();
            let tree = build(&boxes);
            check(&tree, &boxes);
            assert!(tree.max_depth < 2000, "{name}: {}", tree.max_depth);
        }
    }
}
