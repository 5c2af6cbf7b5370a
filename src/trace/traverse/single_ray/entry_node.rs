//! A separate root for short rays that start close together: the nodes that all of them would
//! descend through are opened once for all (Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing
//! Algorithm", 2005, whose entry point is one node for a frustum; here it is a node made of the
//! children, of any level, whose boxes meet the rays' common box).

use super::ray_stream::RayOctets;
use crate::bvh::{ChildRef, WideBvh, WideNode};
use crate::intersect::aabb::REACH;
use crate::simd::{F32x8, LaneMask, Lanes, Mask8, NATIVE, Native};
use crate::traverse::counters::Counters;
use std::ops::Range;

/// Box around segments: lower and upper corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentBox([[f32; 3]; 2]);

/// Padding of a box around segments, as a share of its coordinates: 160 roundings of them. A ray
/// passes the own box of what it hits, up to a few of them.
const PADDING: f32 = 1e-5;

/// The same as a share of its extents: a ray passes that box no later than [`REACH`] of its end.
const END_PADDING: f32 = REACH - 1.0;

impl SegmentBox {
    /// The box around the rays of the given packets, from their origins to their limits; none if it
    /// is not finite.
    pub(super) fn around(rays: &impl RayOctets, packets: Range<usize>) -> Option<SegmentBox> {
        let infinity = F32x8::splat(f32::INFINITY);
        let (mut low, mut high) = ([infinity; 3], [-infinity; 3]);
        // A minimum would drop a NaN.
        let mut finite = Mask8::splat(true);
        for packet in packets {
            let (rays, active) = rays.packet(packet);
            let (org, dir, tmax) = (rays.org, rays.dir, rays.tmax);
            let ways = [(org.x, dir.x), (org.y, dir.y), (org.z, dir.z)];
            for (axis, (start, along)) in ways.into_iter().enumerate() {
                let end = start + along * tmax;
                finite = finite & ((end - start).abs().lt(infinity) | !active);
                low[axis] = low[axis].min(active.select(start.min(end), infinity));
                high[axis] = high[axis].max(active.select(start.max(end), -infinity));
            }
        }
        if (!finite).any() {
            return None;
        }
        let [low, high] = [low.map(F32x8::min_element), high.map(F32x8::max_element)];
        let padding = |axis: usize| {
            let (low, high): (f32, f32) = (low[axis], high[axis]);
            PADDING * low.abs().max(high.abs()) + END_PADDING * (high - low)
        };
        Some(SegmentBox([
            std::array::from_fn(|axis| low[axis] - padding(axis)),
            std::array::from_fn(|axis| high[axis] + padding(axis)),
        ]))
    }

    /// The children of a node whose boxes meet this one, as bits.
    fn met(&self, node: &WideNode) -> u32 {
        let [low, high] = &self.0;
        let axis = |axis: usize| {
            Native::new(node.boxes[0][axis]).le(Native::splat(high[axis]))
                & Native::splat(low[axis]).le(Native::new(node.boxes[1][axis]))
        };
        (axis(0) & axis(1) & axis(2)).bits()
    }
}

/// Maximum number of nodes opened besides the root. Each is several cache lines, fetched with no
/// other work to overlap, and few of the rays reach deeper nodes.
const MAX_OPENED: usize = 8;

/// Maximum number of the root's children that may overlap the rays' box. If it overlaps more, it is
/// so large that most nodes below would be visited anyway (`perf/notes/single-rays.md`).
const MAX_OF_ROOT: usize = NATIVE / 2;

/// Code of the tree's root.
pub(super) const ROOT: u32 = 0;

/// Children of nodes of any level, as those of one node.
pub(super) struct EntryNode {
    pub(super) node: WideNode,
    len: usize,
}

impl EntryNode {
    pub(super) fn new() -> EntryNode {
        EntryNode {
            node: WideNode::EMPTY,
            len: 0,
        }
    }

    /// Gathers the children that overlap a box. From the root on, a child that is a node is
    /// replaced by those of its own children that overlap the box, if there is room for them.
    /// Returns the code of the node where rays in the box begin, this one or the tree's root; none
    /// if nothing overlaps.
    pub(super) fn gather(
        &mut self,
        wide: &WideBvh,
        bounds: &SegmentBox,
        counters: &mut impl Counters,
    ) -> Option<u32> {
        let nodes = wide.nodes();
        (self.node, self.len) = (WideNode::EMPTY, 0);
        let met = bounds.met(&nodes[0]);
        if met.count_ones() as usize > MAX_OF_ROOT {
            return Some(ROOT);
        }
        self.append(&nodes[0], met);
        let (mut slot, mut opened) = (0, 0);
        while slot < self.len && opened < MAX_OPENED {
            slot += 1;
            let ChildRef::Node(index) = ChildRef::of_code(self.node.children[slot - 1]) else {
                continue;
            };
            counters.wide_node(NATIVE as u64);
            opened += 1;
            let node = &nodes[index as usize];
            let met = bounds.met(node);
            if self.len - 1 + met.count_ones() as usize <= NATIVE {
                slot -= 1;
                self.remove(slot);
                self.append(node, met);
            }
        }
        (self.len > 0).then_some(ChildRef::ELSEWHERE)
    }

