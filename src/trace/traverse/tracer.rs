//! Tracing packet by packet with every step counted, for the cost of single rays and for tests.

use super::counters::TraversalStats;
use super::packet::PacketKernel;
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{F32x8, F32x16, Lanes};

/// Traces packets against one tree. It owns the traversal stack, so that tracing allocates nothing.
pub struct PacketTracer<'a, L: PacketLanes = F32x8> {
    bvh: &'a Bvh,
    kernel: CountingKernel<'a, L>,
}

/// A kernel that counts.
pub struct CountingKernel<'a, L>(PacketKernel<'a, L, TraversalStats>);

/// Lane types of packets. The functions are not generic, so that the kernels are compiled only
/// here.
pub trait PacketLanes: Lanes {
    /// Closest hits: see [`PacketTracer::closest`].
    fn closest(
        kernel: &mut CountingKernel<Self>,
        rays: &RayPacket<Self>,
        active: Self::Mask,
    ) -> HitPacket<Self>;
    /// Occlusion: see [`PacketTracer::occluded`].
    fn occluded(
        kernel: &mut CountingKernel<Self>,
        rays: &RayPacket<Self>,
        active: Self::Mask,
    ) -> Self::Mask;
}

impl PacketLanes for F32x8 {
    fn closest(
        kernel: &mut CountingKernel<F32x8>,
        rays: &RayPacket,
        active: Self::Mask,
    ) -> HitPacket {
        kernel.0.call_closest(rays, active)
    }

    fn occluded(
        kernel: &mut CountingKernel<F32x8>,
        rays: &RayPacket,
        active: Self::Mask,
    ) -> Self::Mask {
        kernel.0.call_occluded(rays, active)
    }
}

impl PacketLanes for F32x16 {
    fn closest(
        kernel: &mut CountingKernel<F32x16>,
        rays: &RayPacket<F32x16>,
        active: Self::Mask,
    ) -> HitPacket<F32x16> {
        kernel.0.call_closest(rays, active)
    }

    fn occluded(
        kernel: &mut CountingKernel<F32x16>,
        rays: &RayPacket<F32x16>,
        active: Self::Mask,
    ) -> Self::Mask {
        kernel.0.call_occluded(rays, active)
    }
}

impl<'a, L: PacketLanes> PacketTracer<'a, L> {
    /// A tracer for a tree.
    pub fn new(bvh: &'a Bvh) -> PacketTracer<'a, L> {
        let kernel = CountingKernel(PacketKernel::counting(bvh));
        PacketTracer { bvh, kernel }
    }

    /// The tree it traces.
    pub fn bvh(&self) -> &'a Bvh {
        self.bvh
    }

    /// The closest hit below `tmax` of each active lane; other lanes are returned as a miss.
    pub fn closest(&mut self, rays: &RayPacket<L>, active: L::Mask) -> HitPacket<L> {
        L::closest(&mut self.kernel, rays, active)
    }

    /// Active lanes that hit anything before `tmax`.
    pub fn occluded(&mut self, rays: &RayPacket<L>, active: L::Mask) -> L::Mask {
        L::occluded(&mut self.kernel, rays, active)
    }

    /// Takes the counts since the tracer was created, or since they were last taken.
    pub fn take_stats(&mut self) -> TraversalStats {
        std::mem::take(&mut self.kernel.0.counters)
    }
}
