//! Packets of rays together down the binary tree (Wald et al., "Interactive Rendering with Coherent Ray Tracing", 2001).
//!
//! A node is visited once for all rays of a packet; a child is entered if any ray meets its box before the ray's closest
//! hit so far. Lanes without a ray have a closest hit of −∞ and so never pass a comparison: there is no mask to carry.

use super::aabb::{Planes, Stay};
use super::cull::Cull;
use super::goal::{AnyHit, Closest, Goal, Prepared, nowhere};
use super::instance;
use super::tally::Tally;
use crate::bvh::{Bvh, Child, LeafKind};
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{LANES, LaneMask, Lanes};
use std::ops::Range;

/// A child waiting to be visited.
#[derive(Clone, Copy)]
struct Entry<L> {
    /// Entry distance; NaN in lanes that miss the box.
    enter: L,
    first: u32,
    tag: u16,
}

/// Traces packets against one tree, and counts by `T`. Owns the traversal stack, so that tracing allocates nothing.
pub(super) struct PacketKernel<'a, L, T> {
    bvh: &'a Bvh,
    /// Whether the tree holds neither cones nor instances: see [`PacketKernel::traverse`].
    plain: bool,
    stack: Vec<Entry<L>>,
    /// Counters since it was made.
    pub(super) work: T,
}

