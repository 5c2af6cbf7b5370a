//! Bottom-up clustering of a chunk, in lanes (PLOC: Meister and Bittner, "Parallel Locally-Ordered
//! Clustering for Bounding Volume Hierarchy Construction", 2018).
//!
//! | file | contents |
//! |---|---|
//! | `morton` | the order of a chunk's objects along the Morton curve |
//! | `clusters` | boxes of clusters as columns |
//! | `neighbours` | the cheapest neighbour of each cluster, in lanes |
//! | `merge` | merging of pairs that chose each other, and the choice of leaves |
//! | `emit` | conversion of merges to nodes, depth first |
//!
//! It departs from the paper in three points. Clusters are stored in columns, and a lane is a
//! cluster, so that a neighbour's box is a load and a round costs the same for any choice. Node or
//! leaf is chosen at once, because a merge knows the costs of both its parts. And rounds are
//! bounded: see [`MAX_VISITS_PER_BOX`].

mod clusters;
mod emit;
mod merge;
mod morton;
mod neighbours;

use super::prim_ref::PrimRef;
use bumpalo::Bump;
use clusters::{ClusterRef, Clusters};
use emit::MergeTree;
pub(super) use emit::{BinaryTree, ChunkTree, EmittedNodes, LeafObjects};
use merge::Merges;
use morton::MortonOrder;
use neighbours::{Neighbours, choose};

/// Maximum number of objects in a chunk: its columns and merges fit a cache of one mebibyte.
pub(super) const CHUNK_PRIMS: usize = 1 << 13;

/// Limit on the clusters that all rounds together visit, per box. Ordinary scenes need three to
/// five, grids of equal boxes fewer. Of nested boxes only two agree in a round, so the time would
/// be quadratic; beyond this limit, neighbours merge in pairs.
const MAX_VISITS_PER_BOX: usize = 32;

/// Scratch memory of a thread, reused for each chunk.
#[derive(Default)]
pub(super) struct Clustering {
    order: MortonOrder,
    clusters: Clusters,
    neighbours: Neighbours,
    merges: Merges,
    emitted: EmittedNodes<ClusterRef>,
    /// Clusters of a leaf whose objects are still to be placed.
    waiting: Vec<ClusterRef>,
}

impl Clustering {
    /// The tree over a chunk, with its nodes in the arena. A cluster is compared with `REACH`
    /// neighbours on each side, at most [`MAX_REACH`](neighbours::MAX_REACH).
    pub(super) fn run<'a, const REACH: usize>(
        &mut self,
        chunk: &[PrimRef],
        arena: &'a Bump,
    ) -> ChunkTree<'a> {
        let sorted = self.order.sort(chunk);
        self.clusters.set(sorted);
        self.merges.clear();
        let mut visits_left = MAX_VISITS_PER_BOX * chunk.len();
        while self.clusters.len() > 1 {
            let count = self.clusters.len();
            let exhausted = visits_left < count;
            visits_left = visits_left.saturating_sub(count);
            if exhausted {
                self.neighbours.pair_up(count)
            } else {
                choose::<REACH>(&self.clusters, &mut self.neighbours)
            }
            let (clusters, neighbours) = (&mut self.clusters, &self.neighbours);
            self.merges.add_round(clusters, neighbours, sorted);
            if self.clusters.len() == count {
                visits_left = 0;
            }
        }
        let root = self.clusters.root();
        let mut tree = MergeTree {
            merges: &self.merges,
            sorted,
            waiting: &mut self.waiting,
        };
        self.emitted.run(&mut tree, root, sorted.len(), arena)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{Child, LeafKind};
    use glam::Vec3;
    use phalanx_scene::{Bounds, PrimKind};

    /// Most nodes on a path of these trees.
    const MAX_DEPTH: usize = 1000;

    fn tree_of<'a>(boxes: &[(LeafKind, Bounds)], arena: &'a Bump) -> ChunkTree<'a> {
        let prim = |(k, &(kind, bounds)): (usize, &(LeafKind, Bounds))| {
            PrimRef::new(k as u32, kind, bounds)
        };
        let chunk: Vec<PrimRef> = boxes.iter().enumerate().map(prim).collect();
        Clustering::default().run::<8>(&chunk, arena)
    }

    /// Checks that the tree holds every object once, in a leaf of its own kind, within the boxes of
    /// all nodes above. Returns the number of leaves.
    fn check(tree: &ChunkTree, boxes: &[(LeafKind, Bounds)]) -> usize {
        let mut seen = vec![false; boxes.len()];
        let of_kind = |kind: LeafKind| {
            let objects = tree.leaves.objects.iter();
            objects.filter(move |&&object| boxes[object as usize].0 == kind)
        };
        let mut waiting = vec![(tree.root, tree.bounds, 1)];
        let mut leaves = 0;
        while let Some((child, bounds, depth)) = waiting.pop() {
            assert!(depth < MAX_DEPTH);
            match child {
                Child::Node(index) => {
                    let node = &tree.nodes[index as usize];
                    for k in 0..2 {
                        assert_eq!(bounds.union(node.bounds(k)), bounds);
                        waiting.push((node.child(k), node.bounds(k), depth + 1));
                    }
                }
                Child::Leaf { kind, first, count } => {
                    leaves += 1;
                    for &object in of_kind(kind).skip(first as usize).take(count as usize) {
                        assert_eq!(bounds.union(boxes[object as usize].1), bounds);
                        assert!(!std::mem::replace(&mut seen[object as usize], true));
                    }
                }
            }
        }
        assert!(seen.into_iter().all(|seen| seen));
        leaves
    }

    /// Checks boxes that cannot be separated. Of nested ones only two agree in a round; without the
    /// bound they take 10^9 visits.
    #[test]
    fn boxes_that_cannot_be_told_apart_are_merged_in_time() {
        type BoxShape = fn(f32) -> (Vec3, f32);
        let shapes: [BoxShape; 7] = [
            |_| (Vec3::ONE, 1.0),
            |_| (Vec3::ONE, 0.0),
            |k| (Vec3::X * k, 0.5),
            |k| (Vec3::ONE, 1.0 + k),
            |k| (Vec3::X * (k % 2.0) * 99.0, 1.0),
            |k| (Vec3::X * k * k, 0.5),
            |k| (Vec3::splat(k % 3.0 - 1.0) * 3e38, 1e38),
        ];
        for shape in shapes {
            for count in [1, 2, 3, 17, CHUNK_PRIMS] {
                let boxed = |k: usize| {
                    let (center, size) = shape(k as f32);
                    (
                        LeafKind::TRIANGLE,
                        Bounds::new(center - size, center + size),
                    )
                };
                let boxes: Vec<(LeafKind, Bounds)> = (0..count).map(boxed).collect();
                check(&tree_of(&boxes, &Bump::new()), &boxes);
            }
        }
    }

    #[test]
    fn a_leaf_holds_one_kind() {
        let kinds = [
            LeafKind::TRIANGLE,
            LeafKind::SPHERE,
            LeafKind::Prim(PrimKind::Cone),
            LeafKind::Instance,
        ];
        let boxed = |k: usize| {
            let corner = Vec3::new((k % 7) as f32, (k * k % 11) as f32, (k % 5) as f32);
            (kinds[k % 4], Bounds::new(corner, corner + 0.5))
        };
        let boxes: Vec<(LeafKind, Bounds)> = (0..1000).map(boxed).collect();
        assert!(check(&tree_of(&boxes, &Bump::new()), &boxes) >= 1000 / 8);
    }
}
