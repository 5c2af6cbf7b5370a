//! Primitives and instances that leave the wide tree, after they have left the binary one.

use super::rows::{ChildRef, SphereBlock, TriangleBlock, WideBvh};
use crate::bvh::LeafPrims;
use crate::bvh::leaving::{Leaving, RowKey};
use crate::simd::NATIVE;
use glam::Vec3;
use phalanx_scene::{Bounds, NO_PRIM};

impl WideBvh {
    /// Removes rows from the world's tree; `leaves` are those of the binary tree.
    pub(in crate::bvh) fn erase(&mut self, leaving: &Leaving, leaves: &LeafPrims) {
        let first = self.world.nodes.start;
        let (mut visited, mut waiting) = (Vec::new(), vec![first]);
        while let Some(index) = waiting.pop() {
            visited.push(index);
            let node = &self.nodes[index];
            for lane in 0..NATIVE {
                if let ChildRef::Node(child) = ChildRef::of_code(node.children[lane])
                    && leaving.may_be_in(&node.bounds(lane))
                {
                    waiting.push(child as usize);
                }
            }
        }
        let mut shrunk = vec![false; self.world.nodes.len()];
        // Children were visited after their parents.
        for &index in visited.iter().rev() {
            for lane in 0..NATIVE {
                let node = &self.nodes[index];
                if !leaving.may_be_in(&node.bounds(lane)) {
                    continue;
                }
                let rest = match ChildRef::of_code(node.children[lane]) {
                    ChildRef::Node(child) => {
                        let child = child as usize;
                        shrunk[child - first].then(|| self.nodes[child].child_bounds())
                    }
                    ChildRef::Triangles(k) => self.triangles[k as usize].retain(leaving),
                    ChildRef::Spheres(k) => self.spheres[k as usize].retain(leaving),
                    ChildRef::Other(k) => {
                        let leaf = &mut self.others[k as usize];
                        let rows = leaf.first as usize..(leaf.first + leaf.count) as usize;
                        let rest = leaves.column(leaf.kind).staying(rows, leaving);
                        rest.map(|(count, bounds)| {
                            leaf.count = count;
                            bounds
                        })
                    }
                };
                if let Some(bounds) = rest {
                    let node = &mut self.nodes[index];
                    node.set_box(lane, &bounds);
                    if bounds.is_empty() {
                        node.children[lane] = ChildRef::NOTHING.code();
                    }
                    shrunk[index - first] = true;
                }
            }
        }
        // The rows of the binary tree have changed places.
        self.world.slots = Vec::new();
    }
}

impl TriangleBlock {
    /// Keeps the triangles that stay; returns their box, or `None` if all of them do.
    fn retain(&mut self, leaving: &Leaving) -> Option<Bounds> {
        retain(&mut self.prim_id, leaving, |from, to| {
            for column in self.vertices.as_flattened_mut() {
                column[to] = from.map_or(f32::NAN, |from| column[from]);
            }
        })
        .then(|| self.bounds())
    }
}

impl SphereBlock {
    /// Keeps the spheres that stay; returns their box, or `None` if all of them do.
    fn retain(&mut self, leaving: &Leaving) -> Option<Bounds> {
        let boxes = self.prim_aabb.as_flattened_mut().iter_mut();
        let mut columns: Vec<&mut [f32; NATIVE]> = self.center.iter_mut().collect();
        columns.push(&mut self.radius);
        columns.extend(boxes);
        let some_leave = retain(&mut self.prim_id, leaving, |from, to| {
            for column in &mut columns {
                column[to] = from.map_or(f32::NAN, |from| column[from]);
            }
        });
        if !some_leave {
            return None;
        }
        let corner = |side: usize, lane: usize| {
            Vec3::from_array([0, 1, 2].map(|axis| self.prim_aabb[side][axis][lane]))
        };
        let used = (0..NATIVE).filter(|&lane| self.prim_id[lane] != NO_PRIM);
        let boxes = used.map(|lane| Bounds::new(corner(0, lane), corner(1, lane)));
        Some(boxes.fold(Bounds::EMPTY, Bounds::union))
    }
}

/// Moves the lanes that stay to the front, and empties the others; returns true if there are any.
fn retain(
    prims: &mut [u32; NATIVE],
    leaving: &Leaving,
    mut write: impl FnMut(Option<usize>, usize),
) -> bool {
    let stays = |prim: u32| prim == NO_PRIM || leaving.spares(RowKey::Prim(prim));
    if prims.iter().all(|&prim| stays(prim)) {
        return false;
    }
    let mut count = 0;
    for lane in 0..NATIVE {
        if prims[lane] != NO_PRIM && stays(prims[lane]) {
            write(Some(lane), count);
            prims[count] = prims[lane];
            count += 1;
        }
    }
    for (lane, prim) in prims.iter_mut().enumerate().skip(count) {
        write(None, lane);
        *prim = NO_PRIM;
    }
    true
}
