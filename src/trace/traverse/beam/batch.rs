//! The packets of a beam, from a queue, prepared for tests.

use crate::intersect::aabb::RaySlabs;
use crate::intersect::ray_setup::RaySetup;
use crate::intersect::shear::Shear;
use crate::packet::RayPacket;
use crate::prefetch::prefetch;
use crate::simd::{LANES, LaneMask, Lanes};
use crate::traverse::queue_kernel::QueuePackets;

/// Packets of eight in a beam. More packets share more nodes, but use more cache.
pub(crate) const SIZE: usize = 64;

/// The rays of a packet, with the data of triangle tests.
pub(super) struct BeamGroup<L: Lanes> {
    pub(super) rays: RayPacket<L>,
    pub(super) shear: Shear<L>,
}

impl<L: Lanes> BeamGroup<L> {
    /// The data of box tests.
    #[inline(always)]
    pub(super) fn slabs(&self) -> RaySlabs<L> {
        RaySlabs::new(self.rays.org, self.rays.dir, L::Mask::splat(true))
    }

    /// The data of all of a packet's tests.
    pub(super) fn prepared(&self, slabs: &RaySlabs<L>) -> RaySetup<L> {
        RaySetup {
            rays: self.rays,
            slabs: *slabs,
            shear: self.shear,
        }
    }
}

/// The packets of a beam.
impl QueuePackets<'_, '_> {
    pub(super) fn groups<L: Lanes>(&self) -> usize {
        self.packets.len().div_ceil(L::PACKETS)
    }

    /// Prefetches the rays after these. A beam needs all its rays at once, with no other work to
    /// overlap the fetch.
    pub(super) fn fetch_next(&self) {
        let slots = self.rays.slots();
        let end = self.packets.end;
        for packet in end..slots.len().min(end + self.packets.len()) {
            prefetch(slots, packet as u32);
        }
    }

    /// The k-th group; prefetches that of the next beam.
    #[inline(always)]
    pub(super) fn group_and_next<L: Lanes>(&self, k: usize) -> (RayPacket<L>, L::Mask) {
        let slots = self.rays.slots();
        for j in 0..L::PACKETS {
            let packet = self.packets.end + k * L::PACKETS + j;
            prefetch(slots, packet as u32);
        }
        self.group(k)
    }

    /// Index in the queue of the j-th packet of the k-th group. For camera rays, the packet after
    /// the next lies below and not beside: two packets of 4×2 pixels make a square.
    #[inline(always)]
    pub(super) fn packet<L: Lanes>(&self, k: usize, j: usize) -> usize {
        let (packet, complete) = (k * L::PACKETS + j, self.packets.len() & !3);
        let transposed = L::PACKETS == 2 && packet < complete;
        let index = if transposed {
            packet & !3 | (packet & 1) << 1 | (packet >> 1 & 1)
        } else {
            packet
        };
        self.packets.start + index
    }

    /// The k-th group, and the lanes that carry rays.
    #[inline(always)]
    pub(super) fn group<L: Lanes>(&self, k: usize) -> (RayPacket<L>, L::Mask) {
        let rays = self.rays.packets_at(|j| self.packet::<L>(k, j), self.tmax);
        (rays, self.active::<L>(k))
    }

    #[inline(always)]
    pub(super) fn active<L: Lanes>(&self, k: usize) -> L::Mask {
        let mut lanes = 0;
        for j in 0..L::PACKETS {
            let packet = self.packet::<L>(k, j);
            if packet < self.packets.end {
                lanes |= self.rays.active(packet).bits() << (j * LANES);
            }
        }
        L::Mask::from_bits(lanes)
    }

    /// Approximate direction of a beam's rays: the sum of one ray of every eighth packet.
    pub(super) fn toward(&self) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for packet in self.packets.clone().step_by(8) {
            let (_, dir) = self.rays.ray(packet, 0);
            for (sum, d) in sum.iter_mut().zip(dir) {
                *sum += d;
            }
        }
        sum
    }
}
