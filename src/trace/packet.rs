//! Packets of rays together down the binary tree (Wald et al., "Interactive Rendering with Coherent Ray Tracing", 2001).
//!
//! A node is visited once for all rays of a packet; a child is entered if any ray meets its box before the ray's closest
//! hit so far. Lanes without a ray have a closest hit of −∞ and so never pass a comparison: there is no mask to carry.

use super::aabb::{Slabs, Stay};
use super::triangle::{MIXED, Shear};
use super::{cone, instance, sphere, triangle};
use crate::bvh::{Bvh, Child, LeafKind};
use crate::lanes::{F32x8, LaneIds, LaneMask, Lanes};
use crate::packet::{HitPacket, NO_PRIM, RayPacket};
use std::ops::Range;

/// The closest hits so far. Inactive lanes hold t = −∞.
#[derive(Clone, Copy)]
pub(super) struct Best<L: Lanes> {
    pub(super) t: L,
    /// Barycentric weights of a triangle's second and third corner, times `det`: divided once, at the end.
    pub(super) v: L,
    pub(super) w: L,
    pub(super) det: L,
    pub(super) prim_id: L::Ids,
}

/// Work done, for comparing kernels without a clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Packets traced.
    pub packets: u64,
}

/// A child waiting to be visited.
#[derive(Clone, Copy)]
struct Entry<L> {
    /// Entry distance; NaN in lanes that miss the box.
    enter: L,
    first: u32,
    tag: u16,
}

/// Traces packets against one tree. Owns the traversal stack, so that tracing allocates nothing.
pub struct Tracer<'a, L = F32x8> {
    bvh: &'a Bvh,
    /// Whether the tree holds neither cones nor instances: see [`Tracer::traverse`].
    plain: bool,
    stack: Vec<Entry<L>>,
    /// Counters since the tracer was made.
    pub work: Work,
}

impl<'a, L: Lanes> Tracer<'a, L> {
    /// A tracer for a tree.
    pub fn new(bvh: &'a Bvh) -> Tracer<'a, L> {
        let empty = Entry {
            enter: L::ZERO,
            first: 0,
            tag: 0,
        };
        Tracer {
            bvh,
            plain: bvh.cones().is_empty() && bvh.instances().is_empty(),
            // Every level of a path leaves at most one child waiting.
            stack: vec![empty; bvh.depth() + 1],
            work: Work::default(),
        }
    }

    /// The tree it traces.
    pub fn bvh(&self) -> &'a Bvh {
        self.bvh
    }

    /// The closest hit below `tmax` of each active lane; others come back as a miss.
    #[inline(always)]
    pub fn closest(&mut self, rays: &RayPacket<L>, active: L::Mask) -> HitPacket<L> {
        let mut goal = Closest {
            best: Best {
                t: active.select(rays.tmax, nowhere()),
                v: L::ZERO,
                w: L::ZERO,
                det: L::ONE,
                // Nothing is smaller, so a hit at the limit itself does not win the tie.
                prim_id: L::Ids::splat(0),
            },
        };
        self.run(rays, active, &mut goal);
        let best = goal.best;
        let found = active & best.t.lt(rays.tmax);
        HitPacket {
            t: found.select(best.t, rays.tmax),
            u: best.v / best.det,
            v: best.w / best.det,
            prim_id: found.select_ids(best.prim_id, L::Ids::splat(NO_PRIM)),
        }
    }

    /// Which active lanes meet anything before `tmax`.
    #[inline(always)]
    pub fn occluded(&mut self, rays: &RayPacket<L>, active: L::Mask) -> L::Mask {
        let mut goal = AnyHit {
            limit: active.select(rays.tmax, nowhere()),
            blocked: L::Mask::none(),
            all: active.bits(),
        };
        self.run(rays, active, &mut goal);
        goal.blocked
    }

