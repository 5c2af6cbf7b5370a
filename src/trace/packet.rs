//! Eight rays together down the binary tree (Wald et al., "Interactive Rendering with Coherent Ray Tracing", 2001).
//!
//! A node is visited once for all eight rays; a child is entered if any ray meets its box before the ray's closest
//! hit so far. Lanes without a ray have a closest hit of −∞ and so never pass a comparison: there is no mask to carry.

use super::aabb::{Slabs, Stay};
use super::triangle::{MIXED, Shear};
use super::{sphere, triangle};
use crate::bvh::{Bvh, Child};
use crate::lanes::{F32x8, Mask8, U32x8};
use crate::packet::{HitPacket, NO_PRIM, RayPacket};
use crate::scene::PrimKind;
use std::ops::Range;

/// The closest hits so far. Inactive lanes hold t = −∞.
pub(super) type Best = HitPacket;

/// Work done, for comparing kernels without a clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Packets traced.
    pub packets: u64,
}

/// A child waiting to be visited.
#[derive(Clone, Copy)]
struct Entry {
    /// Entry distance; NaN in lanes that miss the box.
    enter: F32x8,
    first: u32,
    tag: u16,
}

/// Traces packets against one tree. Owns the traversal stack, so that tracing allocates nothing.
pub struct Tracer<'a> {
    bvh: &'a Bvh,
    stack: Vec<Entry>,
    /// Counters since the tracer was made.
    pub work: Work,
}

impl<'a> Tracer<'a> {
    /// A tracer for a tree.
    pub fn new(bvh: &'a Bvh) -> Tracer<'a> {
        let empty = Entry {
            enter: F32x8::ZERO,
            first: 0,
            tag: 0,
        };
        Tracer {
            bvh,
            // Every level of a path leaves at most one child waiting.
            stack: vec![empty; bvh.depth() + 1],
            work: Work::default(),
        }
    }

    /// The closest hit of each active lane; others come back as a miss.
    pub fn closest(&mut self, rays: &RayPacket, active: Mask8) -> HitPacket {
        let mut goal = Closest {
            best: HitPacket::miss(),
        };
        goal.best.t = active.select(rays.tmax, NOWHERE);
        self.run(rays, active, &mut goal);
        goal.best.t = active.select(goal.best.t, rays.tmax);
        // A hit exactly at a lane's limit ties with it, but only what is below counts.
        let tie = goal.best.t.eq(rays.tmax) & rays.tmax.lt(F32x8::splat(f32::INFINITY));
        goal.best.u = tie.select(F32x8::ZERO, goal.best.u);
        goal.best.v = tie.select(F32x8::ZERO, goal.best.v);
        goal.best.prim_id = tie.select_u32(U32x8::splat(NO_PRIM), goal.best.prim_id);
        goal.best
    }

    /// Which active lanes meet anything before `tmax`.
    pub fn occluded(&mut self, rays: &RayPacket, active: Mask8) -> Mask8 {
        let mut goal = AnyHit {
            limit: active.select(rays.tmax, NOWHERE),
            blocked: Mask8::none(),
            all: active.bits(),
        };
        self.run(rays, active, &mut goal);
        goal.blocked
    }

    #[inline(always)]
    fn run(&mut self, rays: &RayPacket, active: Mask8, goal: &mut impl Goal) {
        self.work.packets += 1;
        let rays = &Prepared::new(rays, active);
        let slabs = &rays.slabs;
        match slabs.near {
            Some(near) => self.traverse(rays, goal, |corners| slabs.stay_ordered(corners, near)),
            None => self.traverse(rays, goal, |corners| slabs.stay_mixed(corners)),
        }
    }

    /// Visits leaves front to back until the goal is reached.
    #[inline(always)]
    fn traverse(
        &mut self,
        rays: &Prepared,
        goal: &mut impl Goal,
        stay: impl Fn(&[[f32; 3]; 2]) -> Stay,
    ) {
        let nodes = self.bvh.nodes();
        let mut top = 0;
        let mut current = Child::Node(0);
        loop {
            while let Child::Node(index) = current {
                let node = &nodes[index as usize];
                let stays = [stay(&node.boxes[0]), stay(&node.boxes[1])];
                let met = stays.each_ref().map(|s| s.within(goal.limit()));
                match (met[0].any(), met[1].any()) {
                    (false, false) => current = NOTHING,
                    (true, false) => current = node.child(0),
                    (false, true) => current = node.child(1),
                    (true, true) => {
                        let near = usize::from(node.order >> rays.octant & 1);
                        let far = 1 - near;
                        let (first, tag) = node.packed(far);
                        let enter = met[far].select(stays[far].enter, F32x8::splat(f32::NAN));
                        self.stack[top] = Entry { enter, first, tag };
                        top += 1;
                        current = node.child(near);
                    }
                }
            }
            if let Child::Leaf { kind, first, count } = current
                && goal.leaf(
                    self.bvh,
                    rays,
                    kind,
                    first as usize..(first + count) as usize,
                )
            {
                return;
            }
            // The next waiting child that some ray still reaches.
            current = loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let entry = &self.stack[top];
                if entry.enter.le(goal.limit()).any() {
                    break Child::unpack(entry.first, entry.tag);
                }
            };
        }
    }
}

