//! Tracing packet by packet with every step counted, for the cost of single rays and for tests.

use super::counters::TraversalStats;
use super::packet::PacketKernel;
use super::packet_lanes::{CountingKernel, LaneFunctions, PacketLanes};
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::F32x8;

/// Traces packets against one tree. It owns the traversal stack, so that tracing allocates nothing.
pub struct PacketTracer<'a, L: PacketLanes = F32x8> {
    bvh: &'a Bvh,
    kernel: CountingKernel<'a, L>,
    functions: LaneFunctions<L>,
}

impl<'a, L: PacketLanes> PacketTracer<'a, L> {
    /// A tracer for a tree.
    pub fn new(bvh: &'a Bvh) -> PacketTracer<'a, L> {
        PacketTracer {
            bvh,
            kernel: CountingKernel(PacketKernel::counting(bvh)),
            functions: L::functions(),
        }
    }

    /// The tree it traces.
    pub fn bvh(&self) -> &'a Bvh {
        self.bvh
    }

    /// The closest hit below `tmax` of each active lane; other lanes are returned as a miss.
    pub fn closest(&mut self, rays: &RayPacket<L>, active: L::Mask) -> HitPacket<L> {
        (self.functions.closest)(&mut self.kernel, rays, active)
    }

    /// Active lanes that hit anything before `tmax`.
    pub fn occluded(&mut self, rays: &RayPacket<L>, active: L::Mask) -> L::Mask {
        (self.functions.occluded)(&mut self.kernel, rays, active)
    }

    /// Takes the counts since the tracer was created, or since they were last taken.
    pub fn take_stats(&mut self) -> TraversalStats {
        std::mem::take(&mut self.kernel.0.counters)
    }
}
