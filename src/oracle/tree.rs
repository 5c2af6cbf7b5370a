//! The oracle's own tree: a binary hierarchy built by binned surface area heuristic (Wald, "On Fast
//! Construction of SAH-based Bounding Volume Hierarchies", 2007) and traversed one ray at a time.
//! It differs from the packet engine's tree on purpose, as part of the proof that no picture
//! depends on the tree.

use super::intersect::{OracleHit, OracleInterval, OracleRaySetup, REACH, min};
use glam::Vec3;
use phalanx_scene::{Bounds, Scene};
use std::ops::Range;

/// Buckets per axis of the builder.
const BINS: usize = 16;
/// Maximum number of primitives in a leaf, unless they cannot be separated.
const MAX_LEAF_PRIMS: usize = 4;
/// Depth from which nodes are halved by count, so that no path is deeper than [`MAX_DEPTH`].
const MAX_SAH_DEPTH: usize = 32;
/// Length of the traversal stack: 32 levels by heuristic, and 32 halvings of at most 2³²
/// primitives.
const MAX_DEPTH: usize = 64;

#[derive(Clone, Copy, Debug)]
struct OracleNode {
    bounds: Bounds,
    /// First primitive of a leaf; for an inner node, the second child (the first follows the node).
    first: u32,
    /// Primitives of a leaf, 0 for an inner node.
    count: u32,
}

/// The world's tree, and one for every mesh, for [`OracleSearch::Tree`](crate::OracleSearch).
#[derive(Clone, Debug)]
pub struct TwoLevelBvh {
    world: OracleTree,
    meshes: Vec<OracleTree>,
    instance_boxes: Vec<Bounds>,
}

impl TwoLevelBvh {
    /// Builds the trees of a scene, on one thread. The scene must be valid, and must not change
    /// while the trees are in use.
    ///
    /// ```
    /// # mod phalanx { pub use {glam, phalanx_oracle as oracle, phalanx_scene::*}; }
    /// use phalanx::oracle::TwoLevelBvh;
    /// use phalanx::Scene;
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// assert!(TwoLevelBvh::build(&scene).memory_bytes() > 0);
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn build(scene: &Scene) -> TwoLevelBvh {
        let prims = scene.prim_count() as u32;
        let instance_boxes = super::instance::instance_boxes(scene);
        let bounds = |object: u32| match object.checked_sub(prims) {
            None => scene.prim_bounds(object).padded(),
            Some(k) => instance_boxes[k as usize],
        };
        let boxed = |object: u32| (object, bounds(object));
        let mesh = |mesh| OracleTree::build(scene.meshes.prims(mesh).map(boxed));
        TwoLevelBvh {
            world: OracleTree::build(super::instance::world_objects(scene).map(boxed)),
            meshes: (0..scene.meshes.len()).map(mesh).collect(),
            instance_boxes,
        }
    }

    /// The world's tree.
    pub fn world(&self) -> &OracleTree {
        &self.world
    }

    /// The tree of a mesh.
    pub(super) fn mesh(&self, mesh: usize) -> &OracleTree {
        &self.meshes[mesh]
    }

    pub(super) fn instance_boxes(&self) -> &[Bounds] {
        &self.instance_boxes
    }

    /// Bytes of all trees.
    pub fn memory_bytes(&self) -> usize {
        let trees = self.meshes.iter().chain([&self.world]);
        trees.map(OracleTree::memory_bytes).sum()
    }
}

/// A binary tree over padded boxes.
#[derive(Clone, Debug)]
pub struct OracleTree {
    nodes: Vec<OracleNode>,
    /// Objects in leaf order: primitives by number, and instances from the number of primitives on.
    objects: Vec<u32>,
    depth: usize,
}

/// A primitive during the build.
#[derive(Clone, Copy)]
struct BuildPrim {
    bounds: Bounds,
    /// Twice the centre of the box.
    center: Vec3,
    object: u32,
}

impl OracleTree {
    fn build(objects: impl Iterator<Item = (u32, Bounds)>) -> OracleTree {
        let item = |(object, bounds): (u32, Bounds)| BuildPrim {
            bounds,
            center: bounds.lo + bounds.hi,
            object,
        };
        let mut items: Vec<BuildPrim> = objects.map(item).collect();
        let mut tree = OracleTree {
            nodes: Vec::with_capacity(items.len()),
            objects: Vec::with_capacity(items.len()),
            depth: 0,
        };
        if !items.is_empty() {
            tree.add(&mut items, 1);
        }
        tree
    }

