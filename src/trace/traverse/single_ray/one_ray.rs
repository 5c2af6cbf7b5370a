//! One ray, from the root to its answer, while nothing else is in flight.
//!
//! There are no turns to take and no state to store between them. The nearest child of a node stays
//! in hand, so that its row is not looked up on the stack, and a node without hit children costs a
//! branch that is mostly foreseen. Entries that begin behind the closest hit are skipped when they
//! are popped, which is cheaper for one ray than [`WideStack::prune`]
//! (`perf/notes/single-rays.md`, one ray a call).

use super::ray_state::{OneHit, RayState, SingleHit, SingleRaySetup, row_offset};
use super::ray_stream::{RayOctets, ready};
use super::single_query::{SingleAny, SingleClosest, SingleFiltered, SingleQuery};
use super::{ROOT, children_met, push_children, stack_room, test_block, test_other};
use crate::bvh::{Bvh, ChildRef, OtherLeaf, WideBvh};
use crate::intersect::aabb::reciprocal_of_one;
use crate::intersect::shear::{FRAMES, dominant_axis, is_usual};
use crate::packet::NO_PRIM;
use crate::simd::{F32x8, LANES, LaneMask, NATIVE};
use crate::traverse::HitFilter;
use crate::traverse::counters::PacketCount;
use crate::traverse::packet::PacketKernel;
use crate::traverse::wide_stack::{ThreadStack, WideStack};
use phalanx_scene::PAD;

/// Traces rays one after another.
pub(crate) struct OneRay<'a> {
    bvh: &'a Bvh,
    wide: &'a WideBvh,
    stack: ThreadStack,
}

impl<'a> OneRay<'a> {
    #[inline(always)]
    pub(crate) fn new(bvh: &'a Bvh) -> OneRay<'a> {
        let wide = bvh.wide();
        OneRay {
            bvh,
            wide,
            stack: ThreadStack::with_room(stack_room(wide)),
        }
    }

    /// The closest hit below `tmax` of one ray: origin and direction.
    #[inline(never)]
    pub(crate) fn closest(&mut self, ray: [&[f32; 3]; 2], tmax: f32) -> OneHit {
        OneHit::below(tmax, &self.trace(SingleClosest, setup(ray), tmax))
    }

    /// Returns true if one ray hits anything before `tmax`.
    #[inline(never)]
    pub(crate) fn occluded(&mut self, ray: [&[f32; 3]; 2], tmax: f32) -> bool {
        self.trace(SingleAny, setup(ray), tmax).prim_id != NO_PRIM
    }

    /// As [`OneRay::closest`], among the hits that a filter accepts; if any will do, the hit's
    /// distance is unknown.
    #[inline(never)]
    pub(crate) fn filtered(
        &mut self,
        ray: [&[f32; 3]; 2],
        tmax: f32,
        filter: &HitFilter,
    ) -> OneHit {
        OneHit::below(tmax, &self.trace(SingleFiltered(filter), setup(ray), tmax))
    }

    /// Passes on the number of each ray of a packet that is traced, and its closest hit. Rays of a
    /// packet are set up together, which takes a third of the time of as many single ones.
    #[inline(never)]
    pub(crate) fn packet_closest(
        &mut self,
        (rays, packet): (&impl RayOctets, usize),
        done: &mut dyn FnMut(usize, OneHit),
    ) {
        self.each_of(SingleClosest, (rays, packet), |number, tmax, best| {
            done(number, OneHit::below(tmax, best));
        });
    }

    /// Sets the flags of the rays of a packet that hit anything.
    #[inline(never)]
    pub(crate) fn packet_occluded(
        &mut self,
        (rays, packet): (&impl RayOctets, usize),
        blocked: &mut [bool],
    ) {
        self.each_of(SingleAny, (rays, packet), |number, _, best| {
            blocked[number] = best.prim_id != NO_PRIM;
        });
    }

    #[inline(always)]
    fn each_of<S: SingleQuery>(
        &mut self,
        query: S,
        (rays, packet): (&impl RayOctets, usize),
        mut done: impl FnMut(usize, f32, &SingleHit),
    ) {
        let (octet, active) = rays.packet(packet);
        let ready = ready(&octet, active);
        for lane in active.lanes() {
            let number = packet * LANES + lane;
            let tmax = rays.limit(number);
            done(number, tmax, &self.trace(query, ready[lane], tmax));
        }
    }

    #[inline(always)]
    fn trace<S: SingleQuery>(&mut self, query: S, ray: SingleRaySetup, tmax: f32) -> SingleHit {
        let mut state = RayState {
            ray,
            best: SingleHit::none_before(tmax),
            current: ROOT,
            ..RayState::IDLE
        };
        descend((self.bvh, self.wide), query, &mut state, &mut self.stack.0);
        state.best
    }
}

#[inline(always)]
fn descend<S: SingleQuery>(
    (bvh, wide): (&Bvh, &WideBvh),
    query: S,
    state: &mut RayState,
    stack: &mut WideStack,
) {
    // For leaves without blocks, which most scenes lack.
    let mut packets = None;
    loop {
        match ChildRef::of_code(state.current) {
            ChildRef::Node(index) => {
                // SAFETY: a code of the tree refers to an existing row, and node 0 exists.
                let node = unsafe { wide.nodes().get_unchecked(index as usize) };
                let (met, enter) = children_met(state, node);
                if met != 0 {
                    // The child that would be pushed last stays in hand.
                    let nearest = if S::FRONT_TO_BACK && state.goes_up(node.axis) {
                        met.trailing_zeros()
                    } else {
                        u32::BITS - 1 - met.leading_zeros()
                    };
                    let rest = met & !(1 << nearest);
                    if rest != 0 {
                        // SAFETY: each level above this node's left at most `NATIVE - 1` entries.
                        unsafe { push_children::<S>(state, node, (rest, enter), stack) };
                    }
                    state.current = node.children[nearest as usize % NATIVE];
                    continue;
                }
            }
            ChildRef::Other(index) => {
                other(
                    query,
                    state,
                    (&mut packets, bvh),
                    wide.others()[index as usize],
                );
            }
            block => {
                test_block(query, state, wide, block, &mut PacketCount::default());
            }
        }
        if !pop::<S>(state, stack) {
            break;
        }
    }
    if let Some(packets) = packets {
        packets.give_back();
    }
}

/// Takes the next entry that begins within reach; returns false if there is none.
#[inline(always)]
fn pop<S: SingleQuery>(state: &mut RayState, stack: &WideStack) -> bool {
    while state.top > state.bottom {
        state.top -= 1;
        // SAFETY: `top` entries were written.
        if !S::FRONT_TO_BACK || unsafe { stack.tnear(state.top) } <= state.best.reach() {
            // SAFETY: as above.
            state.current = unsafe { stack.code(state.top) };
            return true;
        }
    }
    false
}

/// Not inlined, or a shared library would ask where the thread's kernel lies before each ray.
#[inline(never)]
fn other<'a>(
    query: impl SingleQuery,
    state: &mut RayState,
    (packets, bvh): (&mut Option<PacketKernel<'a, F32x8, PacketCount>>, &'a Bvh),
    leaf: OtherLeaf,
) {
    let packets = packets.get_or_insert_with(|| PacketKernel::of_thread(bvh));
    test_other(query, state, packets, leaf);
}

