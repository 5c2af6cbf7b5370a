//! Queues in, hits out: the one place that chooses which kernel traces what.

use super::beam::{self, Beams};
use super::packet::Tracer;
use super::single::Singles;
use super::tally::{Packets, Tally};
use crate::bvh::Bvh;
use crate::lanes::{F32x8, F32x16, LANES, LaneMask, Lanes};
use crate::packet::{HitPacket, RayQueue};
use std::ops::Range;

/// Traversal kernel of the packet engine. Every kernel gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// What pays on this build for these rays: beams where they share a point, else packets, of sixteen where the build has
    /// AVX-512 and of eight where not; see `perf/notes/beams.md` and `perf/notes/packets-of-sixteen.md`.
    Auto,
    /// Packets of eight rays against the binary tree.
    Packet8,
    /// Two packets side by side against the binary tree.
    Packet16,
    /// Beams against the wide tree, in cells of up to eight rays; [`Kernel::Packet8`] for rays that share no point.
    Beam8,
    /// Beams against the wide tree, in cells of up to sixteen rays; [`Kernel::Packet16`] for rays that share no point.
    Beam16,
    /// Rays on their own against the wide tree.
    Single,
}

impl Kernel {
    /// Every kernel by name, `auto` first.
    pub const ALL: [(&'static str, Kernel); 6] = [
        ("auto", Kernel::Auto),
        ("packet8", Kernel::Packet8),
        ("packet16", Kernel::Packet16),
        ("beam8", Kernel::Beam8),
        ("beam16", Kernel::Beam16),
        ("single", Kernel::Single),
    ];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        let known = Kernel::ALL.iter().find(|(_, kernel)| *kernel == self);
        known.map_or("", |(name, _)| name)
    }

    /// The kernel that this one is on this build: for [`Kernel::Auto`] another one.
    pub fn resolved(self) -> Kernel {
        match self {
            Kernel::Auto if cfg!(target_feature = "avx512f") => Kernel::Beam16,
            Kernel::Auto => Kernel::Beam8,
            fixed => fixed,
        }
    }
}

/// Traces queues of rays against one tree, and counts by `T`.
pub struct Traversal<'a, T = Packets> {
    eight: Tracer<'a, F32x8, T>,
    sixteen: Tracer<'a, F32x16, T>,
    beams: Beamers<'a, T>,
    singles: Option<Singles<'a, T>>,
    pairs: bool,
}

/// Beams, or none.
enum Beamers<'a, T> {
    None,
    Eight(Box<Beams<'a, F32x8, T>>),
    Sixteen(Box<Beams<'a, F32x16, T>>),
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
        let kernel = kernel.resolved();
        Traversal {
            eight: Tracer::counting(bvh),
            sixteen: Tracer::counting(bvh),
            beams: match kernel {
                Kernel::Beam8 => Beamers::Eight(Box::new(Beams::new(bvh))),
                Kernel::Beam16 => Beamers::Sixteen(Box::new(Beams::new(bvh))),
                _ => Beamers::None,
            },
            singles: (kernel == Kernel::Single).then(|| Singles::new(bvh)),
            pairs: matches!(kernel, Kernel::Packet16 | Kernel::Beam16),
        }
    }

    /// Counters since it was made.
    pub fn work(&self) -> T {
        let mut work = self.eight.work;
        work.add(&self.sixteen.work);
        match &self.beams {
            Beamers::None => {}
            Beamers::Eight(beams) => work.add(&beams.work()),
            Beamers::Sixteen(beams) => work.add(&beams.work()),
        }
        if let Some(singles) = &self.singles {
            work.add(&singles.work());
        }
        work
    }

    /// The closest hits of some packets of a queue, one [`HitPacket`] each.
    pub fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        if let Some(singles) = &mut self.singles {
            return singles.closest(rays, packets, hits);
        }
        let batches = hits.chunks_mut(beam::SIZE);
        for (first, hits) in packets.step_by(beam::SIZE).zip(batches) {
            let batch = first..first + hits.len();
            let done = match &mut self.beams {
                Beamers::None => false,
                Beamers::Eight(beams) => beams.closest(rays, batch, hits),
                Beamers::Sixteen(beams) => beams.closest(rays, batch, hits),
            };
            if !done {
                self.closest_by_packet(rays, first, hits);
            }
        }
    }

    fn closest_by_packet(&mut self, rays: &RayQueue, first: usize, hits: &mut [HitPacket]) {
        let mut k = 0;
        while self.pairs && k + 1 < hits.len() {
            closest(&mut self.sixteen, rays, first + k, &mut hits[k..k + 2]);
            k += 2;
        }
        for k in k..hits.len() {
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
        if let Some(singles) = &mut self.singles {
            return singles.unoccluded(rays, packets, tmax, answer);
        }
        let end = packets.end;
        for first in packets.step_by(beam::SIZE) {
            let batch = first..end.min(first + beam::SIZE);
            let done = match &mut self.beams {
                Beamers::None => false,
                Beamers::Eight(beams) => {
                    beams.unoccluded(rays, batch.clone(), tmax, &mut answer)
                }
                Beamers::Sixteen(beams) => {
                    beams.unoccluded(rays, batch.clone(), tmax, &mut answer)
                }
            };
            if !done {
                self.unoccluded_by_packet(rays, batch, tmax, &mut answer);
            }
        }
    }

    fn unoccluded_by_packet(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        answer: &mut impl FnMut(usize, u8),
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