    #[inline(always)]
    fn run(&mut self, rays: &RayPacket<L>, active: L::Mask, goal: &mut impl Goal<L>) {
        self.work.packets += L::PACKETS as u64;
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
        let slabs = &rays.slabs;
        match slabs.near {
            Some(near) => {
                self.traverse::<G, PLAIN>(rays, goal, tree, |b| slabs.stay_ordered(b, near))
            }
            None => self.traverse::<G, PLAIN>(rays, goal, tree, |b| slabs.stay_mixed(b)),
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
        loop {
            while let Child::Node(index) = current {
                // SAFETY: a `Bvh` comes from its builder or was proven (`bvh::Claim`): every child node has an index
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
            let stay = rays.slabs.stay(&slot.own_box);
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

/// The limit of a lane without a ray, or with nothing left to find.
#[inline(always)]
fn nowhere<L: Lanes>() -> L {
    L::splat(f32::NEG_INFINITY)
}

/// What a traversal looks for.
trait Goal<L: Lanes>: Copy {
    /// Whether it helps to meet near leaves first: it does not where any hit will do.
    const ORDERED: bool;
    /// How far each ray still has to look.
    fn limit(&self) -> L;
    /// The same goal within an instance, whose box the rays cross as `stay` says; none if nothing in there can matter.
    fn within(&self, stay: &Stay<L>) -> Option<Self>
    where
        Self: Sized;
    /// Takes over what was found within an instance; true ends the traversal.
    fn leave(&mut self, inner: Self, stay: &Stay<L>, id_offset: u32) -> bool;
    /// Tests the primitives of a leaf; true ends the traversal.
    fn leaf<const PLAIN: bool>(
        &mut self,
        bvh: &Bvh,
        rays: &Prepared<L>,
        kind: LeafKind,
        slots: Range<usize>,
    ) -> bool;
}

#[derive(Clone, Copy)]
struct Closest<L: Lanes> {
    best: Best<L>,
}

#[derive(Clone, Copy)]
struct AnyHit<L: Lanes> {
    limit: L,
    blocked: L::Mask,
    all: u32,
}

impl<L: Lanes> Goal<L> for Closest<L> {
    const ORDERED: bool = true;
    #[inline(always)]
    fn limit(&self) -> L {
        self.best.t
    }

    #[inline(always)]
    fn within(&self, stay: &Stay<L>) -> Option<Closest<L>> {
        let limit = instance::closest_limit(self.best.t, stay);
        limit.gt(nowhere()).any().then(|| Closest {
            best: Best {
                t: limit,
                // The smallest number wins a tie, so this one loses it: a hit at the limit may win out there.
                prim_id: L::Ids::splat(NO_PRIM),
                ..self.best
            },
        })
    }

    #[inline(always)]
    fn leave(&mut self, inner: Closest<L>, stay: &Stay<L>, id_offset: u32) -> bool {
        let found = inner.best;
        let id = found.prim_id.wrapping_add(L::Ids::splat(id_offset));
        let (met, t) = instance::outside(found.t, stay);
        let hit = met & !found.prim_id.eq(L::Ids::splat(NO_PRIM));
        let best = &mut self.best;
        let take = hit & (t.lt(best.t) | (t.eq(best.t) & id.lt(best.prim_id)));
        best.t = take.select(t, best.t);
        best.v = take.select(found.v, best.v);
        best.w = take.select(found.w, best.w);
        best.det = take.select(found.det, best.det);
        best.prim_id = take.select_ids(id, best.prim_id);
        false
    }

    #[inline(always)]
    fn leaf<const PLAIN: bool>(
        &mut self,
        bvh: &Bvh,
        rays: &Prepared<L>,
        kind: LeafKind,
        slots: Range<usize>,
    ) -> bool {
        let best = &mut self.best;
        let (org, dir, slabs) = (rays.rays.org, rays.rays.dir, &rays.slabs);
        match kind {
            LeafKind::Triangle => match rays.shear.axis {
                0 => triangles_closest::<L, 0>(bvh, rays, slots, best),
                1 => triangles_closest::<L, 1>(bvh, rays, slots, best),
                2 => triangles_closest::<L, 2>(bvh, rays, slots, best),
                _ => triangles_closest::<L, MIXED>(bvh, rays, slots, best),
            },
            LeafKind::Sphere => {
                for slot in slots_of(bvh.spheres(), slots) {
                    sphere::closest(org, dir, slabs, slot, best);
                }
            }
            LeafKind::Ellipsoid => {
                for slot in slots_of(bvh.ellipsoids(), slots) {
                    sphere::closest_ellipsoid(org, dir, slabs, slot, best);
                }
            }
            LeafKind::Cone if !PLAIN => *best = cones_closest(bvh, rays, slots, *best),
            // The traversal itself enters instances.
            LeafKind::Cone | LeafKind::Instance => {}
        }
        false
    }
}

impl<L: Lanes> Goal<L> for AnyHit<L> {
    const ORDERED: bool = false;
    #[inline(always)]
    fn limit(&self) -> L {
        self.limit
    }

    #[inline(always)]
    fn within(&self, stay: &Stay<L>) -> Option<AnyHit<L>> {
        let limit = instance::any_hit_limit(self.limit, stay);
        let live = limit.gt(nowhere()).bits();
        (live != 0).then(|| AnyHit {
            limit,
            blocked: L::Mask::none(),
            all: live,
        })
    }

    #[inline(always)]
    fn leave(&mut self, inner: AnyHit<L>, _: &Stay<L>, _: u32) -> bool {
        self.block(inner.blocked)
    }

    #[inline(always)]
    fn leaf<const PLAIN: bool>(
        &mut self,
        bvh: &Bvh,
        rays: &Prepared<L>,
        kind: LeafKind,
        slots: Range<usize>,
    ) -> bool {
        let tmax = self.limit;
        let (org, dir, slabs) = (rays.rays.org, rays.rays.dir, &rays.slabs);
        let hits = match kind {
            LeafKind::Triangle => match rays.shear.axis {
                0 => triangles_occluded::<L, 0>(bvh, rays, slots, tmax),
                1 => triangles_occluded::<L, 1>(bvh, rays, slots, tmax),
                2 => triangles_occluded::<L, 2>(bvh, rays, slots, tmax),
                _ => triangles_occluded::<L, MIXED>(bvh, rays, slots, tmax),
            },
            // Loops and not closures, which are not inlined here.
            LeafKind::Sphere => {
                let mut hits = L::Mask::none();
                for slot in slots_of(bvh.spheres(), slots) {
                    hits = hits | sphere::occluded(org, dir, slabs, slot, tmax);
                }
                hits
            }
            LeafKind::Ellipsoid => {
                let mut hits = L::Mask::none();
                for slot in slots_of(bvh.ellipsoids(), slots) {
                    hits = hits | sphere::occluded_ellipsoid(org, dir, slabs, slot, tmax);
                }
                hits
            }
            LeafKind::Cone if !PLAIN => cones_occluded(bvh, rays, slots, tmax),
            LeafKind::Cone | LeafKind::Instance => L::Mask::none(),
        };
        self.block(hits)
    }
}

impl<L: Lanes> AnyHit<L> {
    /// A blocked lane is done: like a lane without a ray. True when all are.
    #[inline(always)]
    fn block(&mut self, hits: L::Mask) -> bool {
        self.blocked = self.blocked | hits;
        self.limit = hits.select(nowhere(), self.limit);
        self.blocked.bits() == self.all
    }
}

/// Eight rays with what the tests derive from them once.
#[derive(Clone, Copy)]
struct Prepared<L: Lanes> {
    rays: RayPacket<L>,
    slabs: Slabs<L>,
    shear: Shear<L>,
}

impl<L: Lanes> Prepared<L> {
    #[inline(always)]
    fn new(rays: &RayPacket<L>, active: L::Mask) -> Prepared<L> {
        Prepared {
            rays: *rays,
            slabs: Slabs::new(rays.org, rays.dir, active),
            shear: Shear::new(rays.org, rays.dir, active),
        }
    }
}

#[inline(always)]
fn triangles_closest<L: Lanes, const AXIS: usize>(
    bvh: &Bvh,
    rays: &Prepared<L>,
    slots: Range<usize>,
    best: &mut Best<L>,
) {
    for slot in slots_of(bvh.triangles(), slots) {
        triangle::closest::<L, AXIS>(&rays.shear, &rays.slabs, slot, best);
    }
}

#[inline(always)]
fn triangles_occluded<L: Lanes, const AXIS: usize>(
    bvh: &Bvh,
    rays: &Prepared<L>,
    slots: Range<usize>,
    tmax: L,
) -> L::Mask {
    let mut hits = L::Mask::none();
    for slot in slots_of(bvh.triangles(), slots) {
        hits = hits | triangle::occluded::<L, AXIS>(&rays.shear, &rays.slabs, slot, tmax);
    }
    hits
}

/// Cones stand apart, and take and give the hits by value: what a call is given the address of stays in memory.
#[inline(never)]
fn cones_closest<L: Lanes>(
    bvh: &Bvh,
    rays: &Prepared<L>,
    slots: Range<usize>,
    mut best: Best<L>,
) -> Best<L> {
    for slot in slots_of(bvh.cones(), slots) {
        cone::closest(rays.rays.org, rays.rays.dir, &rays.slabs, slot, &mut best);
    }
    best
}

#[inline(never)]
fn cones_occluded<L: Lanes>(
    bvh: &Bvh,
    rays: &Prepared<L>,
    slots: Range<usize>,
    tmax: L,
) -> L::Mask {
    let mut hits = L::Mask::none();
    for slot in slots_of(bvh.cones(), slots) {
        hits = hits | cone::occluded(rays.rays.org, rays.rays.dir, &rays.slabs, slot, tmax);
    }
    hits
}

/// The primitives of a leaf.
#[inline(always)]
fn slots_of<T>(all: &[T], slots: Range<usize>) -> &[T] {
    debug_assert!(slots.start <= slots.end && slots.end <= all.len());
    // SAFETY: the range comes from a leaf of a `Bvh`, whose builder pushed exactly these primitives before it wrote
    // the leaf, or which was proven to have them (`bvh::Claim`); an empty leaf is 0..0.
    unsafe { all.get_unchecked(slots) }
}
