//! Single rays through the wide tree, several at a time: a lane is a child of a node, or a
//! primitive of a block.
//!
//! Divergent rays share neither nodes nor leaves, and most lanes of a packet would idle. The
//! children of one node fill all lanes. A single ray waits for memory and for the result of its
//! last comparison. So a dozen or more rays advance side by side in rounds: first those at nodes,
//! then those at blocks, and each a little later to its next row. A round begins where the previous
//! one ends. While one ray waits, another's data arrive. Nothing branches on the result of a box
//! test. All children are written above the stack's top, the hit ones first, and the top moves by
//! their number.

mod entry_node;
mod one_ray;
mod ray_state;
mod ray_stream;
mod single_query;

use super::batch_slice::BatchSlice;
use super::counters::{Counters, PacketCount};
use super::every_hit::FoundHits;
use super::filtered_hit::HitFilter;
use super::packet::PacketKernel;
use super::prefetch::PrefetchTable;
use super::queue_kernel::{QueueKernel, QueuePackets, TMaxOf};
use super::wide_stack::{ThreadStack, WideStack};
use crate::bvh::{Bvh, ChildRef, LeafKind, OtherLeaf, WideBvh, WideNode};
use crate::intersect::ray_setup::RaySetup;
use crate::isa;
use crate::packet::{HitPacket, NO_PRIM, RayPacket, RayQueue, packets_for};
use crate::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, NATIVE, Native, Vec3x8};
use entry_node::{EntryNode, ROOT, SegmentBox};
pub(crate) use one_ray::OneRay;
use phalanx_scene::ForkSafeOnce;
pub(crate) use ray_state::OneHit;
use ray_state::RayState;
pub(crate) use ray_stream::RayOctets;
use ray_stream::{QueueRays, RayStream};
use single_query::{LoneLeaf, SingleAny, SingleClosest, SingleEvery, SingleFiltered, SingleQuery};
use std::ops::Range;

/// Maximum number of rays in flight.
const MAX_IN_FLIGHT: usize = 32;

/// Rays in flight on this machine: the maximum, or half of it if the rows that all rays read, and
/// the same number of prefetched rows, would fill the nearest cache. With sixteen children per row
/// that is 32 KiB (`perf/notes/single-rays.md`, fifth and sixth round).
fn rays_in_flight() -> usize {
    static RAYS_IN_FLIGHT: ForkSafeOnce<usize> = ForkSafeOnce::new();
    *RAYS_IN_FLIGHT.get_or_init(|| {
        let rows = 2 * MAX_IN_FLIGHT * size_of::<WideNode>();
        match isa::nearest_cache() {
            Some(bytes) if bytes <= rows => MAX_IN_FLIGHT / 2,
            _ => MAX_IN_FLIGHT,
        }
    })
}

/// Minimum number of packets for which an [`EntryNode`] is built: it takes as long as visiting a
/// hundred nodes.
const MIN_ENTRY_PACKETS: usize = 16;

/// Turns after which a ray continues to its next row. If it continued at once, it would wait for
/// the values that its turn has just stored. If all rays continued after the last turn, they would
/// fetch all their rows at once, more than a core has buffers for.
const PIPELINE_DELAY: usize = 2;

/// Entries of a ray's stack: a node pops one and pushes one per child.
fn stack_room(wide: &WideBvh) -> usize {
    wide.depth() * (NATIVE - 1) + NATIVE + 1
}

/// Traces single rays of a queue, and counts by `T`.
pub(crate) struct SingleRays<'a, T = PacketCount> {
    bvh: &'a Bvh,
    wide: &'a WideBvh,
    rows: PrefetchTable,
    /// Packet kernel for primitives without blocks, once one was met: most scenes lack them.
    packets: Option<PacketKernel<'a, F32x8, T>>,
    rays_in_flight: usize,
    /// A stack for each ray in flight, one after the other.
    stacks: ThreadStack,
    /// Entries of each stack.
    room: usize,
    /// The root of short rays.
    entry: EntryNode,
    counters: T,
}

