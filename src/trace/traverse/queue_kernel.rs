//! The interface of kernels: a queue of rays in, hits or occlusion out, and counters of the work.

use super::batch_slice::BatchSlice;
use crate::packet::{HitPacket, RayQueue};
use std::ops::Range;

/// A kernel that traces packets of a queue, and counts by `T`. Rays that it cannot trace it leaves
/// to the packet kernel, which takes all.
pub(super) trait QueueKernel<T> {
    /// Finds the closest hits of the packets of a slice; `hits` has a row for every packet of the
    /// slice's range. Returns false, and does nothing, if the kernel cannot trace these rays.
    fn closest(&mut self, rays: &RayQueue, slice: &BatchSlice, hits: &mut [HitPacket]) -> bool;

    /// Sets `blocked`, a byte for each packet, to the lanes (as bits) that hit anything before
    /// `tmax`; lanes without a ray are not set. Returns false, and does nothing, if the kernel
    /// cannot trace these rays.
    fn occluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        blocked: &mut [u8],
    ) -> bool;

    /// Counters since the kernel was made.
    fn counters(&self) -> T;
}
