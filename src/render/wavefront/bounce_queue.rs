//! Bounces waiting to be traced, and their accumulation into the wave that sent them.

use super::ray_batch::{RadianceX8, add_lanes};
use phalanx_trace::packet::{HitPacket, QueueColumns, QueueStorage, RayQueue};
use phalanx_trace::simd::F32x8;
use std::ops::Range;

/// Level of the stack of waves: one wave's radiance, and the bounces of its hits.
#[derive(Default)]
pub(super) struct BounceLevel {
    /// Radiance of the wave's rays. The radiance of camera rays is stored elsewhere.
    pub(super) radiance: Vec<RadianceX8>,
    pub(super) waiting: WaitingRays,
    /// Bounces and passes between the camera and the wave.
    pub(super) depth: u32,
    pub(super) passed: u32,
}

/// The secondary rays of a wave's hits that wait to be traced.
#[derive(Default)]
pub(super) struct WaitingRays {
    /// Mirror and refracted rays.
    pub(super) bounces: BounceQueue,
    /// Rays that continue through partly transparent surfaces. They are traced last.
    pub(super) passes: BounceQueue,
    /// True if the slice that is being traced is one of `passes`.
    pub(super) passing: bool,
}

impl WaitingRays {
    /// Advances to the next slice, of up to `most` packets. Returns false if there is none.
    pub(super) fn advance(&mut self, most: usize) -> bool {
        self.passing = !self.bounces.advance(most);
        !self.passing || self.passes.advance(most)
    }

    /// The slice being traced.
    pub(super) fn slice(&mut self) -> BounceSlice<'_> {
        if self.passing { self.passes.slice() } else { self.bounces.slice() }
    }
}

/// The queues that a wave fills: one for bounces and one for passes, each if any are allowed.
pub(super) struct SecondaryQueues<'q> {
    pub(super) bounces: Option<&'q mut BounceQueue>,
    pub(super) passes: Option<&'q mut BounceQueue>,
}

/// The bounces of a wave, mirror rays first.
#[derive(Default)]
pub(super) struct BounceQueue {
    storage: QueueStorage,
    /// Hits after which passing rays continue, one row per packet; empty for bounces, which begin
    /// at their origins.
    after: Vec<HitPacket>,
    /// Number of mirror rays.
    mirrored: usize,
    /// Packets of the wave that sent the bounces.
    wave_packets: usize,
    /// Packets that are being traced; all packets before them are done.
    slice: Range<usize>,
}

impl BounceQueue {
    /// Removes all bounces.
    pub(super) fn clear(&mut self) {
        self.storage.clear();
        self.slice = 0..0;
    }

    /// Fills the queue with the bounces of a wave of `wave` packets, with room for `ways` bounces
    /// of each ray. `push` queues them, and returns how many are mirror rays.
    pub(super) fn fill(
        &mut self,
        wave: usize,
        ways: usize,
        columns: QueueColumns,
        push: impl FnOnce(&mut RayQueue) -> usize,
    ) {
        self.mirrored = self.storage.fill(wave * ways, columns, push);
        self.wave_packets = wave;
        self.slice = 0..0;
    }

    /// Fills the queue with rays of a wave of `wave` packets that continue after hits. `push`
    /// queues them, and sets the hits, a row for each packet of the queue.
    pub(super) fn fill_after(
        &mut self,
        wave: usize,
        columns: QueueColumns,
        push: impl FnOnce(&mut RayQueue, &mut [HitPacket]),
    ) {
        self.after.resize(wave, HitPacket::miss());
        let after = &mut self.after;
        self.storage.fill(wave, columns, |queue| push(queue, after));
        self.wave_packets = wave;
        self.slice = 0..0;
    }

    /// Advances to the next slice of the queue, of up to `most` packets. Returns false if there is
    /// none.
    pub(super) fn advance(&mut self, most: usize) -> bool {
        let (first, all) = (self.slice.end, self.storage.queue().packets());
        let end = all.min(first + self.wave_packets.min(most));
        self.slice = first..end;
        first < all
    }

    /// The slice being traced.
    pub(super) fn slice(&mut self) -> BounceSlice<'_> {
        BounceSlice {
            queue: self.storage.queue(),
            after: &self.after,
            packets: self.slice.clone(),
            mirrored: self.mirrored,
        }
    }
}

/// Some packets of the bounces of a wave. The parents of its rays are the wave's rays.
pub(super) struct BounceSlice<'q> {
    pub(super) queue: RayQueue<'q>,
    /// Hits after which the rays continue; empty for bounces.
    pub(super) after: &'q [HitPacket],
    pub(super) packets: Range<usize>,
    /// Number of mirror rays in the queue; they come first.
    pub(super) mirrored: usize,
}

/// Adds the weighted radiance of bounces to the hits that sent them.
pub(super) fn accumulate(
    bounces: &BounceSlice,
    bounced: &[RadianceX8],
    radiance: &mut [RadianceX8],
) {
    for (packet, bounced) in bounces.packets.clone().zip(bounced) {
        let active = bounces.queue.active(packet);
        let (weight, parent) = bounces.queue.payload(packet);
        let mut rgb = bounced.0;
        for (plane, weight) in rgb.iter_mut().zip(weight) {
            *plane = (F32x8::new(*weight) * F32x8::new(*plane)).to_array();
        }
        add_lanes(radiance, active, parent, &rgb);
    }
}