impl<'a, T: Counters> SingleRays<'a, T> {
    #[inline(always)]
    pub(crate) fn new(bvh: &'a Bvh) -> SingleRays<'a, T> {
        let wide = bvh.wide();
        let room = stack_room(wide);
        SingleRays {
            bvh,
            wide,
            rows: PrefetchTable::of(wide),
            packets: None,
            rays_in_flight: rays_in_flight(),
            stacks: ThreadStack::with_room(room * MAX_IN_FLIGHT),
            room,
            entry: EntryNode::new(),
            counters: T::default(),
        }
    }

    #[inline(always)]
    fn trace<S: SingleQuery>(
        &mut self,
        query: S,
        mut source: RayStream<'_, impl RayOctets, impl Iterator<Item = usize>>,
        mut done: impl FnMut(&RayState),
    ) {
        // Rays that have continued to their next row, and those of them for which it is a leaf.
        let (mut waiting, mut at_leaves) = (RayMask::EMPTY, RayMask::EMPTY);
        let mut states = [RayState::IDLE; MAX_IN_FLIGHT];
        for (k, state) in states[..self.rays_in_flight].iter_mut().enumerate() {
            state.bottom = k * self.room;
            if !source.next(state, &mut self.counters) {
                break;
            }
            waiting.insert_if(k, true);
        }
        let (mut nodes, mut leaves) = (RayMask::EMPTY, RayMask::EMPTY);
        // Rays whose turn is over but that have not continued yet, in order.
        let mut behind = [NO_RAY; PIPELINE_DELAY];
        loop {
            if nodes.is_empty() && leaves.is_empty() {
                (nodes, leaves) = (waiting.without(at_leaves), at_leaves);
                (waiting, at_leaves) = (RayMask::EMPTY, RayMask::EMPTY);
            }
            let turn = if !nodes.is_empty() {
                let k = nodes.take();
                self.visit_node::<S>(&mut states[k]);
                k
            } else if !leaves.is_empty() {
                let k = leaves.take();
                self.leaf(query, &mut states[k]);
                k
            } else if behind == [NO_RAY; PIPELINE_DELAY] {
                break;
            } else {
                NO_RAY
            };
            let k = behind[0];
            behind.copy_within(1.., 0);
            behind[PIPELINE_DELAY - 1] = turn;
            if k == NO_RAY {
                continue;
            }
            let state = &mut states[k];
            if !self.pop(state) {
                done(state);
                if !source.next(state, &mut self.counters) {
                    continue;
                }
            }
            let leaf = !matches!(ChildRef::of_code(state.current), ChildRef::Node(_));
            waiting.insert_if(k, true);
            at_leaves.insert_if(k, leaf);
        }
    }

    /// Pushes the hit children of the ray's current node.
    #[inline(always)]
    fn visit_node<S: SingleQuery>(&mut self, state: &mut RayState) {
        self.counters.wide_node(NATIVE as u64);
        let node = if !S::FRONT_TO_BACK && state.current == ChildRef::ELSEWHERE {
            &self.entry.node
        } else {
            // SAFETY: another code of the tree refers to an existing row, and this one is a node's;
            // node 0 exists.
            unsafe { self.wide.nodes().get_unchecked(state.current as usize) }
        };
        // SAFETY: a node is entered from the root or from an entry that was taken off the stack. So
        // each level above this node's left at most `NATIVE - 1` entries, and there is room for
        // `NATIVE` more. An entry node is in the root's place, and has children of its level or
        // below.
        unsafe { push_children::<S>(state, node, children_met(state, node), &mut self.stacks.0) };
    }

    /// Code of the node where rays that end begin; none if they hit nothing.
    fn root_of_short(&mut self, rays: &impl RayOctets, packets: &Range<usize>) -> Option<u32> {
        if packets.len() < MIN_ENTRY_PACKETS || rays.limit(packets.start * LANES) == f32::INFINITY {
            return Some(ROOT);
        }
        match SegmentBox::around(rays, packets.clone()) {
            Some(bounds) => (self.entry).gather(self.wide, &bounds, &mut self.counters),
            None => Some(ROOT),
        }
    }

    /// Pops the next entry; returns false if there is none.
    #[inline(always)]
    fn pop(&mut self, state: &mut RayState) -> bool {
        if state.top == state.bottom {
            return false;
        }
        state.top -= 1;
        // SAFETY: `top` entries were written.
        state.current = unsafe { self.stacks.0.code(state.top) };
        // It is read after all the other rays have moved.
        self.rows.prefetch(state.current);
        true
    }

    #[inline(always)]
    fn leaf(&mut self, query: impl SingleQuery, state: &mut RayState) {
        let closer = match ChildRef::of_code(state.current) {
            ChildRef::Other(index) => self.other(query, state, index),
            block => test_block(query, state, self.wide, block, &mut self.counters),
        };
        if closer {
            let stack = state.bottom..state.top;
            state.top = self.stacks.0.prune(stack, state.best.reach());
        }
    }

    #[inline(never)]
    fn other(&mut self, query: impl SingleQuery, state: &mut RayState, index: u32) -> bool {
        let leaf = self.wide.others()[index as usize];
        let packets = self
            .packets
            .get_or_insert_with(|| PacketKernel::counting(self.bvh));
        test_other(query, state, packets, leaf)
    }
}

/// Rays of the caller's, without a queue.
impl SingleRays<'_> {
    /// Passes on the number of each ray that is traced, and its closest hit.
    #[inline(never)]
    pub(crate) fn closest_of(
        &mut self,
        (rays, count): (&impl RayOctets, usize),
        done: &mut dyn FnMut(usize, OneHit),
    ) {
        let source = RayStream::new(rays, 0..packets_for(count), ROOT);
        self.trace(SingleClosest, source, |state| {
            done(
                state.number,
                OneHit::below(rays.limit(state.number), &state.best),
            );
        });
    }

