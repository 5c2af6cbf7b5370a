//! Traversal of the wide tree by a beam: a mask of sub-beams on the stack, the nearest child first.

use super::block::BeamTriangles;
use super::deferred::DeferredBlocks;
use super::pairs::Pairs;
use super::state::BeamTraversal;
use crate::bvh::leaf::LeafSphere;
use crate::bvh::{ChildRef, LeafKind, OtherLeaf, SphereBlock, TriangleBlock, WideBvh, WideNode};
use crate::intersect::leaf_prim::LeafPrim;
use crate::intersect::shear::MIXED;
use crate::simd::{LANES, LaneMask, Lanes, NATIVE, Native, NativeMask};
use crate::traverse::counters::Counters;
use crate::traverse::query::Query;

/// A child that some sub-beams may still hit.
#[derive(Clone, Copy)]
struct BeamStackEntry {
    sub_beams: u64,
    /// Depth at which the child's box begins.
    near: f32,
    code: u32,
}

/// Stack of waiting children.
pub(super) struct Stack(Vec<BeamStackEntry>);

impl Stack {
    pub(super) fn new(wide: &WideBvh) -> Stack {
        let empty = BeamStackEntry {
            sub_beams: 0,
            near: 0.0,
            code: 0,
        };
        // A node pops one entry and leaves `NATIVE` at most.
        Stack(vec![empty; wide.depth() * (NATIVE - 1) + 1])
    }
}

