//! Rays of a wave as its stages take them: slices of a queue, and the radiance of eight rays.

use phalanx_trace::packet::{HitPacket, RayPacket, RayQueue};
use phalanx_trace::simd::{F32x8, LANES, Mask8, Vec3x8};
use std::ops::Range;

/// Radiance of eight rays.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct RadianceX8(pub(crate) [[f32; LANES]; 3]);

impl RadianceX8 {
    pub(crate) const BLACK: RadianceX8 = RadianceX8([[0.0; LANES]; 3]);

    /// Lower four lanes and upper four lanes of each plane.
    pub(crate) fn plane_halves(&self) -> [[&[f32; LANES / 2]; 2]; 3] {
        self.0.each_ref().map(|plane| match plane.as_chunks().0 {
            [lower, upper] => [lower, upper],
            _ => unreachable!("eight lanes are two times four"),
        })
    }

    pub(crate) fn lane(&self, lane: usize) -> [f32; 3] {
        [self.0[0][lane], self.0[1][lane], self.0[2][lane]]
    }

    pub(super) fn set(&mut self, lane: usize, rgb: [f32; 3]) {
        for (plane, value) in self.0.iter_mut().zip(rgb) {
            plane[lane] = value;
        }
    }

    pub(super) fn add(&mut self, lane: usize, rgb: [f32; 3]) {
        for (plane, value) in self.0.iter_mut().zip(rgb) {
            plane[lane] += value;
        }
    }
}

/// Some packets of a queue.
pub(crate) struct QueueSlice<'q, 'arena> {
    pub(crate) queue: &'q RayQueue<'arena>,
    pub(crate) packets: Range<usize>,
    /// Hits after which the rays begin, a row for each packet of the queue; empty for rays that
    /// begin at their origins.
    pub(crate) after: &'q [HitPacket],
}

impl QueueSlice<'_, '_> {
    pub(super) fn packet(&self, index: usize) -> (RayPacket, Mask8) {
        self.queue.packet(self.packets.start + index, f32::INFINITY)
    }

    pub(super) fn active(&self, index: usize) -> Mask8 {
        self.queue.active(self.packets.start + index)
    }

    /// Seeds of some rays of the wave.
    pub(super) fn seeds(&self, rays: &[u32; LANES]) -> [u32; LANES] {
        rays.map(|ray| {
            let (packet, lane) = (ray as usize / LANES, ray as usize % LANES);
            self.queue.seed(self.packets.start + packet, lane)
        })
    }

    /// Shares of some rays of the wave.
    pub(super) fn shares(&self, rays: &[u32; LANES]) -> Vec3x8 {
        let mut rgb = [[0.0; LANES]; 3];
        for (lane, &ray) in rays.iter().enumerate() {
            let (packet, at) = (ray as usize / LANES, ray as usize % LANES);
            let one = self.queue.share(self.packets.start + packet, at);
            for (column, value) in rgb.iter_mut().zip(one) {
                column[lane] = value;
            }
        }
        let [x, y, z] = rgb.map(F32x8::new);
        Vec3x8::new(x, y, z)
    }
}
