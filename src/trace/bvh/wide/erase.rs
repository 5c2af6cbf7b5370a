//! Primitives and instances that leave the wide tree, after they have left the binary one.

use super::rows::{ChildRef, SphereBlock, TriangleBlock, WideBvh};
use crate::bvh::LeafPrims;
use crate::bvh::erase::Leaving;
use crate::bvh::leaf_column::RowKey;
use crate::simd::NATIVE;
use glam::Vec3;
use phalanx_scene::Bounds;

impl WideBvh {
    /// Removes rows from the world's tree; `leaves` are those of the binary tree.
    pub(in crate::bvh) fn erase(&mut self, leaving: &Leaving, leaves: &LeafPrims) {
        let (mut visited, mut waiting) = (Vec::new(), vec![self.world.nodes.start]);
        while let Some(index) = waiting.pop() {
            visited.push(index);
            let node = &self.nodes[index];
            let below = (0..NATIVE).filter(|&lane| leaving.may_be_in(&node.bounds(lane)));
            waiting.extend(
                below.filter_map(|lane| match ChildRef::of_code(node.children[lane]) {
                    ChildRef::Node(child) => Some(child as usize),
                    _ => None,
                }),
            );
        }
        // Children were visited after their parents.
        for &index in visited.iter().rev() {
            for lane in 0..NATIVE {
                let node = &self.nodes[index];
                if !leaving.may_be_in(&node.bounds(lane)) {
                    continue;
                }
                let code = node.children[lane];
                let bounds = match ChildRef::of_code(code) {
                    ChildRef::Node(child) => self.nodes[child as usize].child_bounds(),
                    ChildRef::Triangles(k) => self.triangles[k as usize].retain(leaving),
                    ChildRef::Spheres(k) => self.spheres[k as usize].retain(leaving),
                    ChildRef::Other(k) => {
                        let leaf = &mut self.others[k as usize];
                        // What has left stands behind what stays.
                        let rows = leaf.first as usize..(leaf.first + leaf.count) as usize;
                        let column = leaves.column(leaf.kind);
                        let (count, bounds) = column.count(rows, &|row| leaving.spares(row));
                        leaf.count = count;
                        bounds
                    }
                };
                let node = &mut self.nodes[index];
                node.set_box(lane, &bounds);
                if bounds.is_empty() {
                    node.children[lane] = ChildRef::NOTHING.code();
                }
            }
        }
        // The rows of the binary tree have changed places.
        self.world.slots = Vec::new();
    }
}

impl TriangleBlock {
    /// Keeps the triangles that stay; returns their box.
    fn retain(&mut self, leaving: &Leaving) -> Bounds {
        retain(&mut self.prim_id, leaving, |from, to| {
            for column in self.vertices.as_flattened_mut() {
                column[to] = from.map_or(f32::NAN, |from| column[from]);
            }
        });
        self.bounds()
    }
}

impl SphereBlock {
    /// Keeps the spheres that stay; returns their box.
    fn retain(&mut self, leaving: &Leaving) -> Bounds {
        let boxes = self.prim_aabb.as_flattened_mut().iter_mut();
        let mut columns: Vec<&mut [f32; NATIVE]> = self.center.iter_mut().collect();
        columns.push(&mut self.radius);
        columns.extend(boxes);
        retain(&mut self.prim_id, leaving, |from, to| {
            for column in &mut columns {
                column[to] = from.map_or(f32::NAN, |from| column[from]);
            }
        });
        let corner = |side: usize, lane: usize| {
            Vec3::from_array([0, 1, 2].map(|axis| self.prim_aabb[side][axis][lane]))
        };
        let used = (0..NATIVE).filter(|&lane| self.prim_id[lane] != u32::MAX);
        let boxes = used.map(|lane| Bounds::new(corner(0, lane), corner(1, lane)));
        boxes.fold(Bounds::EMPTY, Bounds::union)
    }
}

/// Moves the lanes that stay to the front, and empties the others.
fn retain(
    prims: &mut [u32; NATIVE],
    leaving: &Leaving,
    mut write: impl FnMut(Option<usize>, usize),
) {
    let stays = |prim: u32| prim != u32::MAX && leaving.spares(RowKey::Prim(prim));
    let lanes: Vec<usize> = (0..NATIVE).filter(|&lane| stays(prims[lane])).collect();
    for (to, &from) in lanes.iter().enumerate() {
        write(Some(from), to);
        prims[to] = prims[from];
    }
    for to in lanes.len()..NATIVE {
        write(None, to);
        prims[to] = u32::MAX;
    }
}
