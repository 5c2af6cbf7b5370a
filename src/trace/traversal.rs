//! Queues in, hits out: the one place that chooses which kernel traces what.

use super::packet::Tracer;
use super::tally::{Packets, Tally};
use crate::bvh::Bvh;
use crate::lanes::{F32x8, F32x16, LANES, LaneMask, Lanes};
use crate::packet::{HitPacket, RayQueue};
use std::ops::Range;

/// Traversal kernel of the packet engine. Every kernel gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// What pays on this build: [`Kernel::Packet16`] where it has AVX-512, else [`Kernel::Packet8`]; see
    /// `perf/notes/packets-of-sixteen.md`.
    Auto,
    /// Packets of eight rays against the binary tree.
    Packet8,
    /// Two packets side by side against the binary tree.
    Packet16,
}

impl Kernel {
    /// Every kernel by name, `auto` first.
    pub const ALL: [(&'static str, Kernel); 3] = [
        ("auto", Kernel::Auto),
        ("packet8", Kernel::Packet8),
        ("packet16", Kernel::Packet16),
    ];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        let known = Kernel::ALL.iter().find(|(_, kernel)| *kernel == self);
        known.map_or("", |(name, _)| name)
    }

    /// The kernel that this one is on this build: for [`Kernel::Auto`] another one.
    pub fn resolved(self) -> Kernel {
        match self {
            Kernel::Auto if cfg!(target_feature = "avx512f") => Kernel::Packet16,
            Kernel::Auto => Kernel::Packet8,
            fixed => fixed,
        }
    }
}

/// Traces queues of rays against one tree, and counts by `T`.
pub struct Traversal<'a, T = Packets> {
    eight: Tracer<'a, F32x8, T>,
    sixteen: Tracer<'a, F32x16, T>,
    pairs: bool,
}

impl<'a> Traversal<'a> {
    /// A traversal of a tree with one kernel.
    pub fn new(bvh: &'a Bvh, kernel: Kernel) -> Traversal<'a> {
        Traversal::counting(bvh, kernel)
    }
}

impl<'a, T: Tally> Traversal<'a, T> {
    /// A traversal that counts what `T` counts.
    pub fn counting(bvh: &'a Bvh, kernel: Kernel) -> Traversal<'a, T> {
        Traversal {
            eight: Tracer::counting(bvh),
            sixteen: Tracer::counting(bvh),
            pairs: kernel.resolved() == Kernel::Packet16,
        }
    }

    /// Counters since it was made.
    pub fn work(&self) -> T {
        let mut work = self.eight.work;
        work.add(&self.sixteen.work);
        work
    }

    /// The closest hits of some packets of a queue, one [`HitPacket`] each.
    pub fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        let (first, mut k) = (packets.start, 0);
        while self.pairs && k + 1 < packets.len() {
            closest(&mut self.sixteen, rays, first + k, &mut hits[k..k + 2]);
            k += 2;
        }
        for k in k..packets.len() {
            closest(&mut self.eight, rays, first + k, &mut hits[k..k + 1]);
        }
    }

    /// Tells `answer`, for some packets of a queue, which lanes (as bits) of each meet nothing before `tmax`.
    pub fn unoccluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        mut answer: impl FnMut(usize, u8),
    ) {
        let mut k = packets.start;
        while self.pairs && k + 1 < packets.end {
            let seen = unoccluded(&mut self.sixteen, rays, k, tmax);
            answer(k, seen as u8);
            answer(k + 1, (seen >> LANES) as u8);
            k += 2;
        }
        for k in k..packets.end {
            answer(k, unoccluded(&mut self.eight, rays, k, tmax) as u8);
        }
    }
}

fn closest<L: Lanes, T: Tally>(
    tracer: &mut Tracer<L, T>,
    rays: &RayQueue,
    packet: usize,
    hits: &mut [HitPacket],
) {
    let (rays, active) = rays.packet(packet, f32::INFINITY);
    let found = tracer.closest(&rays, active);
    for (k, hit) in hits.iter_mut().enumerate() {
        *hit = found.eight(k);
    }
}

fn unoccluded<L: Lanes, T: Tally>(
    tracer: &mut Tracer<L, T>,
    rays: &RayQueue,
    packet: usize,
    tmax: f32,
) -> u32 {
    let (rays, active) = rays.packet(packet, tmax);
    (active & !tracer.occluded(&rays, active)).bits()
}