/// The limit of a lane without a ray, or with nothing left to find.
const NOWHERE: F32x8 = F32x8::new([f32::NEG_INFINITY; 8]);

/// Where to go from a node whose children are both missed.
const NOTHING: Child = Child::Leaf {
    kind: PrimKind::Triangle,
    first: 0,
    count: 0,
};

/// What a traversal looks for.
trait Goal {
    /// How far each ray still has to look.
    fn limit(&self) -> F32x8;
    /// Tests the primitives of a leaf; true ends the traversal.
    fn leaf(&mut self, bvh: &Bvh, rays: &Prepared, kind: PrimKind, slots: Range<usize>) -> bool;
}

struct Closest {
    best: Best,
}

struct AnyHit {
    limit: F32x8,
    blocked: Mask8,
    all: u8,
}

impl Goal for Closest {
    #[inline(always)]
    fn limit(&self) -> F32x8 {
        self.best.t
    }

    #[inline(always)]
    fn leaf(&mut self, bvh: &Bvh, rays: &Prepared, kind: PrimKind, slots: Range<usize>) -> bool {
        let best = &mut self.best;
        let (org, dir, slabs) = (rays.rays.org, rays.rays.dir, &rays.slabs);
        match kind {
            PrimKind::Triangle => match rays.shear.axis {
                0 => triangles_closest::<0>(bvh, rays, slots, best),
                1 => triangles_closest::<1>(bvh, rays, slots, best),
                2 => triangles_closest::<2>(bvh, rays, slots, best),
                _ => triangles_closest::<MIXED>(bvh, rays, slots, best),
            },
            PrimKind::Sphere => {
                for slot in &bvh.spheres()[slots] {
                    sphere::closest(org, dir, slabs, slot, best);
                }
            }
            PrimKind::Ellipsoid => {
                for slot in &bvh.ellipsoids()[slots] {
                    sphere::closest_ellipsoid(org, dir, slabs, slot, best);
                }
            }
        }
        false
    }
}

impl Goal for AnyHit {
    #[inline(always)]
    fn limit(&self) -> F32x8 {
        self.limit
    }

    #[inline(always)]
    fn leaf(&mut self, bvh: &Bvh, rays: &Prepared, kind: PrimKind, slots: Range<usize>) -> bool {
        let tmax = self.limit;
        let (org, dir, slabs) = (rays.rays.org, rays.rays.dir, &rays.slabs);
        let hits = match kind {
            PrimKind::Triangle => match rays.shear.axis {
                0 => triangles_occluded::<0>(bvh, rays, slots, tmax),
                1 => triangles_occluded::<1>(bvh, rays, slots, tmax),
                2 => triangles_occluded::<2>(bvh, rays, slots, tmax),
                _ => triangles_occluded::<MIXED>(bvh, rays, slots, tmax),
            },
            PrimKind::Sphere => any_of(&bvh.spheres()[slots], |slot| {
                sphere::occluded(org, dir, slabs, slot, tmax)
            }),
            PrimKind::Ellipsoid => any_of(&bvh.ellipsoids()[slots], |slot| {
                sphere::occluded_ellipsoid(org, dir, slabs, slot, tmax)
            }),
        };
        self.blocked = self.blocked | hits;
        // A blocked lane is done: like a lane without a ray.
        self.limit = hits.select(NOWHERE, self.limit);
        self.blocked.bits() == self.all
    }
}

/// Eight rays with what the tests derive from them once.
struct Prepared {
    rays: RayPacket,
    slabs: Slabs,
    shear: Shear,
    /// Direction signs of the first active lane.
    octant: u8,
}

impl Prepared {
    #[inline(always)]
    fn new(rays: &RayPacket, active: Mask8) -> Prepared {
        let lane = active.bits().trailing_zeros() & 7;
        let negative = |d: F32x8| (d.lt(F32x8::ZERO).bits() >> lane) & 1;
        Prepared {
            rays: *rays,
            slabs: Slabs::new(rays.org, rays.dir, active),
            shear: Shear::new(rays.org, rays.dir, active),
            octant: negative(rays.dir.x) | negative(rays.dir.y) << 1 | negative(rays.dir.z) << 2,
        }
    }
}

#[inline(always)]
fn triangles_closest<const AXIS: usize>(
    bvh: &Bvh,
    rays: &Prepared,
    slots: Range<usize>,
    best: &mut Best,
) {
    for slot in &bvh.triangles()[slots] {
        triangle::closest::<AXIS>(&rays.shear, &rays.slabs, slot, best);
    }
}

#[inline(always)]
fn triangles_occluded<const AXIS: usize>(
    bvh: &Bvh,
    rays: &Prepared,
    slots: Range<usize>,
    tmax: F32x8,
) -> Mask8 {
    any_of(&bvh.triangles()[slots], |slot| {
        triangle::occluded::<AXIS>(&rays.shear, &rays.slabs, slot, tmax)
    })
}

#[inline(always)]
fn any_of<T>(slots: &[T], test: impl Fn(&T) -> Mask8) -> Mask8 {
    let mut hits = Mask8::none();
    for slot in slots {
        hits = hits | test(slot);
    }
    hits
}