impl<'a, L: Lanes, T: Tally> PacketKernel<'a, L, T> {
    /// A tracer for a tree that counts what `T` counts.
    pub(super) fn counting(bvh: &'a Bvh) -> PacketKernel<'a, L, T> {
        let empty = Entry {
            enter: L::ZERO,
            first: 0,
            tag: 0,
        };
        PacketKernel {
            bvh,
            plain: bvh.cones().is_empty() && bvh.instances().is_empty(),
            // Every level of a path leaves at most one child waiting.
            stack: vec![empty; bvh.depth() + 1],
            work: T::default(),
        }
    }

    /// The closest hit below `tmax` of each active lane; others come back as a miss.
    #[inline(never)]
    pub(super) fn closest(&mut self, rays: &RayPacket<L>, active: L::Mask) -> HitPacket<L> {
        let mut goal = Closest::new(active.select(rays.tmax, nowhere()));
        self.run(rays, active, &mut goal);
        goal.hits(rays.tmax, active)
    }

    /// Which active lanes meet anything before `tmax`.
    #[inline(never)]
    pub(super) fn occluded(&mut self, rays: &RayPacket<L>, active: L::Mask) -> L::Mask {
        let mut goal = AnyHit::new(active.select(rays.tmax, nowhere()), active);
        self.run(rays, active, &mut goal);
        goal.blocked()
    }

    #[inline(always)]
    fn run(&mut self, rays: &RayPacket<L>, active: L::Mask, goal: &mut impl Goal<L>) {
        self.work
            .begin(L::PACKETS as u64, active.bits().count_ones());
        let (rays, world) = (&Prepared::new(rays, active), Subtree { root: 0, floor: 0 });
        if self.plain {
            self.descend::<_, true>(rays, goal, world);
        } else {
            self.descend::<_, false>(rays, goal, world);
        }
    }

    #[inline(always)]
    fn descend<G: Goal<L>, const PLAIN: bool>(
        &mut self,
        rays: &Prepared<L>,
        goal: &mut G,
        tree: Subtree,
    ) {
        let cull = &Cull::new(&rays.rays, &rays.slabs);
        match rays.slabs.near {
            Some(near) => {
                self.traverse::<G, PLAIN>(rays, goal, tree, |b| cull.stay_ordered(b, near))
            }
            None => self.traverse::<G, PLAIN>(rays, goal, tree, |b| cull.stay_mixed(b)),
        }
    }

    /// Visits leaves front to back until the goal is reached.
    ///
    /// Cones and instances are tested by calls, across which nothing stays in a register. That such calls exist at all cost
    /// every other scene 10 to 25 %, so trees without either (`PLAIN`) have a traversal of their own
    /// (`perf/notes/plain-trees.md`).
    #[inline(always)]
    fn traverse<G: Goal<L>, const PLAIN: bool>(
        &mut self,
        rays: &Prepared<L>,
        goal: &mut G,
        tree: Subtree,
        stay: impl Fn(&[[f32; 3]; 2]) -> Stay<L>,
    ) {
        let nodes = self.bvh.nodes();
        let mut top = tree.floor;
        let mut current = Child::Node(tree.root);
        let lanes = (L::PACKETS * LANES) as u64;
        loop {
            while let Child::Node(index) = current {
                self.work.node(lanes);
                // SAFETY: a `Bvh` comes from its builder or was proven (`bvh::UnverifiedBvh`): every child node has an index
                // below `nodes().len()`; node 0 exists.
                let node = unsafe { nodes.get_unchecked(index as usize) };
                let stays = [stay(&node.boxes[0]), stay(&node.boxes[1])];
                let met = stays.each_ref().map(|s| s.within(goal.limit()));
                match (met[0].any(), met[1].any()) {
                    (false, false) => current = Child::EMPTY,
                    (true, false) => current = node.child(0),
                    (false, true) => current = node.child(1),
                    (true, true) => {
                        let near = if G::ORDERED {
                            sooner::<L>(met, &stays)
                        } else {
                            0
                        };
                        let (first, tag) = node.packed(1 - near);
                        // Blended, not branched on: which child is nearer cannot be predicted.
                        let nan = L::splat(f32::NAN);
                        let waiting = [1, 0].map(|k: usize| met[k].select(stays[k].enter, nan));
                        let enter = L::Mask::splat(near == 1).select(waiting[1], waiting[0]);
                        // SAFETY: each level of a path leaves at most one entry, the stack is `depth() + 1`
                        // long, and `Bvh::depth` counts the longest path, through an instance if there are any.
                        let slot = unsafe { self.stack.get_unchecked_mut(top) };
                        *slot = Entry { enter, first, tag };
                        top += 1;
                        current = node.child(near);
                    }
                }
            }
            if let Child::Leaf { kind, first, count } = current {
                let slots = first as usize..(first + count) as usize;
                self.work.leaf(kind, lanes, slots.len());
                let done = match kind {
                    LeafKind::Instance if !PLAIN => {
                        // Copies: what a call is given the address of no longer stays in registers.
                        let (copy, mut inside) = (*rays, *goal);
                        let done = self.instances(&copy, &mut inside, slots, top);
                        *goal = inside;
                        done
                    }
                    _ => goal.leaf::<PLAIN>(self.bvh, rays, kind, slots),
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
                if entry.enter.le(goal.limit()).any() {
                    break Child::unpack(entry.first, entry.tag);
                }
            };
        }
    }

    /// A leaf by itself, for rays that came there on other ways; true ends their traversal.
    #[inline(always)]
    pub(super) fn leaf_alone<G: Goal<L>>(
        &mut self,
        rays: &Prepared<L>,
        goal: &mut G,
        kind: LeafKind,
        slots: Range<usize>,
    ) -> bool {
        match kind {
            LeafKind::Instance => self.instances(rays, goal, slots, 0),
            _ => goal.leaf::<false>(self.bvh, rays, kind, slots),
        }
    }

    /// Goes on in the trees of instances, with the rays moved into their space: see [`instance`].
    #[inline(never)]
    fn instances<G: Goal<L>>(
        &mut self,
        rays: &Prepared<L>,
        goal: &mut G,
        slots: Range<usize>,
        floor: usize,
    ) -> bool {
        for slot in slots_of(self.bvh.instances(), slots) {
            let stay = rays.slabs.stay(&slot.prim_aabb);
            let Some(mut inner) = goal.within(&stay) else {
                continue;
            };
            let active = inner.limit().gt(nowhere());
            let moved = Prepared::new(&instance::moved(&rays.rays, slot), active);
            let tree = Subtree {
                root: slot.root,
                floor,
            };
            self.descend::<_, false>(&moved, &mut inner, tree);
            if goal.leave(inner, &stay, slot.id_offset) {
                return true;
            }
        }
        false
    }
}

/// A tree, and the place of the stack from which its traversal may use it.
#[derive(Clone, Copy)]
struct Subtree {
    root: u32,
    floor: usize,
}

/// The child that more of the rays that meet both enter first: for rays that have parted, a better guess than one
/// order per octant.
#[inline(always)]
fn sooner<L: Lanes>(met: [L::Mask; 2], stays: &[Stay<L>; 2]) -> usize {
    let both = met[0] & met[1];
    let first = (both & stays[0].enter.lt(stays[1].enter))
        .bits()
        .count_ones();
    let second = (both & stays[1].enter.lt(stays[0].enter))
        .bits()
        .count_ones();
    usize::from(second > first)
}

/// The primitives of a leaf.
#[inline(always)]
pub(super) fn slots_of<T>(all: &[T], slots: Range<usize>) -> &[T] {
    debug_assert!(slots.start <= slots.end && slots.end <= all.len());
    // SAFETY: the range comes from a leaf of a `Bvh`, whose builder pushed exactly these primitives before it wrote
    // the leaf, or which was proven to have them (`bvh::UnverifiedBvh`); an empty leaf is 0..0.
    unsafe { all.get_unchecked(slots) }
}