impl<'a, L: Lanes, G: Query<L>, T: Counters> BeamTraversal<'_, 'a, L, G, T> {
    /// Visits the nodes and leaves that the sub-beams hit, front to back.
    #[inline(never)]
    pub(super) fn traverse(mut self, stack: &mut Stack, deferred: &mut DeferredBlocks<'a>) {
        let entries = &mut stack.0[..];
        let all = self.sub_beams.all();
        if all == 0 {
            return;
        }
        entries[0] = BeamStackEntry {
            sub_beams: all,
            near: f32::NEG_INFINITY,
            code: 0,
        };
        let mut top = 1;
        while top > 0 {
            top -= 1;
            // SAFETY: `top` entries were written.
            let entry = *unsafe { entries.get_unchecked(top) };
            let mask = self.sub_beams.reaching::<L>(entry.sub_beams, entry.near);
            if mask == 0 {
                continue;
            }
            match ChildRef::of_code(entry.code) {
                ChildRef::Node(index) => {
                    // SAFETY: a code of the tree is of a row that exists; node 0 exists.
                    let node = unsafe { self.wide.nodes().get_unchecked(index as usize) };
                    // SAFETY: each level of a path leaves at most `NATIVE` − 1 entries beside the
                    // one that is followed, and the stack is as long as that; so there is room for
                    // `NATIVE` more.
                    top += self.node(node, mask, unsafe { entries.get_unchecked_mut(top..) });
                }
                ChildRef::Triangles(index) => {
                    // SAFETY: as above.
                    let block = unsafe { self.wide.triangles().get_unchecked(index as usize) };
                    if G::FRONT_TO_BACK {
                        self.triangles(block, mask, &mut deferred.pairs);
                    } else {
                        self.rows.prefetch(entry.code);
                        self.defer(block, mask, deferred);
                    }
                }
                ChildRef::Spheres(index) => {
                    // SAFETY: as above.
                    let block = unsafe { self.wide.spheres().get_unchecked(index as usize) };
                    self.spheres(block, mask);
                }
                ChildRef::Other(index) => self.other(self.wide.others()[index as usize], mask),
            }
        }
        if !G::FRONT_TO_BACK {
            self.test_deferred(deferred);
        }
    }

    /// Writes the children that sub-beams may hit, the nearest last, and returns their number.
    #[inline(always)]
    fn node(&mut self, node: &WideNode, mask: u64, above: &mut [BeamStackEntry]) -> usize {
        let seen = self.space.boxes(&node.boxes.map(|c| c.map(Native::new)));
        let mut left = self.sub_beams.any_meets(&seen);
        self.counters
            .wide_node(u64::from(left.count_ones()) * LANES as u64 + NATIVE as u64);
        let columns = [seen.low_p, seen.high_p, seen.low_q, seen.high_q, seen.near];
        let columns = columns.map(Native::to_array);
        let children = &node.order[self.space.axes[0] % 3];
        let mut order = in_order(children, left);
        let last = |order: u32, up: bool| {
            if up { 31 - order.leading_zeros() } else { order.trailing_zeros() }
        };
        let up = self.space.sign > 0.0;
        if left != 0 {
            // It is visited next, at once; a prefetch now may complete while the stack is written.
            let nearest = children[last(order, !up) as usize % NATIVE];
            self.prefetch(node.children[usize::from(nearest) % NATIVE]);
        }
        let mut count = 0;
        while left != 0 {
            let rank = last(order, up);
            order ^= 1 << (rank % NATIVE as u32);
            let lane = usize::from(children[rank as usize % NATIVE]) % NATIVE;
            left &= left - 1;
            let met = self.sub_beams.meeting::<L>(mask, &columns, lane);
            if met != 0 {
                let code = node.children[lane % NATIVE];
                // SAFETY: at most `NATIVE` children, and there is room for them: see `traverse`.
                *unsafe { above.get_unchecked_mut(count) } = BeamStackEntry {
                    sub_beams: met,
                    near: columns[4][lane % NATIVE],
                    code,
                };
                count += 1;
                if left != 0 {
                    self.prefetch(code);
                }
            }
        }
        count
    }

    /// Prefetches the target of a child. A deferred block is prefetched when it is deferred.
    #[inline(always)]
    fn prefetch(&self, code: u32) {
        if G::FRONT_TO_BACK {
            self.rows.prefetch(code);
        } else {
            self.rows.prefetch_node(code);
        }
    }

    #[inline(always)]
    fn triangles(&mut self, block: &TriangleBlock, mask: u64, pairs: &mut Pairs) {
        let triangles = BeamTriangles::new(self.space, block);
        pairs.count = 0;
        let mut left = mask;
        while left != 0 {
            let sub_beam = left.trailing_zeros() as usize;
            left &= left - 1;
            pairs.add(sub_beam, 0, self.sub_beams.hits(sub_beam, &triangles.seen));
        }
        let mut touched = 0u64;
        for k in 0..pairs.count {
            let (sub_beam, lane) = pairs.get(k);
            let group = self.sub_beams.group(sub_beam);
            // SAFETY: a sub-beam is of a packet of this beam, each of which has its entry in both.
            let rays = unsafe { self.groups.get_unchecked(group) };
            // SAFETY: as above.
            let query = unsafe { self.queries.get_unchecked_mut(group) };
            let met = match rays.shear.axis {
                MIXED => triangles.test_apart(lane, rays, query),
                _ => triangles.test(lane, rays, query),
            };
            touched |= u64::from(met) << sub_beam;
        }
        self.counters.block(
            LeafKind::TRIANGLE,
            (pairs.count * L::PACKETS * LANES) as u64,
        );
        self.refresh_depths(touched);
    }

    #[inline(always)]
    fn spheres(&mut self, block: &SphereBlock, mask: u64) {
        let seen = self
            .space
            .boxes(&block.prim_aabb.map(|c| c.map(Native::new)));
        let columns = [seen.low_p, seen.high_p, seen.low_q, seen.high_q, seen.near];
        let columns = columns.map(Native::to_array);
        let mut touched = 0u64;
        let mut tests = 0;
        for lane in NativeMask::from_bits(self.sub_beams.any_meets(&seen)).lanes() {
            let column = |c: &[[f32; NATIVE]; 3]| c.each_ref().map(|axis| axis[lane]);
            let sphere = LeafSphere {
                center: column(&block.center),
                radius: block.radius[lane],
                prim_aabb: block.prim_aabb.each_ref().map(column),
                prim_id: block.prim_id[lane],
            };
            let mut met = self.sub_beams.meeting::<L>(mask, &columns, lane);
            tests += met.count_ones();
            while met != 0 {
                let sub_beam = met.trailing_zeros() as usize;
                met &= met - 1;
                let group = self.sub_beams.group(sub_beam);
                // SAFETY: a sub-beam is of a packet of this beam, each of which has its entry in
                // both.
                let rays = unsafe { self.groups.get_unchecked(group) };
                // SAFETY: as above; and slabs were made because the tree has spheres.
                let slabs = unsafe { self.slabs.get_unchecked(group) };
                // SAFETY: as above.
                let query = unsafe { self.queries.get_unchecked_mut(group) };
                let rays = rays.prepared(slabs);
                if let Some(hit) = sphere.intersect::<L, false>(&rays, query.limit()) {
                    query.update(&hit, sphere.prim_id);
                    touched |= 1 << sub_beam;
                }
            }
        }
        self.counters.block(
            LeafKind::SPHERE,
            u64::from(tests) * (L::PACKETS * LANES) as u64,
        );
        self.refresh_depths(touched);
    }

    /// Tests a leaf of a kind without blocks, packet by packet.
    #[inline(never)]
    fn other(&mut self, leaf: OtherLeaf, mask: u64) {
        let slots = leaf.first as usize..(leaf.first + leaf.count) as usize;
        let (mut left, mut done) = (mask, 0u64);
        while left != 0 {
            let group = self.sub_beams.group(left.trailing_zeros() as usize);
            left &= left - 1;
            if done >> group & 1 == 0 {
                done |= 1 << group;
                let rays = self.groups[group].prepared(&self.slabs[group]);
                let query = &mut self.queries[group];
                self.packets
                    .intersect_leaf(&rays, query, leaf.kind, slots.clone(), 0);
            }
        }
        self.refresh_depths(mask);
    }
}

/// Children of an order that are among `some` (bits by lane), as bits by position in the order.
#[inline(always)]
fn in_order(children: &[u8; NATIVE], some: u32) -> u32 {
    let mut ranks = 0;
    for (rank, &child) in children.iter().enumerate() {
        ranks |= (some >> (child % NATIVE as u8) & 1) << rank;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_come_in_order() {
        // The first is the last but two, and so on.
        let children: [u8; NATIVE] = std::array::from_fn(|k| ((5 * k + NATIVE - 3) % NATIVE) as u8);
        for set in 0..1u32 << NATIVE {
            let some = in_order(&children, set);
            for (rank, &child) in children.iter().enumerate() {
                assert_eq!(some >> rank & 1, set >> child & 1, "{set:b}");
            }
            assert_eq!(some >> NATIVE, 0);
        }
    }
}