/// Test data of one ray, with the bits that a packet's ray has: eight lanes would take twice as
/// long for one.
#[inline(always)]
fn setup([org, dir]: [&[f32; 3]; 2]) -> SingleRaySetup {
    const SIDES: u32 = row_offset(1, 0);
    // 1 along axes on which the ray goes down; the sum of −0 and 0 is 0.
    let down = dir.map(|d| (d + 0.0).to_bits() >> 31);
    let size = org.map(f32::abs).into_iter().fold(0.0, f32::max);
    let pad = [0, 1, 2].map(|axis| f32::from_bits((size * PAD).to_bits() | down[axis] << 31));
    let near = [0, 1, 2].map(|axis| row_offset(0, axis) + down[axis] * SIDES);
    let axes = FRAMES[dominant_axis(dir)];
    let along = dir[axes[2]];
    let scale = 1.0 / along;
    let [slope_x, slope_y] = [0, 1].map(|k| dir[axes[k]] * scale);
    let steepness = if is_usual(size, along.abs()) {
        slope_x.abs().max(slope_y.abs())
    } else {
        f32::INFINITY
    };
    SingleRaySetup {
        rdir: dir.map(reciprocal_of_one),
        first: [0, 1, 2].map(|axis| org[axis] + pad[axis]),
        last: [0, 1, 2].map(|axis| org[axis] - pad[axis]),
        near,
        far: [0, 1, 2].map(|axis| 2 * row_offset(0, axis) + SIDES - near[axis]),
        axes: axes.map(|axis| axis as u32),
        frame_org: axes.map(|axis| org[axis]),
        slopes: [slope_x, slope_y, scale, steepness],
        org: *org,
        dir: *dir,
        up: 0b1111 - (down[0] | down[1] << 1 | down[2] << 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::full_or::full_or;
    use crate::intersect::random::RandomSource;
    use crate::simd::Mask8;
    use crate::traverse::single_ray::packet_of_one;
    use glam::Vec3;

    #[test]
    fn one_ray_is_set_up_as_in_a_packet() {
        let mut from = RandomSource(3);
        for round in 0..full_or(200_000, 20_000) {
            let (org, mut dir) = (
                from.position() * from.scale(60.0),
                from.position() * from.scale(90.0),
            );
            for axis in 0..3 {
                dir[axis] = match round >> (3 * axis) & 7 {
                    0 => 0.0,
                    1 => -0.0,
                    2 => dir[0],
                    3 => -dir[2],
                    _ => dir[axis],
                };
            }
            if dir == Vec3::ZERO {
                continue;
            }
            let (org, dir) = (org.to_array(), dir.to_array());
            let [want, ..] = ready(&packet_of_one(org, dir), Mask8::first(1));
            let ray_setup = setup([&org, &dir]);
            assert_eq!(
                bytemuck::bytes_of(&ray_setup),
                bytemuck::bytes_of(&want),
                "{org:?} {dir:?}"
            );
        }
    }
}
