//! The interface of kernels: a queue of rays in, hits or occlusion out, and counters of the work.

use super::batch_slice::BatchSlice;
use super::every_hit::FoundHits;
use crate::packet::{HitPacket, RayPacket, RayQueue};
use crate::simd::{LANES, Lanes};
use std::ops::Range;

/// Some packets of a queue, whose rays end at `tmax`.
#[derive(Clone)]
pub(super) struct QueuePackets<'q, 'a> {
    pub(super) rays: &'q RayQueue<'a>,
    pub(super) packets: Range<usize>,
    pub(super) tmax: f32,
}

/// A kernel that traces packets of a queue, and counts by `T`. It leaves rays that it cannot trace
/// to the packet kernel, which can trace any.
pub(super) trait QueueKernel<T> {
    /// Finds the closest hits of the packets of a slice; `hits` has a row for every packet of the
    /// slice's range. Returns false, and does nothing, if the kernel cannot trace these rays.
    fn closest(&mut self, rays: &RayQueue, slice: &BatchSlice, hits: &mut [HitPacket]) -> bool;

    /// Sets `blocked`, a byte for each packet, to the lanes (as bits) that hit anything before
    /// `tmax`; lanes without a ray are not set. Returns false, and does nothing, if the kernel
    /// cannot trace these rays.
    fn occluded(&mut self, batch: QueuePackets, blocked: &mut [u8]) -> bool;

    /// Adds all hits of a slice's rays before `tmax` to `hit_list`. Returns false, and does
    /// nothing, if the kernel cannot trace these rays.
    fn every_hit(
        &mut self,
        rays: &RayQueue,
        slice: &BatchSlice,
        tmax: TMaxOf,
        hit_list: &FoundHits,
    ) -> bool;

    /// Counters since the kernel was created.
    fn counters(&self) -> T;
}

/// Limits of packets' rays.
#[derive(Clone, Copy)]
pub(crate) enum TMaxOf<'r> {
    /// One for all.
    All(f32),
    /// A row for each packet of a queue, from the first on.
    Each(&'r [[f32; LANES]]),
}

impl TMaxOf<'_> {
    /// Packet `index` of a queue, with the following ones if `L` holds several, and the lanes with
    /// rays.
    #[inline(always)]
    pub(super) fn packet<L: Lanes>(self, rays: &RayQueue, index: usize) -> (RayPacket<L>, L::Mask) {
        let (rays, active) = rays.packet(index, 0.0);
        let tmax = match self {
            TMaxOf::All(tmax) => L::splat(tmax),
            TMaxOf::Each(rows) => L::from_octets(|k| rows[(index + k).min(rows.len() - 1)]),
        };
        (RayPacket { tmax, ..rays }, active)
    }
}
