//! Packets of rays, together through the binary tree (Wald et al., "Interactive Rendering with
//! Coherent Ray Tracing", 2001).
//!
//! A node is visited once for all rays of a packet. A child is entered if any ray meets its box
//! before the ray's closest hit so far. Lanes without a ray have a closest hit of −∞ and so never
//! pass a comparison: no mask is needed.

use super::counters::Counters;
use super::leaf_slots::slots_of;
use super::prefetch::prefetch_children;
use crate::bvh::{Bvh, Child, LeafKind};
use crate::intersect::aabb::{SlabTest, TInterval};
use crate::intersect::hit::inactive_t;
use crate::intersect::instance;
use crate::intersect::ray_setup::RaySetup;
use crate::intersect::slab_conservative::ConservativeSlabs;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{F32x8, LANES, LaneMask, Lanes, Mask8};
use crate::traverse::every_hit::{EveryHit, FoundHits};
use crate::traverse::next_hit::{HitsByLane, NextHit, NextHits};
use crate::traverse::query::{AnyHit, ClosestHit, Query};
use std::cell::{Cell, RefCell};
use std::ops::Range;

/// A child waiting to be visited.
#[derive(Clone, Copy)]
struct StackEntry<L> {
    /// Entry distance; NaN in lanes that miss the box.
    enter: L,
    first: u32,
    tag: u16,
}

thread_local! {
    /// The stack of a thread's packets of one.
    static STACK: Cell<Vec<StackEntry<F32x8>>> = const { Cell::new(Vec::new()) };
}

impl<'a, T: Counters> PacketKernel<'a, F32x8, T> {
    /// A kernel with the stack of the thread, which keeps its memory from one to the next.
    pub(super) fn of_thread(bvh: &'a Bvh) -> PacketKernel<'a, F32x8, T> {
        // There is none any more while the thread ends, nor a place to give it back to.
        PacketKernel::with_stack(bvh, STACK.try_with(Cell::take).unwrap_or_default())
    }

    /// Gives the stack back to the thread.
    #[inline(never)]
    pub(super) fn give_back(self) {
        let _ = STACK.try_with(|stack| stack.set(self.stack));
    }
}

/// Traces packets against one tree, and counts by `T`. It owns the traversal stack, so that tracing
/// allocates nothing.
pub(super) struct PacketKernel<'a, L, T> {
    bvh: &'a Bvh,
    /// True if the tree holds neither cones nor instances: see [`PacketKernel::traverse`].
    no_cones_or_instances: bool,
    stack: Vec<StackEntry<L>>,
    /// Counters since the kernel was made.
    pub(super) counters: T,
}

