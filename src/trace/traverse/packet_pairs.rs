//! Packets of a queue through the packet kernel, two side by side for sixteen lanes.
//!
//! Packets keep search limits in lanes, so each ray may have its own. Beams and single rays of a
//! queue share one.

use super::batch_slice::BatchSlice;
use super::counters::{Counters, PacketCount};
use super::every_hit::FoundHits;
use super::packet::PacketKernel;
use super::queue_kernel::{QueueKernel, QueuePackets, TMaxOf};
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayQueue};
use crate::simd::{F32x8, F32x16, LANES, LaneMask, Lanes};
use std::ops::Range;

/// Packet kernels for one tree, counting by `T`.
pub(crate) struct PacketPairs<'a, T> {
    pub(super) eight: PacketKernel<'a, F32x8, T>,
    sixteen: PacketKernel<'a, F32x16, T>,
    /// True if two packets are traced side by side.
    pairs: bool,
}

impl<'a, T: Counters> PacketPairs<'a, T> {
    pub(super) fn new(bvh: &'a Bvh, pairs: bool) -> PacketPairs<'a, T> {
        PacketPairs {
            eight: PacketKernel::counting(bvh),
            sixteen: PacketKernel::counting(bvh),
            pairs,
        }
    }

    fn closest_of(
        &mut self,
        rays: &RayQueue,
        slice: &BatchSlice,
        tmax: TMaxOf,
        hits: &mut [HitPacket],
    ) {
        let first = slice.packets.start;
        for (packet, is_pair) in slice.pairs(self.pairs) {
            let k = packet - first;
            if is_pair {
                closest(&mut self.sixteen, rays, packet, tmax, &mut hits[k..k + 2]);
            } else {
                closest(&mut self.eight, rays, packet, tmax, &mut hits[k..k + 1]);
            }
        }
    }

    fn occluded_of(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: TMaxOf,
        blocked: &mut [u8],
    ) {
        let (pairs, last) =
            if self.pairs { blocked.as_chunks_mut::<2>() } else { (&mut [][..], blocked) };
        let mut packet = packets.start;
        for pair in pairs {
            let bits = occluded(&mut self.sixteen, rays, packet, tmax);
            *pair = [bits as u8, (bits >> LANES) as u8];
            packet += 2;
        }
        for one in last {
            *one = occluded(&mut self.eight, rays, packet, tmax) as u8;
            packet += 1;
        }
    }
}

impl<T: Counters> QueueKernel<T> for PacketPairs<'_, T> {
    fn closest(&mut self, rays: &RayQueue, slice: &BatchSlice, hits: &mut [HitPacket]) -> bool {
        self.closest_of(rays, slice, TMaxOf::All(f32::INFINITY), hits);
        true
    }

    fn occluded(&mut self, batch: QueuePackets, blocked: &mut [u8]) -> bool {
        self.occluded_of(batch.rays, batch.packets, TMaxOf::All(batch.tmax), blocked);
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
        for (packet, is_pair) in slice.pairs(self.pairs) {
            if is_pair {
                every_hit(&mut self.sixteen, rays, packet, tmax, hit_list);
            } else {
                every_hit(&mut self.eight, rays, packet, tmax, hit_list);
            }
        }
        true
    }

    fn counters(&self) -> T {
        let mut work = self.eight.counters;
        work.add(&self.sixteen.counters);
        work
    }
}

/// Tracing with a limit for each ray.
impl PacketPairs<'_, PacketCount> {
    /// The closest hits below the limits, for all packets of a queue, with one row of `tmax` and of
    /// `hits` each.
    pub(crate) fn closest_below(
        &mut self,
        rays: &RayQueue,
        tmax: &[[f32; LANES]],
        hits: &mut [HitPacket],
    ) {
        let all = BatchSlice::all(0..tmax.len());
        self.closest_of(rays, &all, TMaxOf::Each(tmax), hits);
    }

    /// Sets `blocked` to the lanes (as bits) that hit anything before their limits, for all packets
    /// of a queue.
    pub(crate) fn occluded_below(
        &mut self,
        rays: &RayQueue,
        tmax: &[[f32; LANES]],
        blocked: &mut [u8],
    ) {
        self.occluded_of(rays, 0..tmax.len(), TMaxOf::Each(tmax), blocked);
    }
}

#[inline(never)]
fn closest<L: Lanes, T: Counters>(
    kernel: &mut PacketKernel<L, T>,
    rays: &RayQueue,
    packet: usize,
    tmax: TMaxOf,
    hits: &mut [HitPacket],
) {
    let (rays, active) = tmax.packet(rays, packet);
    let wide_hits = if T::COUNTS_STEPS {
        kernel.call_closest(&rays, active)
    } else {
        kernel.closest(&rays, active)
    };
    for (k, hit) in hits.iter_mut().enumerate() {
        *hit = wide_hits.octet(k);
    }
}

#[inline(never)]
fn occluded<L: Lanes, T: Counters>(
    kernel: &mut PacketKernel<L, T>,
    rays: &RayQueue,
    packet: usize,
    tmax: TMaxOf,
) -> u32 {
    let (rays, active) = tmax.packet(rays, packet);
    if T::COUNTS_STEPS {
        kernel.call_occluded(&rays, active).bits()
    } else {
        kernel.occluded(&rays, active).bits()
    }
}

#[inline(never)]
fn every_hit<L: Lanes, T: Counters>(
    kernel: &mut PacketKernel<L, T>,
    rays: &RayQueue,
    packet: usize,
    tmax: TMaxOf,
    hit_list: &FoundHits,
) {
    let (rays, active) = tmax.packet(rays, packet);
    kernel.every_hit(&rays, active, packet * LANES, hit_list);
}
