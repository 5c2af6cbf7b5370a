//! A queue of rays in a bump arena, stored packet by packet, so that rays pushed one by one come
//! out in full packets.

use super::{RayPacket, packets_for};
use crate::simd::{F32x8, LANES, LaneMask, LaneMove, Lanes, Mask8, U32x8, Vec3Lanes, Vec3x8};
use bumpalo::Bump;

/// Eight rays, in memory order: three whole cache lines.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct RaySlot {
    pub(crate) org: [[f32; LANES]; 3],
    pub(crate) dir: [[f32; LANES]; 3],
}

/// Payload of eight rays. Stored separately, because traversal does not read it.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct RayPayload {
    throughput: Rgb,
    parent: [u32; LANES],
}

/// Rays waiting to be traced, each with the hit that sent it (`parent`) and the weight of its
/// radiance (`throughput`, RGB). If rays involve random choices, the queue also has their seeds. If
/// rays of little weight are not traced, it also has the share of the camera ray that each carries
/// (`shares`, RGB).
pub struct RayQueue<'arena> {
    slots: &'arena mut [RaySlot],
    payloads: &'arena mut [RayPayload],
    /// Seeds of the rays; empty if there are no random choices.
    seeds: &'arena mut [[u32; LANES]],
    /// Shares of the rays; empty if they are not needed, and then every share is 1.
    shares: &'arena mut [Rgb],
    len: usize,
}

/// Colours of eight rays, by component.
type Rgb = [[f32; LANES]; 3];

const EMPTY_SLOT: RaySlot = RaySlot {
    org: [[0.0; LANES]; 3],
    dir: [[0.0; LANES]; 3],
};

const EMPTY_PAYLOAD: RayPayload = RayPayload {
    throughput: [[0.0; LANES]; 3],
    parent: [0; LANES],
};

/// The optional columns of a queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct QueueColumns {
    /// True if the queue has seeds.
    pub seeds: bool,
    /// True if the queue has shares.
    pub shares: bool,
}

/// Reusable memory of a queue, for rays that wait while others are traced.
#[derive(Default)]
pub struct QueueStorage {
    slots: Vec<RaySlot>,
    payloads: Vec<RayPayload>,
    seeds: Vec<[u32; LANES]>,
    shares: Vec<Rgb>,
    len: usize,
}

impl QueueStorage {
    /// Bytes of eight rays with all columns.
    pub const PACKET_BYTES: usize = size_of::<RaySlot>()
        + size_of::<RayPayload>()
        + size_of::<[u32; LANES]>()
        + size_of::<Rgb>();

    /// Removes all rays.
    #[inline]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Clears the queue and refills it from `push`, up to `packets` packets.
    pub fn fill<T>(
        &mut self,
        packets: usize,
        columns: QueueColumns,
        push: impl FnOnce(&mut RayQueue) -> T,
    ) -> T {
        let packets_if = |is_needed: bool| if is_needed { packets } else { 0 };
        grow(&mut self.slots, packets, EMPTY_SLOT);
        grow(&mut self.payloads, packets, EMPTY_PAYLOAD);
        grow(&mut self.seeds, packets_if(columns.seeds), [0; LANES]);
        let shares = packets_if(columns.shares);
        grow(&mut self.shares, shares, [[0.0; LANES]; 3]);
        self.len = 0;
        let mut queue = self.queue();
        let done = push(&mut queue);
        self.len = queue.len;
        done
    }

    /// The queue that was filled last.
    #[inline]
    pub fn queue(&mut self) -> RayQueue<'_> {
        RayQueue {
            slots: &mut self.slots,
            payloads: &mut self.payloads,
            seeds: &mut self.seeds,
            shares: &mut self.shares,
            len: self.len,
        }
    }
}

/// Extends a column to at least `packets`, allocating no more than that.
fn grow<T: Clone>(column: &mut Vec<T>, packets: usize, empty: T) {
    if column.len() < packets {
        column.reserve_exact(packets - column.len());
        column.resize(packets, empty);
    }
}

