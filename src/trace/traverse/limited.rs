//! Packets whose rays each have a limit of their own, and packets of one ray.
//!
//! [`Traversal`](super::Traversal) takes one limit for all rays of a call, because its beams and
//! single rays do. Packets keep the limit in lanes anyway, so that here each ray brings its own;
//! the kernels are the same, compiled once, and so are the bits.

use super::counters::PacketCount;
use super::packet::PacketKernel;
use super::traversal::SIXTEEN;
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayPacket, RayQueue};
use crate::simd::{F32x8, F32x16, LANES, LaneMask, Lanes, Mask8, Vec3x8};

/// Traces packets of a queue with a limit for each ray.
pub(crate) struct LimitedRays<'a> {
    eight: PacketKernel<'a, F32x8, PacketCount>,
    sixteen: PacketKernel<'a, F32x16, PacketCount>,
}

impl<'a> LimitedRays<'a> {
    pub(crate) fn new(bvh: &'a Bvh) -> LimitedRays<'a> {
        LimitedRays {
            eight: PacketKernel::counting(bvh),
            sixteen: PacketKernel::counting(bvh),
        }
    }

    /// The closest hits below the limits, one row of `tmax` and of `hits` for each packet.
    pub(crate) fn closest(
        &mut self,
        rays: &RayQueue,
        tmax: &[[f32; LANES]],
        hits: &mut [HitPacket],
    ) {
        for k in packet_starts(tmax.len()) {
            if SIXTEEN && k + 1 < tmax.len() {
                let (rays, active) = limited(rays, tmax, k);
                let found = self.sixteen.call_closest(&rays, active);
                [hits[k], hits[k + 1]] = [0, 1].map(|octet| found.octet(octet));
            } else {
                let (rays, active) = limited(rays, tmax, k);
                hits[k] = self.eight.call_closest(&rays, active);
            }
        }
    }

    /// Which lanes (as bits) meet anything before their limits, one row for each packet.
    pub(crate) fn occluded(&mut self, rays: &RayQueue, tmax: &[[f32; LANES]], blocked: &mut [u8]) {
        for k in packet_starts(tmax.len()) {
            if SIXTEEN && k + 1 < tmax.len() {
                let (rays, active) = limited(rays, tmax, k);
                let bits = self.sixteen.call_occluded(&rays, active).bits();
                (blocked[k], blocked[k + 1]) = (bits as u8, (bits >> LANES) as u8);
            } else {
                let (rays, active) = limited(rays, tmax, k);
                blocked[k] = self.eight.call_occluded(&rays, active).bits() as u8;
            }
        }
    }
}

/// Every packet, or the first of every pair.
fn packet_starts(packets: usize) -> impl Iterator<Item = usize> {
    (0..packets).step_by(if SIXTEEN { 2 } else { 1 })
}

/// Packet `index` of a queue (and the one after it) with limits of its own.
#[inline(always)]
fn limited<L: Lanes>(
    rays: &RayQueue,
    tmax: &[[f32; LANES]],
    index: usize,
) -> (RayPacket<L>, L::Mask) {
    let (rays, active) = rays.packet(index, 0.0);
    let last = tmax.len() - 1;
    let tmax = L::from_octets(|k| tmax[(index + k).min(last)]);
    (RayPacket { tmax, ..rays }, active)
}

/// The closest hit of one ray below `tmax`, in lane 0.
pub(crate) fn closest_one(bvh: &Bvh, org: [f32; 3], dir: [f32; 3], tmax: f32) -> HitPacket {
    let (rays, active) = packet_of_one(org, dir, tmax);
    PacketKernel::<F32x8, PacketCount>::counting(bvh).call_closest(&rays, active)
}

/// Returns true if one ray hits anything before `tmax`.
pub(crate) fn occluded_one(bvh: &Bvh, org: [f32; 3], dir: [f32; 3], tmax: f32) -> bool {
    let (rays, active) = packet_of_one(org, dir, tmax);
    let mut kernel = PacketKernel::<F32x8, PacketCount>::counting(bvh);
    kernel.call_occluded(&rays, active).any()
}

fn packet_of_one(org: [f32; 3], dir: [f32; 3], tmax: f32) -> (RayPacket, Mask8) {
    let rays = RayPacket {
        org: Vec3x8::splat(org[0], org[1], org[2]),
        dir: Vec3x8::splat(dir[0], dir[1], dir[2]),
        tmax: F32x8::splat(tmax),
    };
    (rays, Mask8::first(1))
}