    /// Sets the flags of rays that hit anything.
    #[inline(never)]
    pub(crate) fn occluded_of(&mut self, rays: &impl RayOctets, blocked: &mut [bool]) {
        blocked.fill(false);
        let packets = 0..packets_for(blocked.len());
        let Some(root) = self.root_of_short(rays, &packets) else {
            return;
        };
        let source = RayStream::new(rays, packets, root);
        self.trace(SingleAny, source, |state| {
            blocked[state.number] = state.best.prim_id != NO_PRIM;
        });
    }
}

/// The children of a node that a ray enters between 0 and its reach, as bits, and the distances at
/// which all of them begin.
#[inline(always)]
fn children_met(state: &RayState, node: &WideNode) -> (u32, Native) {
    let planes = node.boxes.as_ptr().cast::<[f32; NATIVE]>();
    // SAFETY: a ray's rows are offsets of rows of planes of a node: its sides are 0 or 1.
    let crossing = state.intersect_children(|row| Native::new(unsafe { *planes.byte_add(row) }));
    let enter = crossing.tnear.max(Native::ZERO);
    let met = enter.le(crossing.tfar.min(Native::splat(state.best.reach())));
    (met.bits(), enter)
}

/// Pushes some children of a node, those `met` as bits, farthest first.
///
/// # Safety
/// There must be room for [`NATIVE`] entries from the ray's `top` on.
#[inline(always)]
unsafe fn push_children<S: SingleQuery>(
    state: &mut RayState,
    node: &WideNode,
    (met, enter): (u32, Native),
    stack: &mut WideStack,
) {
    // SAFETY: the caller's promise.
    state.top += unsafe {
        if S::FRONT_TO_BACK {
            // The last child is visited first: the nearest, which is the first if the ray goes up.
            let up = state.goes_up(node.axis);
            stack.push_hits(state.top, up, met, enter, &node.children)
        } else {
            stack.push_any(state.top, met, &node.children)
        }
    };
}

/// Tests a block; true if the ray's limit is nearer than before.
#[inline(always)]
fn test_block<S: SingleQuery>(
    query: S,
    state: &mut RayState,
    wide: &WideBvh,
    block: ChildRef,
    counters: &mut impl Counters,
) -> bool {
    match block {
        ChildRef::Triangles(index) => {
            counters.block(LeafKind::TRIANGLE, NATIVE as u64);
            // SAFETY: a code of the tree refers to an existing row.
            let block = unsafe { wide.triangles().get_unchecked(index as usize) };
            let hit = state.triangles(block);
            hit.is_some_and(|hit| query.update(state, &hit, &block.prim_id))
        }
        ChildRef::Spheres(index) => {
            counters.block(LeafKind::SPHERE, NATIVE as u64);
            // SAFETY: as above.
            let block = unsafe { wide.spheres().get_unchecked(index as usize) };
            let hit = state.spheres::<false>(block);
            let mut closer = hit.is_some_and(|hit| query.update(state, &hit, &block.prim_id));
            if S::FAR_SIDES
                && let Some(hit) = state.spheres::<true>(block)
            {
                closer |= query.update(state, &hit, &block.prim_id);
            }
            closer
        }
        ChildRef::Node(_) | ChildRef::Other(_) => false,
    }
}

/// Tests a leaf of a kind without blocks, by the packet's tests, in one lane; true if the ray's
/// limit is nearer than before.
#[inline(always)]
fn test_other<T: Counters>(
    query: impl SingleQuery,
    state: &mut RayState,
    packets: &mut PacketKernel<F32x8, T>,
    leaf: OtherLeaf,
) -> bool {
    let leaf = LoneLeaf {
        packets,
        ray: RaySetup::new(
            &packet_of_one(state.ray.org, state.ray.dir),
            Mask8::first(1),
        ),
        kind: leaf.kind,
        slots: leaf.first as usize..(leaf.first + leaf.count) as usize,
    };
    query.other(state, leaf)
}

