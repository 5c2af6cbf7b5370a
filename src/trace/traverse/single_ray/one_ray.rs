//! One ray, from the root to its answer, while nothing else is in flight.
//!
//! There are no turns to take and no state to store between them. Entries that begin behind the
//! closest hit are skipped when they are popped, which is cheaper for one ray than
//! [`WideStack::prune`].

use super::ray_state::{RayState, SingleHit};
use super::ray_stream::ready_first;
use super::single_query::{SingleAny, SingleClosest, SingleQuery};
use super::{ROOT, packet_of_one, push_children, stack_room, test_block, test_other};
use crate::bvh::{Bvh, ChildRef, OtherLeaf};
use crate::packet::NO_PRIM;
use crate::simd::F32x8;
use crate::traverse::counters::PacketCount;
use crate::traverse::packet::PacketKernel;
use crate::traverse::wide_stack::WideStack;
use std::cell::RefCell;

thread_local! {
    /// The stack of a thread's calls, which keeps its memory from one to the next.
    static STACK: RefCell<WideStack> = const { RefCell::new(WideStack::EMPTY) };
}

/// Distance, barycentric weights and number of the closest hit of one ray below `tmax`.
pub(crate) fn closest_one(
    bvh: &Bvh,
    org: [f32; 3],
    dir: [f32; 3],
    tmax: f32,
) -> Option<([f32; 3], u32)> {
    let found = trace(bvh, SingleClosest, org, dir, tmax);
    let weights = [found.t, found.v / found.det, found.w / found.det];
    (found.t < tmax).then_some((weights, found.prim_id))
}

/// Returns true if one ray hits anything before `tmax`.
pub(crate) fn occluded_one(bvh: &Bvh, org: [f32; 3], dir: [f32; 3], tmax: f32) -> bool {
    trace(bvh, SingleAny, org, dir, tmax).prim_id != NO_PRIM
}

#[inline(always)]
fn trace<S: SingleQuery>(
    bvh: &Bvh,
    query: S,
    org: [f32; 3],
    dir: [f32; 3],
    tmax: f32,
) -> SingleHit {
    let mut state = RayState {
        ray: ready_first(&packet_of_one(org, dir)),
        best: SingleHit::none_before(tmax),
        current: ROOT,
        ..RayState::idle(0)
    };
    STACK.with_borrow_mut(|stack| descend(bvh, query, &mut state, stack));
    state.best
}

#[inline(always)]
fn descend<S: SingleQuery>(bvh: &Bvh, query: S, state: &mut RayState, stack: &mut WideStack) {
    let wide = bvh.wide();
    stack.reserve(stack_room(wide));
    // For leaves without blocks, which most scenes lack; it has a stack of its own.
    let mut packets = None;
    loop {
        match ChildRef::of_code(state.current) {
            ChildRef::Node(index) => {
                // SAFETY: a code of the tree refers to an existing row, and node 0 exists.
                let node = unsafe { wide.nodes().get_unchecked(index as usize) };
                // SAFETY: each level above this node's left at most `NATIVE - 1` entries.
                unsafe { push_children::<S>(state, node, stack) };
            }
            ChildRef::Other(index) => {
                let packets = packets.get_or_insert_with(|| PacketKernel::counting(bvh));
                other(query, state, packets, wide.others()[index as usize]);
            }
            block => {
                test_block(query, state, wide, block, &mut PacketCount::default());
            }
        }
        if !pop::<S>(state, stack) {
            return;
        }
    }
}

/// Takes the next entry that begins before the closest hit; returns false if there is none.
#[inline(always)]
fn pop<S: SingleQuery>(state: &mut RayState, stack: &WideStack) -> bool {
    while state.top > state.bottom {
        state.top -= 1;
        // SAFETY: `top` entries were written.
        if !S::FRONT_TO_BACK || unsafe { stack.tnear(state.top) } <= state.best.t {
            // SAFETY: as above.
            state.current = unsafe { stack.code(state.top) };
            return true;
        }
    }
    false
}

#[inline(never)]
fn other(
    query: impl SingleQuery,
    state: &mut RayState,
    packets: &mut PacketKernel<F32x8, PacketCount>,
    leaf: OtherLeaf,
) {
    test_other(query, state, packets, leaf);
}
