//! Rays of a wave in the form for its stages: slices of a queue, and the radiance of eight rays.

use phalanx_trace::packet::{HitPacket, RayPacket, RayQueue};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Mask8, Vec3x8};
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

/// Adds the radiance of some of eight lanes to the rays that they belong to.
#[inline]
pub(super) fn add_lanes(
    radiance: &mut [RadianceX8],
    lanes: Mask8,
    rays: &[u32; LANES],
    rgb: &[[f32; LANES]; 3],
) {
    let first = rays[0];
    let in_turn: [u32; LANES] = std::array::from_fn(|lane| first.wrapping_add(lane as u32));
    if first.is_multiple_of(LANES as u32) && *rays == in_turn {
        // Rays of one packet in their order.
        for (plane, own) in radiance[first as usize / LANES].0.iter_mut().zip(rgb) {
            let old = F32x8::new(*plane);
            *plane = lanes.select(old + F32x8::new(*own), old).to_array();
        }
        return;
    }
    for lane in lanes.lanes() {
        let ray = rays[lane] as usize;
        radiance[ray / LANES].add(ray % LANES, [rgb[0][lane], rgb[1][lane], rgb[2][lane]]);
    }
}

/// Some packets of a queue.
pub(crate) struct QueueSlice<'q, 'arena> {
    pub(crate) queue: &'q RayQueue<'arena>,
    pub(crate) packets: Range<usize>,
    /// Hits after which the rays begin, one row per packet of the queue; empty for rays that begin
    /// at their origins.
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
            let (packet, position) = (ray as usize / LANES, ray as usize % LANES);
            let one = self.queue.share(self.packets.start + packet, position);
            for (column, value) in rgb.iter_mut().zip(one) {
                column[lane] = value;
            }
        }
        let [x, y, z] = rgb.map(F32x8::new);
        Vec3x8::new(x, y, z)
    }
}