/// A ray in all lanes of a packet.
#[inline(always)]
fn packet_of_one(org: [f32; 3], dir: [f32; 3]) -> RayPacket<F32x8> {
    let splat = |[x, y, z]: [f32; 3]| Vec3x8::splat(x, y, z);
    RayPacket {
        org: splat(org),
        dir: splat(dir),
        tmax: F32x8::splat(f32::INFINITY),
    }
}

/// Single rays that choose among their hits.
pub(crate) struct FilteredRays<'a>(SingleRays<'a>);

impl<'a> FilteredRays<'a> {
    pub(crate) fn new(bvh: &'a Bvh) -> FilteredRays<'a> {
        FilteredRays(SingleRays::new(bvh))
    }

    /// Traces the rays of a queue, and tells `done` about each: the closest hit below `tmax` that
    /// the filter accepts, if there is one.
    pub(crate) fn trace(
        &mut self,
        rays: &RayQueue,
        tmax: f32,
        filter: &HitFilter,
        done: &mut dyn FnMut(usize, Option<([f32; 3], u32)>),
    ) {
        let queue = QueueRays { rays, tmax };
        let source = RayStream::new(&queue, 0..rays.packets(), ROOT);
        self.0.trace(SingleFiltered(filter), source, |state| {
            done(state.number, state.best.below(tmax));
        });
    }
}

impl<T: Counters> QueueKernel<T> for SingleRays<'_, T> {
    fn closest(&mut self, rays: &RayQueue, slice: &BatchSlice, hits: &mut [HitPacket]) -> bool {
        let first = slice.packets.start;
        for packet in slice.each() {
            hits[packet - first] = HitPacket::miss();
        }
        let start = first * LANES;
        let queue = QueueRays {
            rays,
            tmax: f32::INFINITY,
        };
        let source = RayStream::new(&queue, slice.each(), ROOT);
        self.trace(SingleClosest, source, |state| {
            if let Some((weights, prim_id)) = state.best.below(f32::INFINITY) {
                let row = state.number - start;
                hits[row / LANES].set(row % LANES, weights, prim_id);
            }
        });
        true
    }

    fn occluded(&mut self, batch: QueuePackets, blocked: &mut [u8]) -> bool {
        let QueuePackets {
            rays,
            packets,
            tmax,
        } = batch;
        blocked.fill(0);
        let start = packets.start * LANES;
        let queue = QueueRays { rays, tmax };
        let Some(root) = self.root_of_short(&queue, &packets) else {
            return true;
        };
        let source = RayStream::new(&queue, packets, root);
        self.trace(SingleAny, source, |state| {
            let row = state.number - start;
            blocked[row / LANES] |= u8::from(state.best.prim_id != NO_PRIM) << (row % LANES);
        });
        true
    }

    fn every_hit(
        &mut self,
        rays: &RayQueue,
        slice: &BatchSlice,
        tmax: TMaxOf,
        hit_list: &FoundHits,
    ) -> bool {
        if T::COUNTS_STEPS {
            return false;
        }
        let TMaxOf::All(tmax) = tmax else {
            return false;
        };
        let queue = QueueRays { rays, tmax };
        let source = RayStream::new(&queue, slice.each(), ROOT);
        self.trace(SingleEvery(hit_list), source, |_| {});
        true
    }

    fn counters(&self) -> T {
        let mut work = self.counters;
        if let Some(packets) = &self.packets {
            work.add(&packets.counters);
        }
        work
    }
}

/// Number in the place of a ray.
const NO_RAY: usize = MAX_IN_FLIGHT;

/// Set of ray states, as bits.
#[derive(Clone, Copy)]
struct RayMask(u32);

const _: () = assert!(MAX_IN_FLIGHT <= u32::BITS as usize, "a bit for each ray");

impl RayMask {
    const EMPTY: RayMask = RayMask(0);

    #[inline(always)]
    fn is_empty(self) -> bool {
        self.0 == 0
    }

    #[inline(always)]
    fn without(self, others: RayMask) -> RayMask {
        RayMask(self.0 & !others.0)
    }

    /// Adds a ray if `holds` is true, without a branch.
    #[inline(always)]
    fn insert_if(&mut self, number: usize, holds: bool) {
        self.0 |= u32::from(holds) << (number % MAX_IN_FLIGHT);
    }

    /// Removes the first ray, which must exist.
    #[inline(always)]
    fn take(&mut self) -> usize {
        let first = self.0.trailing_zeros() as usize % MAX_IN_FLIGHT;
        self.0 &= self.0.wrapping_sub(1);
        first
    }
}
