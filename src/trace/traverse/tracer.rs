//! Tracing packet by packet with every step counted, for the cost of single rays and for tests; and
//! microbenchmarks. Functions over packets of one width are compiled in this crate.

use super::counters::TraversalStats;
use super::microbench;
use super::packet::PacketKernel;
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{F32x8, F32x16, Lanes};
use phalanx_scene::PrimKind;

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

/// Lane types of packets.
pub trait PacketLanes: Lanes {
    /// The functions of this width. They are reached by address, so that they are compiled only
    /// here.
    fn functions() -> LaneFunctions<Self>;
}

impl PacketLanes for F32x8 {
    #[inline(never)]
    fn functions() -> LaneFunctions<F32x8> {
        LaneFunctions::all()
    }
}

impl PacketLanes for F32x16 {
    #[inline(never)]
    fn functions() -> LaneFunctions<F32x16> {
        LaneFunctions::all()
    }
}

/// A kernel that counts.
pub struct CountingKernel<'a, L>(PacketKernel<'a, L, TraversalStats>);

type CountedQuery<L, R> = fn(&mut CountingKernel<L>, &RayPacket<L>, <L as Lanes>::Mask) -> R;
type BoxTest<L> = fn(&[RayPacket<L>], &[[[f32; 3]; 2]]) -> u64;
type PrimTest<L, R> = fn(&Bvh, PrimKind, &[RayPacket<L>], &mut [R]);

/// The functions of one width.
#[derive(Clone, Copy)]
pub struct LaneFunctions<L: Lanes> {
    closest: CountedQuery<L, HitPacket<L>>,
    occluded: CountedQuery<L, L::Mask>,
    /// Microbenchmark of boxes: the number of pairs of a ray and a box that intersect before the
    /// ray's `tmax`.
    pub test_boxes: BoxTest<L>,
    /// Microbenchmark of the closest hits on all primitives of a kind, a packet for each of the
    /// rays.
    pub test_closest: PrimTest<L, HitPacket<L>>,
    /// Microbenchmark of occlusion by any primitive of a kind: lanes as bits, a word for each
    /// packet.
    pub test_occluded: PrimTest<L, u32>,
}

impl<L: Lanes> LaneFunctions<L> {
    fn all() -> LaneFunctions<L> {
        LaneFunctions {
            closest: |kernel, rays, active| kernel.0.call_closest(rays, active),
            occluded: |kernel, rays, active| kernel.0.call_occluded(rays, active),
            test_boxes: microbench::boxes,
            test_closest: microbench::closest,
            test_occluded: microbench::occluded,
        }
    }
}
