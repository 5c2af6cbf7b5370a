//! Refit of the wide tree: its triangles lie where those of the binary tree do, and the boxes
//! around them follow.

use super::rows::{ChildRef, TriangleBlock, WideBvh, WideNode};
use crate::bvh::leaf::LeafTriangle;
use crate::prefetch::prefetch;
use crate::simd::{LaneMask, Lanes, NATIVE, Native};
use glam::Vec3;
use phalanx_scene::{Bounds, PAD, map_on_pool, on_pool};
use rayon::prelude::*;
use std::ops::Range;

/// Rows that a thread takes at a time.
const GRAIN: usize = 1 << 10;

/// Blocks ahead of the one that is moved, whose triangles are prefetched.
const AHEAD: usize = 8;

/// Slot of a lane without a triangle.
const UNUSED: u32 = u32::MAX;

impl WideBvh {
    /// Moves the triangles, and the boxes around them, to where the binary tree has them now.
    /// `root` is that of the part's binary tree, `rows` are its triangles there.
    pub(in crate::bvh) fn refit(&mut self, root: u32, leaves: &[LeafTriangle], rows: Range<usize>) {
        let part = self.own.get_mut(&root).unwrap_or(&mut self.world);
        let triangles = &mut self.triangles[part.triangles.clone()];
        if part.slots.is_empty() {
            part.slots = on_pool(|| block_slots(triangles, leaves, rows));
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
        let parts = triangles.chunks_mut(GRAIN).zip(part.slots.chunks(GRAIN));
        let blocks = map_on_pool(parts, |(blocks, slots)| {
            let blocks = blocks.iter_mut().zip(slots).enumerate();
            let moved = blocks.map(|(k, block)| {
                slots.get(k + AHEAD).map(fetch);
                moved(block)
            });
            moved.collect::<Vec<Bounds>>()
        });
        let first = part.triangles.start;
        map_on_pool(
            self.nodes[part.nodes.clone()].chunks_mut(GRAIN / 8),
            |nodes| {
                for node in nodes {
                    for lane in 0..NATIVE {
                        if let ChildRef::Triangles(k) = ChildRef::of_code(node.children[lane]) {
                            let k = k as usize - first;
                            node.set_box(lane, &blocks[k / GRAIN][k % GRAIN]);
                        }
                    }
                }
            },
        );
        // Children stand behind their parents.
        for k in part.nodes.clone().rev() {
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
fn block_slots(
    blocks: &[TriangleBlock],
    leaves: &[LeafTriangle],
    rows: Range<usize>,
) -> Vec<[u32; NATIVE]> {
    let prims = leaves[rows.clone()].iter().map(|row| row.prim_id);
    let first = prims.clone().min().unwrap_or(0);
    let last = prims.clone().max().unwrap_or(0);
    let mut slots = vec![UNUSED; (last - first) as usize + 1];
    for (slot, prim) in rows.zip(prims) {
        slots[(prim - first) as usize] = slot as u32;
    }
    let slot = |prim: u32| {
        let row = prim.wrapping_sub(first) as usize;
        slots.get(row).copied().unwrap_or(UNUSED)
    };
    (blocks.par_iter())
        .map(|block| block.prim_id.map(slot))
        .collect()
}

impl WideNode {
    /// The box of a child.
    pub(super) fn bounds(&self, lane: usize) -> Bounds {
        let [lo, hi] = self.boxes.map(|corner| corner.map(|axis| axis[lane]));
        Bounds::new(lo.into(), hi.into())
    }

    #[inline(always)]
    pub(super) fn set_box(&mut self, lane: usize, bounds: &Bounds) {
        for axis in 0..3 {
            self.boxes[0][axis][lane] = bounds.lo[axis];
            self.boxes[1][axis][lane] = bounds.hi[axis];
        }
    }

    /// The box around all children; missing ones have an empty box.
    pub(super) fn child_bounds(&self) -> Bounds {
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
    pub(super) fn bounds(&self) -> Bounds {
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