impl<'a, L: Lanes, T: Counters> PacketKernel<'a, L, T> {
    /// A kernel for a tree that counts what `T` counts.
    pub(super) fn counting(bvh: &'a Bvh) -> PacketKernel<'a, L, T> {
        PacketKernel::with_stack(bvh, Vec::new())
    }

    /// As [`PacketKernel::counting`], with a stack that another kernel had.
    fn with_stack(bvh: &'a Bvh, mut stack: Vec<StackEntry<L>>) -> PacketKernel<'a, L, T> {
        let empty = StackEntry {
            enter: L::ZERO,
            first: 0,
            tag: 0,
        };
        // Every level of a path leaves at most one child waiting.
        stack.resize(bvh.depth() + 1, empty);
        let prims = bvh.leaf_prims();
        PacketKernel {
            bvh,
            no_cones_or_instances: prims.cones.is_empty() && prims.instances.is_empty(),
            stack,
            counters: T::default(),
        }
    }

    /// The closest hit below `tmax` of each active lane; other lanes are returned as a miss. It is
    /// inlined, because a call would cost a packet of a small scene 4 % of its instructions. The
    /// kernel is large, so only [`Traversal`](super::Traversal) has it so, once for each number of
    /// lanes.
    #[inline(always)]
    pub(super) fn closest(&mut self, rays: &RayPacket<L>, active: L::Mask) -> HitPacket<L> {
        let mut query = ClosestHit::new(active.select(rays.tmax, inactive_t()));
        self.run(rays, active, &mut query);
        query.hits(rays.tmax, active)
    }

    /// Active lanes that hit anything before `tmax`; inlined as [`PacketKernel::closest`].
    #[inline(always)]
    pub(super) fn occluded(&mut self, rays: &RayPacket<L>, active: L::Mask) -> L::Mask {
        let mut query = AnyHit::new(active.select(rays.tmax, inactive_t()), active);
        self.run(rays, active, &mut query);
        query.occluded()
    }

    /// The closest hit of each active lane that comes after `after`, by (t, prim_id), and below
    /// `tmax`; other lanes are returned as a miss.
    #[inline(never)]
    pub(super) fn next(
        &mut self,
        rays: &RayPacket<L>,
        active: L::Mask,
        after: &HitPacket<L>,
    ) -> HitPacket<L> {
        let limit = active.select(rays.tmax, inactive_t());
        let mut query = NextHit::new(limit, after.t, after.prim_id);
        self.run(rays, active, &mut query);
        query.hits(rays.tmax, active)
    }

    /// Everything that active lanes hit before `tmax`; the ray in the first lane has the number
    /// `first_ray`.
    #[inline(never)]
    pub(super) fn every_hit(
        &mut self,
        rays: &RayPacket<L>,
        active: L::Mask,
        first_ray: usize,
        hit_list: &FoundHits,
    ) {
        let limit = active.select(rays.tmax, inactive_t());
        let mut query = EveryHit::new(limit, first_ray, hit_list);
        self.run_shared(rays, active, &mut query);
    }

    /// The hits of [`PacketKernel::closest`], by the shared traversal.
    #[inline(never)]
    pub(super) fn call_closest(&mut self, rays: &RayPacket<L>, active: L::Mask) -> HitPacket<L> {
        let mut query = ClosestHit::new(active.select(rays.tmax, inactive_t()));
        self.run_shared(rays, active, &mut query);
        query.hits(rays.tmax, active)
    }

    /// The lanes of [`PacketKernel::occluded`], by a call. Kernels that count share a traversal;
    /// beams leave many packets, and would be 8 % slower with it in a room.
    #[inline(never)]
    pub(super) fn call_occluded(&mut self, rays: &RayPacket<L>, active: L::Mask) -> L::Mask {
        if !T::COUNTS_STEPS {
            return self.occluded(rays, active);
        }
        let mut query = AnyHit::new(active.select(rays.tmax, inactive_t()), active);
        self.run_shared(rays, active, &mut query);
        query.occluded()
    }

    #[inline(always)]
    fn run(&mut self, rays: &RayPacket<L>, active: L::Mask, query: &mut impl Query<L>) {
        self.counters
            .begin(L::PACKETS as u64, active.bits().count_ones());
        let (rays, world) = (
            &RaySetup::new(rays, active),
            TraversalRoot { root: 0, floor: 0 },
        );
        if self.no_cones_or_instances {
            self.descend::<_, true>(rays, query, world);
        } else {
            self.descend::<_, false>(rays, query, world);
        }
    }

    /// As [`PacketKernel::run`], by the shared traversal.
    #[inline(always)]
    fn run_shared(&mut self, rays: &RayPacket<L>, active: L::Mask, query: &mut impl Query<L>) {
        self.counters
            .begin(L::PACKETS as u64, active.bits().count_ones());
        let world = TraversalRoot { root: 0, floor: 0 };
        self.descend_shared(&RaySetup::new(rays, active), query, world);
    }

    /// The one traversal of a rare query, or of a kernel that counts: for every tree, and for rays
    /// of all octants and axes. It is called, and calls the tests of leaves, because all that is
    /// inlined is compiled once more (`perf/notes/compile-time.md`).
    #[inline(never)]
    fn descend_shared<G: Query<L>>(
        &mut self,
        rays: &RaySetup<L>,
        query: &mut G,
        tree: TraversalRoot,
    ) {
        let cull = &ConservativeSlabs::new(&rays.rays, &rays.slabs);
        let octant = rays.slabs.octant;
        self.traverse::<G, false, true>(rays, query, tree, |b| cull.intersect_box(b, octant));
    }

    #[inline(always)]
    fn descend<G: Query<L>, const NO_CONES_OR_INSTANCES: bool>(
        &mut self,
        rays: &RaySetup<L>,
        query: &mut G,
        tree: TraversalRoot,
    ) {
        let cull = &ConservativeSlabs::new(&rays.rays, &rays.slabs);
        match rays.slabs.octant {
            Some(near) => {
                self.traverse::<G, NO_CONES_OR_INSTANCES, false>(rays, query, tree, |b| {
                    cull.intersect_box_same_octant(b, near)
                })
            }
            None => self.traverse::<G, NO_CONES_OR_INSTANCES, false>(rays, query, tree, |b| {
                cull.intersect_box_mixed(b)
            }),
        }
    }

    /// Visits leaves front to back until the query is done.
    ///
    /// Cones and instances are tested by calls, across which nothing stays in a register. The mere
    /// presence of such calls cost every other scene 10 to 25 %. So trees without either
    /// (`NO_CONES_OR_INSTANCES`) have a traversal of their own
    /// (`perf/notes/plain-trees.md`).
    #[inline(always)]
    fn traverse<G: Query<L>, const NO_CONES_OR_INSTANCES: bool, const SHARED: bool>(
        &mut self,
        rays: &RaySetup<L>,
        query: &mut G,
        tree: TraversalRoot,
        interval: impl Fn(&[[f32; 3]; 2]) -> TInterval<L>,
    ) {
        let nodes = self.bvh.nodes();
        let triangles = &self.bvh.leaf_prims().triangles[..];
        let mut top = tree.floor;
        let mut current = Child::Node(tree.root);
        let lanes = (L::PACKETS * LANES) as u64;
        loop {
            while let Child::Node(index) = current {
                self.counters.node(lanes);
                // SAFETY: a `Bvh` comes from its builder or was proven (`bvh::UnverifiedBvh`):
                // every child node has an index below `nodes().len()`; node 0 exists.
                let node = unsafe { nodes.get_unchecked(index as usize) };
                if G::FRONT_TO_BACK {
                    // A tenth more instructions, and 4 % less time for divergent rays. No gain for
                    // coherent occlusion rays.
                    prefetch_children(node, nodes, triangles);
                }
                let intervals = [interval(&node.boxes[0]), interval(&node.boxes[1])];
                let met = intervals.each_ref().map(|s| query.overlaps(s));
                match (met[0].any(), met[1].any()) {
                    (false, false) => current = Child::EMPTY,
                    (true, false) => current = node.child(0),
                    (false, true) => current = node.child(1),
                    (true, true) => {
                        let near =
                            if G::FRONT_TO_BACK { nearer_child::<L>(met, &intervals) } else { 0 };
                        let (first, tag) = node.packed(1 - near);
                        // Blended, not branched on: which child is nearer cannot be predicted.
                        let nan = L::splat(f32::NAN);
                        let waiting = [1, 0].map(|k: usize| met[k].select(intervals[k].tnear, nan));
                        let enter = L::Mask::splat(near == 1).select(waiting[1], waiting[0]);
                        // SAFETY: each level of a path leaves at most one entry, the stack is
                        // `depth() + 1` long, and `Bvh::depth` counts the longest path, through an
                        // instance if there are any.
                        let slot = unsafe { self.stack.get_unchecked_mut(top) };
                        *slot = StackEntry { enter, first, tag };
                        top += 1;
                        current = node.child(near);
                    }
                }
            }
            if let Child::Leaf { kind, first, count } = current {
                let slots = first as usize..(first + count) as usize;
                self.counters.leaf(kind, lanes, slots.len());
                let done = match kind {
                    _ if SHARED => self.intersect_leaf(rays, query, kind, slots, top),
                    LeafKind::Instance if !NO_CONES_OR_INSTANCES => {
                        // Copies: a value whose address is passed to a call no longer stays in
                        // registers.
                        let (copy, mut inside) = (*rays, *query);
                        let done = self.instances(&copy, &mut inside, slots, top);
                        *query = inside;
                        done
                    }
                    _ => query.intersect_leaf::<NO_CONES_OR_INSTANCES>(self.bvh, rays, kind, slots),
                };
                if done {
                    return;
                }
            }
            // The next waiting child that some ray still reaches.
            current = loop {
                if top == tree.floor {
                    return;
                }
                top -= 1;
                // SAFETY: `top` entries were written above, and one was just taken off that count.
                let entry = unsafe { self.stack.get_unchecked(top) };
                if entry.enter.le(query.reach()).any() {
                    break Child::unpack(entry.first, entry.tag);
                }
            };
        }
    }

    /// Tests a leaf by calls, also by itself for rays that reached it through another tree; true
    /// ends their traversal. The stack is free from `floor` on.
    #[inline(always)]
    pub(super) fn intersect_leaf<G: Query<L>>(
        &mut self,
        rays: &RaySetup<L>,
        query: &mut G,
        kind: LeafKind,
        slots: Range<usize>,
        floor: usize,
    ) -> bool {
        match kind {
            LeafKind::Instance => self.instances(rays, query, slots, floor),
            LeafKind::Prim(kind) => query.call_leaf(self.bvh, rays, kind, slots),
        }
    }

    /// Traverses the trees of instances, with the rays in their space: see [`instance`].
    #[inline(never)]
    fn instances<G: Query<L>>(
        &mut self,
        rays: &RaySetup<L>,
        query: &mut G,
        slots: Range<usize>,
        floor: usize,
    ) -> bool {
        for (k, slot) in slots
            .clone()
            .zip(slots_of(&self.bvh.leaf_prims().instances, slots))
        {
            let interval = rays.slabs.intersect_box(&slot.prim_aabb);
            let Some(mut inner) = query.enter_instance(&interval, slot.id_offset) else {
                continue;
            };
            let active = inner.limit().gt(inactive_t());
            let moved = RaySetup::new(&instance::to_object(&rays.rays, slot), active);
            let tree = TraversalRoot {
                root: slot.root,
                floor,
            };
            if T::COUNTS_STEPS || !G::OFTEN {
                self.descend_shared(&moved, &mut inner, tree);
            } else {
                self.descend::<_, false>(&moved, &mut inner, tree);
            }
            if let Some(best) = query.tied(&inner, &interval) {
                let mut again = NextHit::new(best.t, inactive_t(), best.prim_id);
                again.best = best;
                self.instances(rays, &mut again, k..k + 1, floor);
                query.take_tied(again.best);
            } else if query.exit_instance(inner, &interval, slot.id_offset) {
                return true;
            }
        }
        false
    }
}

impl<T: Counters> PacketKernel<'_, F32x8, T> {
    /// Adds the closest hits of each active lane that come after `after` and before `tmax` to its
    /// list, in no order: `most` at least, or all.
    #[inline(never)]
    pub(super) fn next_hits(
        &mut self,
        rays: &RayPacket,
        active: Mask8,
        after: &HitPacket,
        most: usize,
        hits: &RefCell<HitsByLane>,
    ) {
        let limit = active.select(rays.tmax, inactive_t());
        let next = NextHit::new(limit, after.t, after.prim_id);
        self.run_shared(rays, active, &mut NextHits::new(next, most, hits));
    }
}

/// Root of a tree, and the first stack entry that its traversal may use.
#[derive(Clone, Copy)]
struct TraversalRoot {
    root: u32,
    floor: usize,
}

/// The child that more of the rays that meet both enter first. For divergent rays this is a better
/// guess than one order per octant.
#[inline(always)]
fn nearer_child<L: Lanes>(met: [L::Mask; 2], intervals: &[TInterval<L>; 2]) -> usize {
    let both = met[0] & met[1];
    let first = (both & intervals[0].tnear.lt(intervals[1].tnear))
        .bits()
        .count_ones();
    let second = (both & intervals[1].tnear.lt(intervals[0].tnear))
        .bits()
        .count_ones();
    usize::from(second > first)
}
