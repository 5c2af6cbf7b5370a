//! The wide tree of a scene that moves: boxes are refitted, and a tree over the instances stands
//! behind that over the world's primitives, so that it can be replaced.

use super::rows::{ChildRef, OtherLeaf, TriangleBlock, WideBvh, WideNode, WorldRows};
use crate::bvh::leaf::LeafTriangle;
use crate::prefetch::prefetch;
use crate::simd::{LaneMask, Lanes, NATIVE, Native};
use glam::Vec3;
use phalanx_scene::{Bounds, PAD, map_on_pool, on_pool};
use rayon::prelude::*;

/// Rows that a thread takes at a time.
const GRAIN: usize = 1 << 10;

/// Blocks ahead of the one that is moved, whose triangles are prefetched.
const AHEAD: usize = 8;

/// Slot of a lane without a triangle.
const UNUSED: u32 = u32::MAX;

impl WideBvh {
    /// The tree over the world's primitives, and that over the instances, below a common root.
    pub(super) fn joined(world: WideBvh, top: WideBvh) -> WideBvh {
        let depth = world.depth;
        let mut all = WideBvh {
            nodes: vec![WideNode::EMPTY],
            others: vec![OtherLeaf::EMPTY],
            ..WideBvh::default()
        };
        all.append(world);
        all.world = Some(WorldRows {
            nodes: all.nodes.len(),
            others: all.others.len(),
            depth,
        });
        all.replace_top(top);
        all
    }

    /// Returns true if the instances have a tree of their own.
    pub(in crate::bvh) fn has_top(&self) -> bool {
        self.world.is_some()
    }

    /// Replaces the tree over the instances.
    pub(in crate::bvh) fn replace_top(&mut self, top: WideBvh) {
        if let Some(world) = self.world {
            self.nodes.truncate(world.nodes);
            self.others.truncate(world.others);
            self.depth = 1 + world.depth.max(top.depth);
            self.append(top);
            self.set_root(world.nodes);
        }
    }

    /// Appends the rows of another tree. Instances have no blocks.
    fn append(&mut self, other: WideBvh) {
        let offset = |code: u32| match ChildRef::of_code(code) {
            ChildRef::Node(k) => ChildRef::Node(k + self.nodes.len() as u32),
            ChildRef::Triangles(k) => ChildRef::Triangles(k + self.triangles.len() as u32),
            ChildRef::Spheres(k) => ChildRef::Spheres(k + self.spheres.len() as u32),
            // The first one is empty in both.
            ChildRef::Other(0) => ChildRef::NOTHING,
            ChildRef::Other(k) => ChildRef::Other(k - 1 + self.others.len() as u32),
        };
        let moved = |mut node: WideNode| {
            node.children = node.children.map(|code| offset(code).code());
            node
        };
        let nodes: Vec<WideNode> = other.nodes.into_par_iter().map(moved).collect();
        self.nodes.extend(nodes);
        self.triangles.extend(other.triangles);
        self.spheres.extend(other.spheres);
        self.others.extend(other.others.into_iter().skip(1));
    }

    /// Makes the root of the two trees that begin at node 1 and at this one.
    fn set_root(&mut self, top: usize) {
        let mut children =
            [1, top].map(|k| (ChildRef::Node(k as u32), self.nodes[k].child_bounds()));
        let mut root = WideNode::over(&mut children, |child| child.1);
        for (code, child) in root.children.iter_mut().zip(children) {
            *code = child.0.code();
        }
        self.nodes[0] = root;
    }

