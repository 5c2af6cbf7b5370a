//! Eight rays together down the binary tree (Wald et al., "Interactive Rendering with Coherent Ray Tracing", 2001).
//!
//! A node is visited once for all eight rays; a child is entered if any ray meets its box before the ray's closest
//! hit so far. Lanes without a ray have a closest hit of −∞ and so never pass a comparison: there is no mask to carry.

use super::aabb::Slabs;
use super::triangle::{MIXED, Shear};
use super::{sphere, triangle};
use crate::bvh::{Bvh, Child, Node};
use crate::lanes::{F32x8, Mask8};
use crate::packet::{HitPacket, RayPacket};
use crate::scene::PrimKind;

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
        self.work.packets += 1;
        let mut best = HitPacket::miss();
        best.t = active.select(rays.tmax, F32x8::splat(f32::NEG_INFINITY));
        let prepared = Prepared::new(rays, active);
        self.traverse(&prepared, &mut best.t.clone(), |bvh, kind, slots, limit| {
            leaf_closest(bvh, &prepared, kind, slots, &mut best);
            *limit = best.t;
            true
        });
        best.t = active.select(best.t, rays.tmax);
        best
    }

    /// Which active lanes meet anything before `tmax`.
    pub fn occluded(&mut self, rays: &RayPacket, active: Mask8) -> Mask8 {
        self.work.packets += 1;
        let nowhere = F32x8::splat(f32::NEG_INFINITY);
        let mut limit = active.select(rays.tmax, nowhere);
        let mut blocked = Mask8::none();
        let prepared = Prepared::new(rays, active);
        let all = active.bits();
        self.traverse(&prepared, &mut limit, |bvh, kind, slots, limit| {
            let hits = leaf_occluded(bvh, &prepared, kind, slots, *limit);
            blocked = blocked | hits;
            // A blocked lane is done: like a lane without a ray.
            *limit = hits.select(nowhere, *limit);
            blocked.bits() != all
        });
        blocked
    }

    /// Visits leaves front to back. `leaf` tests a range of slots and lowers the limits; false stops.
    #[inline(always)]
    fn traverse(
        &mut self,
        rays: &Prepared,
        limit: &mut F32x8,
        mut leaf: impl FnMut(&Bvh, PrimKind, std::ops::Range<usize>, &mut F32x8) -> bool,
    ) {
        let nodes = self.bvh.nodes();
        let mut top = 0;
        let mut current = Child::Node(0);
        loop {
            match current {
                Child::Node(index) => {
                    let node = &nodes[index as usize];
                    if let Some(next) = descend(node, rays, *limit, &mut self.stack, &mut top) {
                        current = next;
                        continue;
                    }
                }
                Child::Leaf { kind, first, count } => {
                    let slots = first as usize..(first + count) as usize;
                    if !leaf(self.bvh, kind, slots, limit) {
                        return;
                    }
                }
            }
            // The next waiting child that some ray still reaches.
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let entry = &self.stack[top];
                if entry.enter.le(*limit).any() {
                    current = Child::unpack(entry.first, entry.tag);
                    break;
                }
            }
        }
    }
}

/// Tests both children of a node: the nearer one that is met comes back, the other waits on the stack.
#[inline(always)]
fn descend(
    node: &Node,
    rays: &Prepared,
    limit: F32x8,
    stack: &mut [Entry],
    top: &mut usize,
) -> Option<Child> {
    let stays = [
        rays.slabs.stay(&node.boxes[0]),
        rays.slabs.stay(&node.boxes[1]),
    ];
    let met = [stays[0].within(limit), stays[1].within(limit)];
    match (met[0].any(), met[1].any()) {
        (false, false) => None,
        (true, false) => Some(node.child(0)),
        (false, true) => Some(node.child(1)),
        (true, true) => {
            let swap = node.order >> rays.octant & 1 == 1;
            let (near, far) = if swap { (1, 0) } else { (0, 1) };
            let (first, tag) = node.packed(far);
            let (far_met, far_enter) = if swap {
                (met[0], stays[0].enter)
            } else {
                (met[1], stays[1].enter)
            };
            stack[*top] = Entry {
                enter: far_met.select(far_enter, F32x8::splat(f32::NAN)),
                first,
                tag,
            };
            *top += 1;
            Some(node.child(near))
        }
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
            slabs: Slabs::new(rays.org, rays.dir),
            shear: Shear::new(rays.org, rays.dir, active),
            octant: negative(rays.dir.x) | negative(rays.dir.y) << 1 | negative(rays.dir.z) << 2,
        }
    }
}

#[inline(always)]
fn leaf_closest(
    bvh: &Bvh,
    rays: &Prepared,
    kind: PrimKind,
    slots: std::ops::Range<usize>,
    best: &mut Best,
) {
    let (org, dir) = (rays.rays.org, rays.rays.dir);
    match kind {
        PrimKind::Triangle => match rays.shear.axis {
            0 => triangles_closest::<0>(bvh, rays, slots, best),
            1 => triangles_closest::<1>(bvh, rays, slots, best),
            2 => triangles_closest::<2>(bvh, rays, slots, best),
            _ => triangles_closest::<MIXED>(bvh, rays, slots, best),
        },
        PrimKind::Sphere => {
            for slot in &bvh.spheres()[slots] {
                sphere::closest(org, dir, &rays.slabs, slot, best);
            }
        }
        PrimKind::Ellipsoid => {
            for slot in &bvh.ellipsoids()[slots] {
                sphere::closest_ellipsoid(org, dir, &rays.slabs, slot, best);
            }
        }
    }
}

#[inline(always)]
fn triangles_closest<const AXIS: usize>(
    bvh: &Bvh,
    rays: &Prepared,
    slots: std::ops::Range<usize>,
    best: &mut Best,
) {
    for slot in &bvh.triangles()[slots] {
        triangle::closest::<AXIS>(&rays.shear, &rays.slabs, slot, best);
    }
}

#[inline(always)]
fn leaf_occluded(
    bvh: &Bvh,
    rays: &Prepared,
    kind: PrimKind,
    slots: std::ops::Range<usize>,
    tmax: F32x8,
) -> Mask8 {
    let (org, dir) = (rays.rays.org, rays.rays.dir);
    match kind {
        PrimKind::Triangle => match rays.shear.axis {
            0 => triangles_occluded::<0>(bvh, rays, slots, tmax),
            1 => triangles_occluded::<1>(bvh, rays, slots, tmax),
            2 => triangles_occluded::<2>(bvh, rays, slots, tmax),
            _ => triangles_occluded::<MIXED>(bvh, rays, slots, tmax),
        },
        PrimKind::Sphere => any_of(&bvh.spheres()[slots], |slot| {
            sphere::occluded(org, dir, &rays.slabs, slot, tmax)
        }),
        PrimKind::Ellipsoid => any_of(&bvh.ellipsoids()[slots], |slot| {
            sphere::occluded_ellipsoid(org, dir, &rays.slabs, slot, tmax)
        }),
    }
}

#[inline(always)]
fn triangles_occluded<const AXIS: usize>(
    bvh: &Bvh,
    rays: &Prepared,
    slots: std::ops::Range<usize>,
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
