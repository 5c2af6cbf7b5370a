//! Merging of clusters that chose each other, and the choice between node and leaf.

use super::clusters::{ClusterRef, Clusters};
use super::neighbours::Neighbours;
use crate::bvh::prim_ref::PrimRef;
use std::hint::select_unpredictable;

/// Cost of visiting a node, in tests of a primitive (`perf/notes/tree-preset.md`).
const NODE_COST: f32 = 3.0;

/// Maximum number of primitives in a leaf.
const MAX_LEAF: u8 = 8;

/// Two clusters that have become one.
#[derive(Clone, Copy)]
pub(super) struct Merge {
    /// The box: lower corner by axis, then upper corner.
    pub(super) planes: [f32; 6],
    pub(super) parts: [ClusterRef; 2],
    /// Cost of a ray that meets the box, times the box's area.
    cost: f32,
    contents: Contents,
    /// True if a leaf of all primitives below is cheaper than a node.
    pub(super) is_leaf: bool,
}

/// Primitives of a cluster.
#[derive(Clone, Copy)]
struct Contents {
    /// Number of primitives, if they are all of one kind and fit into a leaf; else 0.
    count: u8,
    kind: u8,
}

/// Merges of a chunk, one round after another.
#[derive(Default)]
pub(super) struct Merges {
    all: Vec<Merge>,
    /// The clusters after a round: their first part, and their second, or the first again for an
    /// unchanged cluster.
    pairs: Vec<[u32; 2]>,
    /// The parts of this round's merges, and the position of the merged cluster.
    merged: Vec<([ClusterRef; 2], u32)>,
}

impl Merges {
    pub(super) fn clear(&mut self) {
        self.all.clear();
    }

    pub(super) fn get(&self, index: usize) -> &Merge {
        &self.all[index]
    }

    /// Merges pairs of clusters that have chosen each other; the merged cluster takes the position
    /// of the first. Whether a cluster has a partner is unpredictable, so loops over all clusters
    /// do not branch on it.
    #[inline(never)]
    pub(super) fn add_round(
        &mut self,
        clusters: &mut Clusters,
        neighbours: &Neighbours,
        objects: &[PrimRef],
    ) {
        self.pair(neighbours, clusters.len());
        clusters.unite(&self.pairs);
        self.merged.clear();
        self.merged
            .resize(self.pairs.len(), ([ClusterRef::object(0); 2], 0));
        let mut count = 0;
        let first = self.all.len();
        for (k, pair) in self.pairs.iter().enumerate() {
            let parts = clusters.parts(*pair);
            self.merged[count] = (parts, k as u32);
            let is_merge = pair[0] != pair[1];
            let merged = ClusterRef::merge(first + count);
            clusters.set_content(k, select_unpredictable(is_merge, merged, parts[0]));
            count += usize::from(is_merge);
        }
        clusters.truncate(self.pairs.len());
        for &(parts, place) in &self.merged[..count] {
            let planes = clusters.planes(place as usize);
            let merge = self.merge(planes, parts, objects);
            self.all.push(merge);
        }
    }

    /// Lists the clusters after this round.
    fn pair(&mut self, neighbours: &Neighbours, count: usize) {
        self.pairs.clear();
        self.pairs.resize(count, [0; 2]);
        let mut len = 0;
        for k in 0..count {
            let other = neighbours.chosen_by(k).min(count - 1);
            let agree = neighbours.chosen_by(other) == k;
            let second = select_unpredictable(agree, other, k);
            self.pairs[len] = [k as u32, second as u32];
            len += usize::from(second >= k);
        }
        self.pairs.truncate(len);
    }

    fn merge(&self, planes: [f32; 6], parts: [ClusterRef; 2], objects: &[PrimRef]) -> Merge {
        let [(cost_a, a), (cost_b, b)] = parts.map(|part| self.cost(part, objects));
        let area = half_area(&planes);
        let fits = a.count > 0 && b.count > 0 && a.kind == b.kind;
        let count = match a.count.saturating_add(b.count) {
            count if fits && count <= MAX_LEAF => count,
            _ => 0,
        };
        let as_node = NODE_COST * area + (cost_a + cost_b);
        let as_leaf = f32::from(count) * area;
        let is_leaf = count > 0 && as_leaf <= as_node;
        Merge {
            planes,
            parts,
            cost: if is_leaf { as_leaf } else { as_node },
            contents: Contents {
                count,
                kind: a.kind,
            },
            is_leaf,
        }
    }

    #[inline(always)]
    fn cost(&self, part: ClusterRef, objects: &[PrimRef]) -> (f32, Contents) {
        match part.index() {
            Ok(merge) => (self.all[merge].cost, self.all[merge].contents),
            Err(object) => {
                let kind = objects[object].kind().number() as u8;
                let area = half_area(&objects[object].planes());
                (area, Contents { count: 1, kind })
            }
        }
    }
}

#[inline(always)]
fn half_area(planes: &[f32; 6]) -> f32 {
    let [x0, y0, z0, x1, y1, z1] = planes;
    let (dx, dy, dz) = (x1 - x0, y1 - y0, z1 - z0);
    dx * (dy + dz) + dy * dz
}