    /// Moves the triangles, and the boxes around them, to where the binary tree has them now.
    pub(in crate::bvh) fn refit(&mut self, leaves: &[LeafTriangle]) {
        if self.slots.is_empty() {
            self.slots = on_pool(|| block_slots(&self.triangles, leaves));
        }
        let moved = |(block, slots): (&mut TriangleBlock, &[u32; NATIVE])| {
            let rows = slots.iter().map_while(|&slot| leaves.get(slot as usize));
            rows.enumerate()
                .for_each(|(lane, row)| block.put(lane, row));
            block.bounds()
        };
        // Leaves lie in the order of the binary tree, so that blocks find them far from each other.
        let fetch = |slots: &[u32; NATIVE]| {
            let used = slots.iter().take_while(|&&slot| slot != UNUSED);
            used.for_each(|&slot| prefetch(leaves, slot));
        };
        let parts = self
            .triangles
            .chunks_mut(GRAIN)
            .zip(self.slots.chunks(GRAIN));
        let blocks = map_on_pool(parts, |(blocks, slots)| {
            let blocks = blocks.iter_mut().zip(slots).enumerate();
            let moved = blocks.map(|(k, block)| {
                slots.get(k + AHEAD).map(fetch);
                moved(block)
            });
            moved.collect::<Vec<Bounds>>()
        });
        map_on_pool(self.nodes.chunks_mut(GRAIN / 8), |nodes| {
            for node in nodes {
                for lane in 0..NATIVE {
                    if let ChildRef::Triangles(k) = ChildRef::of_code(node.children[lane]) {
                        let k = k as usize;
                        node.set_box(lane, &blocks[k / GRAIN][k % GRAIN]);
                    }
                }
            }
        });
        // Children stand behind their parents.
        for k in (0..self.nodes.len()).rev() {
            for lane in 0..NATIVE {
                if let ChildRef::Node(child) = ChildRef::of_code(self.nodes[k].children[lane]) {
                    let bounds = self.nodes[child as usize].child_bounds();
                    self.nodes[k].set_box(lane, &bounds);
                }
            }
        }
    }
}

/// Rows of the triangles in blocks.
fn block_slots(blocks: &[TriangleBlock], leaves: &[LeafTriangle]) -> Vec<[u32; NATIVE]> {
    let last = leaves.iter().map(|row| row.prim_id).max().unwrap_or(0);
    let mut slots = vec![UNUSED; last as usize + 1];
    for (slot, row) in leaves.iter().enumerate() {
        slots[row.prim_id as usize] = slot as u32;
    }
    let slot = |prim: u32| slots.get(prim as usize).copied().unwrap_or(UNUSED);
    (blocks.par_iter())
        .map(|block| block.prim_id.map(slot))
        .collect()
}

impl WideNode {
    #[inline(always)]
    pub(super) fn set_box(&mut self, lane: usize, bounds: &Bounds) {
        for axis in 0..3 {
            self.boxes[0][axis][lane] = bounds.lo[axis];
            self.boxes[1][axis][lane] = bounds.hi[axis];
        }
    }

    /// The box around all children; missing ones have an empty box.
    fn child_bounds(&self) -> Bounds {
        let [lo, hi] = &self.boxes;
        let least = |axis: &[f32; NATIVE]| axis.iter().copied().fold(f32::INFINITY, f32::min);
        let most = |axis: &[f32; NATIVE]| axis.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        Bounds::new(
            Vec3::from_array(lo.each_ref().map(least)),
            Vec3::from_array(hi.each_ref().map(most)),
        )
    }
}

impl TriangleBlock {
    /// The box around the padded boxes of all triangles. Unused lanes are NaN.
    fn bounds(&self) -> Bounds {
        let [a, b, c] = (self.vertices).map(|corner| corner.map(Native::new));
        let lo = [0, 1, 2].map(|axis| a[axis].min(b[axis]).min(c[axis]));
        let hi = [0, 1, 2].map(|axis| a[axis].max(b[axis]).max(c[axis]));
        let far = [0, 1, 2].map(|axis| lo[axis].abs().max(hi[axis].abs()));
        let far = far[0].max(far[1]).max(far[2]);
        let (pad, used) = (far * Native::splat(PAD), far.eq(far));
        let least = lo.map(|lo| {
            used.select(lo - pad, Native::splat(f32::INFINITY))
                .min_element()
        });
        let most = hi.map(|hi| {
            used.select(hi + pad, Native::splat(f32::NEG_INFINITY))
                .max_element()
        });
        Bounds::new(least.into(), most.into())
    }
}