    /// Appends the selected children of a node.
    fn append(&mut self, from: &WideNode, lanes: u32) {
        for lane in (0..NATIVE).filter(|lane| lanes >> lane & 1 == 1) {
            self.put(self.len, from, lane);
            self.len += 1;
        }
    }

    /// Removes a child; the last one takes its place.
    fn remove(&mut self, slot: usize) {
        self.len -= 1;
        let all = self.node;
        self.put(slot, &all, self.len);
        self.put(self.len, &WideNode::EMPTY, 0);
    }

    fn put(&mut self, slot: usize, from: &WideNode, lane: usize) {
        let columns = self.node.boxes.as_flattened_mut().iter_mut();
        for (to, column) in columns.zip(from.boxes.as_flattened()) {
            to[slot] = column[lane];
        }
        self.node.children[slot] = from.children[lane];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Bvh;
    use crate::packet::RayQueue;
    use crate::traverse::counters::PacketCount;
    use crate::traverse::single_ray::ray_stream::QueueRays;
    use bumpalo::Bump;
    use glam::Vec3;
    use phalanx_scene::Scene;

    /// A tree of spheres on a grid of 16 by 16 by 16, at a distance of 1.
    fn grid() -> Bvh {
        let mut scene = Scene::default();
        for k in 0..16 * 16 * 16 {
            let center = Vec3::new((k % 16) as f32, (k / 16 % 16) as f32, (k / 256) as f32);
            scene.add_sphere(center, 0.1, 0);
        }
        Bvh::build(&scene)
    }

    fn around(rays: &[([f32; 3], [f32; 3])], tmax: f32) -> Option<SegmentBox> {
        let arena = Bump::new();
        let mut queue = RayQueue::with_capacity(&arena, rays.len());
        for &(org, dir) in rays {
            queue.push_ray(org, dir);
        }
        let source = QueueRays { rays: &queue, tmax };
        SegmentBox::around(&source, 0..rays.len().div_ceil(8))
    }

    #[test]
    fn a_box_ends_where_its_segments_do() {
        let rays = [([1.0, 2.0, 3.0], [4.0, 0.0, -2.0]); 9];
        let SegmentBox([low, high]) = around(&rays, 0.5).unwrap();
        for (axis, (from, to)) in [(1.0, 3.0), (2.0, 2.0), (2.0, 3.0)].into_iter().enumerate() {
            assert!((from - 1e-3..from).contains(&low[axis]), "{low:?}");
            assert!(high[axis] > to && high[axis] < to + 1e-3, "{high:?}");
        }
    }

    #[test]
    fn rays_without_a_finite_end_have_no_box() {
        let usual = ([1.0, 2.0, 3.0], [4.0, 0.0, -2.0]);
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            for slot in 0..20 {
                let mut rays = [usual; 20];
                rays[slot].1[slot % 3] = odd;
                assert!(around(&rays, 2.0).is_none(), "{odd} {slot}");
                rays[slot] = usual;
                assert!(around(&rays, 2.0).is_some());
                rays[slot].0[slot % 3] = odd;
                assert!(
                    odd == f32::MAX || around(&rays, 2.0).is_none(),
                    "{odd} {slot}"
                );
            }
        }
    }

    /// Numbers of the primitives below a node, in order.
    fn prims(wide: &WideBvh, node: &WideNode, ids: &mut Vec<u32>) {
        for &code in &node.children {
            match ChildRef::of_code(code) {
                ChildRef::Node(index) => prims(wide, &wide.nodes()[index as usize], ids),
                ChildRef::Spheres(index) => {
                    ids.extend(wide.spheres()[index as usize].prim_id);
                }
                _ => {}
            }
        }
    }

    /// Checks that each sphere that touches the box is below the entry node, once, and that the
    /// node lies deep.
    #[test]
    fn all_that_touches_the_box_is_below_the_entry() {
        let bvh = grid();
        let (wide, mut entry, mut elsewhere) = (bvh.wide(), EntryNode::new(), 0);
        for k in 0..500 {
            let corner = [k % 17, k / 17 % 17, k * 7 % 17].map(|x| x as f32 - 0.7);
            let size = 0.3 + (k % 5) as f32;
            let bounds = SegmentBox([corner, corner.map(|x| x + size)]);
            let code = entry.gather(wide, &bounds, &mut PacketCount::default());
            if code == Some(ROOT) {
                continue;
            }
            elsewhere += 1;
            let mut ids = Vec::new();
            prims(wide, &entry.node, &mut ids);
            ids.retain(|&prim| prim != crate::packet::NO_PRIM);
            let all = ids.len();
            ids.sort_unstable();
            ids.dedup();
            assert_eq!(ids.len(), all, "each once");
            let touches = |prim: &u32| {
                let center = [prim % 16, prim / 16 % 16, prim / 256].map(|x| x as f32);
                (0..3).all(|axis| {
                    center[axis] + 0.1 >= corner[axis] && center[axis] - 0.1 <= corner[axis] + size
                })
            };
            let want: Vec<u32> = (0..16 * 16 * 16).filter(touches).collect();
            assert!(want.iter().all(|prim| ids.binary_search(prim).is_ok()));
            assert!(code.is_some() || want.is_empty());
            assert!(all < 600 + 20 * want.len(), "{all} for {}", want.len());
        }
        assert!(elsewhere > 300, "{elsewhere}");
    }
}