    /// Number of nodes, leaves included.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Longest path from the root, which counts as 1.
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Bytes of the nodes and of the primitive list.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.objects.as_slice())
    }

    /// Surface area heuristic cost: nodes visited and primitives tested, both at cost 1.
    pub fn sah(&self) -> f64 {
        let Some(root) = self.nodes.first() else {
            return 0.0;
        };
        let cost = |n: &OracleNode| n.bounds.half_area() as f64 * n.count.max(1) as f64;
        self.nodes.iter().map(cost).sum::<f64>() / root.bounds.half_area() as f64
    }

    fn add(&mut self, items: &mut [BuildPrim], depth: usize) {
        let bounds = items
            .iter()
            .fold(Bounds::EMPTY, |all, i| all.union(i.bounds));
        let index = self.nodes.len();
        self.depth = self.depth.max(depth);
        self.nodes.push(OracleNode {
            bounds,
            first: self.objects.len() as u32,
            count: items.len() as u32,
        });
        let middle = if items.len() <= MAX_LEAF_PRIMS {
            0
        } else if depth < MAX_SAH_DEPTH {
            partition(items)
        } else {
            items.len() / 2
        };
        if middle == 0 || middle == items.len() {
            self.objects.extend(items.iter().map(|i| i.object));
            return;
        }
        let (left, right) = items.split_at_mut(middle);
        self.nodes[index].count = 0;
        self.add(left, depth + 1);
        self.nodes[index].first = self.nodes.len() as u32;
        self.add(right, depth + 1);
    }

    /// Passes `closer` the objects that may lie before `best` and within `reach`: hits before its
    /// start or beyond its end do not matter.
    pub(super) fn closest(
        &self,
        setup: &OracleRaySetup,
        reach: Range<f32>,
        best: &mut Option<OracleHit>,
        mut closer: impl FnMut(u32, &mut Option<OracleHit>),
    ) {
        self.walk(setup, reach, |objects, limit| {
            for &object in objects {
                closer(object, best);
            }
            if let Some(hit) = best {
                *limit = min(*limit, hit.t);
            }
            false
        });
    }

    pub(super) fn any(
        &self,
        setup: &OracleRaySetup,
        tmax: f32,
        blocks: impl Fn(u32) -> bool,
    ) -> bool {
        let mut is_hit = false;
        self.walk(setup, 0.0..tmax, |objects, _| {
            is_hit = objects.iter().any(|&object| blocks(object));
            is_hit
        });
        is_hit
    }

    /// Visits the leaves that a ray may meet within `reach`, nearer ones first, until `leaf`
    /// returns true. `leaf` may lower the end. A box that the ray leaves well before the start
    /// holds no hit beyond it.
    fn walk(
        &self,
        setup: &OracleRaySetup,
        reach: Range<f32>,
        mut leaf: impl FnMut(&[u32], &mut f32) -> bool,
    ) {
        let mut limit = reach.end;
        let crosses = |interval: OracleInterval, limit: f32| {
            interval.overlaps(limit) && !interval.ends_before(reach.start)
        };
        let Some(root) = self.nodes.first() else {
            return;
        };
        if !crosses(setup.intersect_box(&root.bounds), limit) {
            return;
        }
        let mut stack = [(0u32, 0.0f32); MAX_DEPTH];
        let mut top = 0;
        let mut index = 0;
        loop {
            let node = &self.nodes[index];
            let mut next = None;
            if node.count > 0 {
                let first = node.first as usize;
                if leaf(
                    &self.objects[first..first + node.count as usize],
                    &mut limit,
                ) {
                    return;
                }
            } else {
                let (a, b) = (index + 1, node.first as usize);
                let stays = [a, b].map(|k| setup.intersect_box(&self.nodes[k].bounds));
                next = match stays.map(|s| crosses(s, limit)) {
                    [true, true] => {
                        let a_first = stays[0].tnear <= stays[1].tnear;
                        let (near, far) = if a_first { (a, b) } else { (b, a) };
                        stack[top] = (far as u32, stays[usize::from(a_first)].tnear);
                        top += 1;
                        Some(near)
                    }
                    [true, false] => Some(a),
                    [false, true] => Some(b),
                    [false, false] => None,
                };
            }
            index = match next {
                Some(next) => next,
                None => loop {
                    if top == 0 {
                        return;
                    }
                    top -= 1;
                    let (waiting, enter) = stack[top];
                    if enter <= limit * REACH {
                        break waiting as usize;
                    }
                },
            };
        }
    }
}

/// Reorders items into two groups at the cheapest of the bin borders. Returns the size of the first
/// group (0 if all centres coincide or no split is cheaper than a small leaf).
fn partition(items: &mut [BuildPrim]) -> usize {
    let centers = items.iter().fold(Bounds::EMPTY, |all, i| {
        all.union(Bounds::new(i.center, i.center))
    });
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if let Some((cost, border)) = best_split(items, centers, axis)
            && best.is_none_or(|(least, ..)| cost < least)
        {
            best = Some((cost, axis, border));
        }
    }
    let Some((_, axis, border)) = best else {
        return items.len() / 2;
    };
    let mut middle = 0;
    for k in 0..items.len() {
        if bin(items[k].center, centers, axis) < border {
            items.swap(k, middle);
            middle += 1;
        }
    }
    middle
}

fn bin(center: Vec3, centers: Bounds, axis: usize) -> usize {
    let extent = centers.hi[axis] - centers.lo[axis];
    let k = (center[axis] - centers.lo[axis]) / extent * BINS as f32;
    (k as usize).min(BINS - 1)
}

fn best_split(items: &[BuildPrim], centers: Bounds, axis: usize) -> Option<(f32, usize)> {
    if centers.lo[axis] >= centers.hi[axis] {
        return None;
    }
    let mut bins = [(Bounds::EMPTY, 0usize); BINS];
    for item in items {
        let b = &mut bins[bin(item.center, centers, axis)];
        *b = (b.0.union(item.bounds), b.1 + 1);
    }
    let mut right = [0.0f32; BINS];
    let mut sum = (Bounds::EMPTY, 0usize);
    for k in (1..BINS).rev() {
        sum = (sum.0.union(bins[k].0), sum.1 + bins[k].1);
        right[k] = sum.0.half_area() * sum.1 as f32;
    }
    let mut left = (Bounds::EMPTY, 0usize);
    let mut best: Option<(f32, usize)> = None;
    for border in 1..BINS {
        left = (
            left.0.union(bins[border - 1].0),
            left.1 + bins[border - 1].1,
        );
        if left.1 == 0 || left.1 == items.len() {
            continue;
        }
        let cost = left.0.half_area() * left.1 as f32 + right[border];
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, border));
        }
    }
    best
}
