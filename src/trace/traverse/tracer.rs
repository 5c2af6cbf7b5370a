//! Packets one by one, every step counted: for the cost of single rays, and for tests.

use super::packet::PacketKernel;
use super::tally::Work;
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{F32x8, F32x16, Lanes};

/// Traces packets against one tree. Owns the traversal stack, so that tracing allocates nothing.
pub struct Tracer<'a, L: PacketLanes = F32x8> {
    bvh: &'a Bvh,
    kernel: Kernel<'a, L>,
}

/// A kernel that counts.
pub struct Kernel<'a, L>(PacketKernel<'a, L, Work>);

/// Lanes that packets have. Its functions are no generics, so that what they are made of is compiled here and nowhere else.
pub trait PacketLanes: Lanes {
    /// See [`Tracer::closest`].
    fn closest(
        kernel: &mut Kernel<Self>,
        rays: &RayPacket<Self>,
        active: Self::Mask,
    ) -> HitPacket<Self>;
    /// See [`Tracer::occluded`].
    fn occluded(
        kernel: &mut Kernel<Self>,
        rays: &RayPacket<Self>,
        active: Self::Mask,
    ) -> Self::Mask;
}

impl PacketLanes for F32x8 {
    fn closest(kernel: &mut Kernel<F32x8>, rays: &RayPacket, active: Self::Mask) -> HitPacket {
        kernel.0.closest(rays, active)
    }

    fn occluded(kernel: &mut Kernel<F32x8>, rays: &RayPacket, active: Self::Mask) -> Self::Mask {
        kernel.0.occluded(rays, active)
    }
}

impl PacketLanes for F32x16 {
    fn closest(
        kernel: &mut Kernel<F32x16>,
        rays: &RayPacket<F32x16>,
        active: Self::Mask,
    ) -> HitPacket<F32x16> {
        kernel.0.closest(rays, active)
    }

    fn occluded(
        kernel: &mut Kernel<F32x16>,
        rays: &RayPacket<F32x16>,
        active: Self::Mask,
    ) -> Self::Mask {
        kernel.0.occluded(rays, active)
    }
}

impl<'a, L: PacketLanes> Tracer<'a, L> {
    /// A tracer for a tree.
    pub fn new(bvh: &'a Bvh) -> Tracer<'a, L> {
        let kernel = Kernel(PacketKernel::counting(bvh));
        Tracer { bvh, kernel }
    }

    /// The tree it traces.
    pub fn bvh(&self) -> &'a Bvh {
        self.bvh
    }

    /// The closest hit below `tmax` of each active lane; others come back as a miss.
    pub fn closest(&mut self, rays: &RayPacket<L>, active: L::Mask) -> HitPacket<L> {
        L::closest(&mut self.kernel, rays, active)
    }

    /// Which active lanes meet anything before `tmax`.
    pub fn occluded(&mut self, rays: &RayPacket<L>, active: L::Mask) -> L::Mask {
        L::occluded(&mut self.kernel, rays, active)
    }

    /// Takes what was counted since it was made, or since it was taken.
    pub fn take_work(&mut self) -> Work {
        std::mem::take(&mut self.kernel.0.work)
    }
}