impl<'arena> RayQueue<'arena> {
    /// An empty queue with room for `capacity` rays.
    pub fn with_capacity(arena: &'arena Bump, capacity: usize) -> RayQueue<'arena> {
        let packets = packets_for(capacity);
        RayQueue {
            slots: arena.alloc_slice_fill_copy(packets, EMPTY_SLOT),
            payloads: arena.alloc_slice_fill_copy(packets, EMPTY_PAYLOAD),
            seeds: &mut [],
            shares: &mut [],
            len: 0,
        }
    }

    /// An empty queue, with seeds if `seeded` is true.
    #[inline]
    pub fn seeded(arena: &'arena Bump, capacity: usize, seeded: bool) -> RayQueue<'arena> {
        let queue = RayQueue::with_capacity(arena, capacity);
        if !seeded {
            return queue;
        }
        let seeds = arena.alloc_slice_fill_copy(packets_for(capacity), [0; LANES]);
        RayQueue { seeds, ..queue }
    }

    /// Returns true if the rays have seeds.
    #[inline]
    pub fn has_seeds(&self) -> bool {
        !self.seeds.is_empty()
    }

    /// Number of waiting rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Number of packets that hold the rays.
    #[inline]
    pub fn packets(&self) -> usize {
        packets_for(self.len)
    }

    /// Returns true if no ray waits.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Removes all rays and keeps the memory.
    #[inline]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends the lanes of `mask`, in lane order.
    ///
    /// # Panics
    /// If the queue is full.
    pub fn push(
        &mut self,
        mask: Mask8,
        org: Vec3x8,
        dir: Vec3x8,
        weight: Vec3x8,
        parent: &[u32; LANES],
    ) {
        let lanes = mask.bits();
        if lanes == 0 {
            return;
        }
        let (packet, lane) = (self.len / LANES, self.len % LANES);
        let (slot, payload) = (&mut self.slots[packet], &mut self.payloads[packet]);
        let count = lanes.count_ones() as usize;
        self.len += count;
        // Column by column into the slot. A slot built first would be copied in pieces of other
        // sizes than those of its stores, which stalls.
        if count == LANES && lane == 0 {
            set_columns(&mut slot.org, org, |column| column);
            set_columns(&mut slot.dir, dir, |column| column);
            set_columns(&mut payload.throughput, weight, |column| column);
            payload.parent = *parent;
            return;
        }
        let to = LaneMove::new(lanes, lane);
        let moved = |column| to.floats(column);
        // Lanes after the last ray get copies of others, which the next push overwrites.
        let earlier = Mask8::first(lane);
        set_other_columns(earlier, &mut slot.org, org, moved);
        set_other_columns(earlier, &mut slot.dir, dir, moved);
        set_other_columns(earlier, &mut payload.throughput, weight, moved);
        set_other_numbers(earlier, &mut payload.parent, to.numbers(parent));
        if lane + count > LANES {
            let (slot, payload) = (&mut self.slots[packet + 1], &mut self.payloads[packet + 1]);
            set_columns(&mut slot.org, org, moved);
            set_columns(&mut slot.dir, dir, moved);
            set_columns(&mut payload.throughput, weight, moved);
            payload.parent = to.numbers(parent);
        }
    }

    /// Sets the seeds of the rays that the next [`RayQueue::push`] of the same `mask` appends.
    ///
    /// # Panics
    /// If there is no room for the rays, or none for seeds.
    #[inline]
    pub fn push_seeds(&mut self, mask: Mask8, seeds: &[u32; LANES]) {
        if !mask.any() {
            return;
        }
        let (packet, lane) = (self.len / LANES, self.len % LANES);
        let (to, count) = (LaneMove::new(mask.bits(), lane), mask.bits().count_ones());
        let moved = to.numbers(seeds);
        set_other_numbers(Mask8::first(lane), &mut self.seeds[packet], moved);
        if lane + count as usize > LANES {
            self.seeds[packet + 1] = moved;
        }
    }

    /// Sets the shares of the rays that the next [`RayQueue::push`] of the same `mask` appends.
    ///
    /// # Panics
    /// If there is no room for the rays, or none for shares.
    #[inline]
    pub fn push_shares(&mut self, mask: Mask8, share: &Vec3x8) {
        if !mask.any() {
            return;
        }
        let (packet, lane) = (self.len / LANES, self.len % LANES);
        let (to, count) = (LaneMove::new(mask.bits(), lane), mask.bits().count_ones());
        let moved = |column| to.floats(column);
        set_other_columns(Mask8::first(lane), &mut self.shares[packet], *share, moved);
        if lane + count as usize > LANES {
            set_columns(&mut self.shares[packet + 1], *share, moved);
        }
    }

    /// Appends one ray, without a payload.
    ///
    /// # Panics
    /// If the queue is full.
    #[inline]
    pub fn push_ray(&mut self, org: [f32; 3], dir: [f32; 3]) {
        let (slot, lane) = (&mut self.slots[self.len / LANES], self.len % LANES);
        for axis in 0..3 {
            slot.org[axis][lane] = org[axis];
            slot.dir[axis][lane] = dir[axis];
        }
        self.len += 1;
    }

    /// Appends the first `count` of eight rays, without a payload. Nothing may follow a packet that
    /// is not full.
    ///
    /// # Panics
    /// If the queue is full, or its last packet is not.
    #[inline]
    pub fn push_octet(&mut self, org: [&[f32; LANES]; 3], dir: [&[f32; LANES]; 3], count: usize) {
        assert!(
            self.len.is_multiple_of(LANES),
            "the last packet is not full"
        );
        let slot = &mut self.slots[self.len / LANES];
        for axis in 0..3 {
            slot.org[axis] = *org[axis];
            slot.dir[axis] = *dir[axis];
        }
        self.len += count.min(LANES);
    }

    /// Packet `index` (and the ones after it, if `L` holds more than one) and the lanes that carry
    /// rays; `tmax` is the same for all.
    #[inline(always)]
    pub fn packet<L: Lanes>(&self, index: usize, tmax: f32) -> (RayPacket<L>, L::Mask) {
        let left = self.len.saturating_sub(index * LANES);
        (
            self.packets_at(|k| index + k, tmax),
            L::Mask::first(left.min(L::PACKETS * LANES)),
        )
    }

    /// As many packets side by side as `L` holds; `index` gives the index of the k-th. Past the
    /// end, the last packet is repeated.
    #[inline(always)]
    pub fn packets_at<L: Lanes>(&self, index: impl Fn(usize) -> usize, tmax: f32) -> RayPacket<L> {
        let slot = |k: usize| &self.slots[index(k).min(self.slots.len() - 1)];
        let vec = |pick: fn(&RaySlot, usize) -> [f32; LANES]| {
            Vec3Lanes::new(
                L::from_octets(|k| pick(slot(k), 0)),
                L::from_octets(|k| pick(slot(k), 1)),
                L::from_octets(|k| pick(slot(k), 2)),
            )
        };
        RayPacket {
            org: vec(|slot, axis| slot.org[axis]),
            dir: vec(|slot, axis| slot.dir[axis]),
            tmax: L::splat(tmax),
        }
    }

    /// The rays' memory, for prefetching.
    #[inline(always)]
    pub(crate) fn slots(&self) -> &[RaySlot] {
        &self.slots[..self.packets()]
    }

    /// Lanes of packet `index` that carry rays.
    #[inline(always)]
    pub fn active(&self, index: usize) -> Mask8 {
        Mask8::first(self.len.saturating_sub(index * LANES).min(LANES))
    }

    /// Origin and direction of one ray.
    #[inline]
    pub fn ray(&self, packet: usize, lane: usize) -> ([f32; 3], [f32; 3]) {
        let slot = &self.slots[packet];
        (slot.org.map(|c| c[lane]), slot.dir.map(|c| c[lane]))
    }

    /// Origins and directions of eight rays, by their numbers from packet `first` on.
    #[inline]
    pub fn gather(&self, first: usize, rays: &[u32; LANES]) -> (Vec3x8, Vec3x8) {
        let slots = &self.slots[first..];
        let place = |k: usize| (&slots[rays[k] as usize / LANES], rays[k] as usize % LANES);
        let vec = |pick: fn(&RaySlot, usize) -> &[f32; LANES]| {
            let column = |axis| {
                F32x8::from_lanes(|k| {
                    let (slot, lane) = place(k);
                    pick(slot, axis)[lane]
                })
            };
            Vec3x8::new(column(0), column(1), column(2))
        };
        (
            vec(|slot, axis| &slot.org[axis]),
            vec(|slot, axis| &slot.dir[axis]),
        )
    }

    /// The seed of one ray; 0 if rays have none.
    #[inline]
    pub fn seed(&self, packet: usize, lane: usize) -> u32 {
        self.seeds.get(packet).map_or(0, |seeds| seeds[lane])
    }

    /// The share of one ray.
    #[inline]
    pub fn share(&self, packet: usize, lane: usize) -> [f32; 3] {
        let one = self.shares.get(packet);
        one.map_or([1.0; 3], |rgb| rgb.map(|c| c[lane]))
    }

    /// Weights and parents of packet `index`.
    #[inline]
    pub fn payload(&self, index: usize) -> (&Rgb, &[u32; LANES]) {
        let payload = &self.payloads[index];
        (&payload.throughput, &payload.parent)
    }
}

/// Sets three columns to those of a vector, each passed through `moved`. Written component by
/// component, because a loop over an array of vectors moves them around on the stack.
#[inline(always)]
fn set_columns(to: &mut Rgb, from: Vec3x8, moved: impl Fn(F32x8) -> F32x8) {
    to[0] = moved(from.x).to_array();
    to[1] = moved(from.y).to_array();
    to[2] = moved(from.z).to_array();
}

/// Replaces the lanes of three columns that are not in `earlier`.
#[inline(always)]
fn set_other_columns(earlier: Mask8, to: &mut Rgb, from: Vec3x8, moved: impl Fn(F32x8) -> F32x8) {
    to[0] = earlier.select(F32x8::new(to[0]), moved(from.x)).to_array();
    to[1] = earlier.select(F32x8::new(to[1]), moved(from.y)).to_array();
    to[2] = earlier.select(F32x8::new(to[2]), moved(from.z)).to_array();
}

/// Replaces the lanes of a column that are not in `earlier`.
#[inline(always)]
fn set_other_numbers(earlier: Mask8, to: &mut [u32; LANES], from: [u32; LANES]) {
    *to = earlier
        .select_u32(U32x8::new(*to), U32x8::new(from))
        .to_array();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three columns of different numbers.
    fn columns(first: usize) -> Vec3x8 {
        let column =
            |c: usize| F32x8::new(std::array::from_fn(|lane| (first + 100 * c + lane) as f32));
        Vec3x8::new(column(0), column(1), column(2))
    }

    fn lane_of(v: &Vec3x8, lane: usize) -> [f32; 3] {
        [v.x.lane(lane), v.y.lane(lane), v.z.lane(lane)]
    }

    #[test]
    fn rays_stand_in_the_order_in_which_they_were_pushed() {
        let columns_of_all = QueueColumns {
            seeds: true,
            shares: true,
        };
        let (mut storage, mut expected) = (QueueStorage::default(), Vec::new());
        let sets = (0..300_u32).map(|k| k.wrapping_mul(0x9e37_79b1) >> 24);
        let sets: Vec<u32> = [0xff, 0, 0xff].into_iter().chain(sets).collect();
        let count: u32 = sets.iter().map(|set| set.count_ones()).sum();
        // Not a packet more than the rays need.
        let packets = packets_for(count as usize);
        storage.fill(packets, columns_of_all, |queue| {
            for (k, &set) in (0..).zip(&sets) {
                let mask = Mask8::from_bits(set);
                let [org, dir, weight, share] = [0, 1, 2, 3].map(|c| columns(1000 * k + 10 * c));
                let parent = std::array::from_fn(|lane| 8 * k as u32 + lane as u32);
                let seeds = parent.map(|p| !p);
                queue.push_seeds(mask, &seeds);
                queue.push_shares(mask, &share);
                queue.push(mask, org, dir, weight, &parent);
                for lane in mask.lanes() {
                    let vectors = [org, dir, weight, share].map(|v| lane_of(&v, lane));
                    expected.push((vectors, parent[lane], seeds[lane]));
                }
            }
            // No lanes are pushed onto a queue that has no room.
            queue.push_seeds(Mask8::none(), &[0; LANES]);
            queue.push_shares(Mask8::none(), &columns(0));
            queue.push(
                Mask8::none(),
                columns(0),
                columns(0),
                columns(0),
                &[0; LANES],
            );
        });
        let queue = storage.queue();
        assert_eq!((queue.len(), queue.packets()), (expected.len(), packets));
        for (k, (vectors, parent, seed)) in expected.into_iter().enumerate() {
            let (packet, lane) = (k / LANES, k % LANES);
            let (org, dir) = queue.ray(packet, lane);
            let (weight, parents) = queue.payload(packet);
            let stored = [org, dir, weight.map(|c| c[lane]), queue.share(packet, lane)];
            assert_eq!(stored, vectors, "ray {k}");
            assert_eq!((parents[lane], queue.seed(packet, lane)), (parent, seed));
        }
    }
}
