//! Queues in, hits out: the one place that chooses which kernel traces what.

use super::beam::{self, Beams};
use super::choice::Choices;
use super::coherence::{self, CLASSES, PARTED, SHADOWS, Starts};
use super::packet::PacketKernel;
use super::part::Part;
use super::single::Singles;
use super::tally::{Packets, Tally, Work};
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayQueue};
use crate::simd::{F32x8, F32x16, LANES, LaneMask, Lanes, NATIVE};
use std::ops::Range;

/// Traversal kernel of the packet engine. Every kernel gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// What pays for these rays, sixty-four packets at a time: beams for rays of one origin; for shadow rays packets or beams, and
    /// for others in a large tree packets or single rays, whatever was faster lately for rays that part as far; else packets;
    /// of sixteen where the build has AVX-512 and of eight where not. Figures stand in `perf/notes/coherence.md`, `perf/notes/beams.md`,
    /// `perf/notes/single-rays.md` and `perf/notes/packets-of-sixteen.md`.
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

    /// What pays for one frame of so many pixels. Making the wide tree takes as long as beams save with about four pixels for
    /// each primitive; so where [`Kernel::Auto`] would have to make it for less, it is packets.
    pub fn for_frame(self, bvh: &Bvh, pixels: u64) -> Kernel {
        let prims = bvh.triangles().len() + bvh.spheres().len();
        let pays = bvh.has_wide() || pixels >= PAYS * prims as u64;
        match self {
            Kernel::Auto if !pays => Kernel::packets(),
            kernel => kernel,
        }
    }

    /// Whether it goes down the wide tree.
    pub fn is_wide(self) -> bool {
        match self {
            Kernel::Auto | Kernel::Beam8 | Kernel::Beam16 | Kernel::Single => true,
            Kernel::Packet8 | Kernel::Packet16 => false,
        }
    }

    /// The packets that pay on this build.
    pub const fn packets() -> Kernel {
        if SIXTEEN {
            Kernel::Packet16
        } else {
            Kernel::Packet8
        }
    }

    /// Beams of them.
    const fn beams() -> Kernel {
        if SIXTEEN {
            Kernel::Beam16
        } else {
            Kernel::Beam8
        }
    }
}

/// Fewer packets of shadow rays are no beam. Where mirrors or silhouettes leave a few rays that start far from each other, a cell of
/// theirs sees half of the scene: up to ten thousand times what packets take (`perf/notes/whole-frames.md`).
const FEW: usize = beam::SIZE / 2;

/// Pixels for each primitive from which on a wide tree pays that is made for one frame (`perf/notes/whole-frames.md`).
const PAYS: u64 = 4;

/// Whether sixteen lanes pay on this build.
const SIXTEEN: bool = NATIVE > LANES;

/// Nodes of a wide tree from which on rays may go on their own. A smaller one stays in the nearest caches, and packets
/// are as fast.
const LARGE: usize = 512;

/// Of a batch, one packet in so many is looked at.
const STRIDE: usize = 4;

/// How much slower packets are believed to be than single rays, class by class, before the first trial: logarithms.
const USUAL: [f32; CLASSES] = [-0.8, -0.4, -0.1, 0.15, 0.25];

/// How much slower packets are believed to be than beams for shadow rays, before the first trial: a logarithm. Of seven scenes one
/// has the faster packets (`perf/notes/coherence.md`).
const BEAMS_USUAL: f32 = 0.1;

/// How many times as long a packet takes in a beam of 24, as trials have them, as in one of 64: shadow rays, 1.1 to 1.5 in seven
/// scenes (`perf/notes/sixteen-children.md`).
const PIECE: f32 = 1.2;

/// Traces queues of rays against one tree. Its functions are no generics, so that kernels are compiled here and nowhere else.
pub struct Traversal<'a>(Counted<'a>);

/// What is counted beside.
enum Counted<'a> {
    Packets(Kernels<'a, Packets>),
    Work(Kernels<'a, Work>),
}

impl<'a> Traversal<'a> {
    /// A traversal of a tree with one kernel. It counts packets, and nothing else.
    pub fn new(bvh: &'a Bvh, kernel: Kernel) -> Traversal<'a> {
        Traversal(Counted::Packets(Kernels::new(bvh, kernel)))
    }

    /// A traversal that counts every step.
    pub fn counting(bvh: &'a Bvh, kernel: Kernel) -> Traversal<'a> {
        Traversal(Counted::Work(Kernels::new(bvh, kernel)))
    }

    /// Counters since it was made.
    pub fn work(&self) -> Work {
        match &self.0 {
            Counted::Packets(kernels) => Work {
                packets: kernels.work().packets,
                ..Work::default()
            },
            Counted::Work(kernels) => kernels.work(),
        }
    }

    /// The closest hits of some packets of a queue, one [`HitPacket`] each.
    pub fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        match &mut self.0 {
            Counted::Packets(kernels) => kernels.closest(rays, packets, hits),
            Counted::Work(kernels) => kernels.closest(rays, packets, hits),
        }
    }

    /// Which lanes (as bits) of some packets of a queue meet anything before `tmax`, a byte a packet. Lanes without a ray do not.
    pub fn occluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        blocked: &mut [u8],
    ) {
        let first = packets.start;
        let answer = |packet: usize, seen: u8| {
            blocked[packet - first] = rays.active(packet).bits() as u8 & !seen;
        };
        match &mut self.0 {
            Counted::Packets(kernels) => kernels.unoccluded(rays, packets, tmax, answer),
            Counted::Work(kernels) => kernels.unoccluded(rays, packets, tmax, answer),
        }
    }
}

/// All kernels for one tree, counting by `T`.
struct Kernels<'a, T> {
    kernel: Kernel,
    eight: PacketKernel<'a, F32x8, T>,
    sixteen: PacketKernel<'a, F32x16, T>,
    beams: Beamers<'a, T>,
    singles: Option<Singles<'a, T>>,
    pairs: bool,
    /// Packets or single rays, for each class of rays: for the closest hit, and for any of rays that part; packets or beams, for
    /// shadow rays.
    alone: Choices<CLASSES>,
    parted: Choices<CLASSES>,
    shadows: Choices<SHADOWS>,
    starts: Starts,
}

/// Beams, or none.
enum Beamers<'a, T> {
    None,
    Eight(Box<Beams<'a, F32x8, T>>),
    Sixteen(Box<Beams<'a, F32x16, T>>),
}

impl<'a, T: Tally> Beamers<'a, T> {
    fn new(bvh: &'a Bvh, kernel: Kernel) -> Beamers<'a, T> {
        match kernel {
            Kernel::Auto => Beamers::new(bvh, Kernel::beams()),
            Kernel::Beam8 => Beamers::Eight(Box::new(Beams::new(bvh))),
            Kernel::Beam16 => Beamers::Sixteen(Box::new(Beams::new(bvh))),
            _ => Beamers::None,
        }
    }

    /// See [`Beams::closest`].
    fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) -> bool {
        match self {
            Beamers::None => false,
            Beamers::Eight(beams) => beams.closest(rays, packets, hits),
            Beamers::Sixteen(beams) => beams.closest(rays, packets, hits),
        }
    }

    /// See [`Beams::unoccluded`].
    fn unoccluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        answer: &mut impl FnMut(usize, u8),
    ) -> bool {
        match self {
            Beamers::None => false,
            Beamers::Eight(beams) => beams.unoccluded(rays, packets, tmax, answer),
            Beamers::Sixteen(beams) => beams.unoccluded(rays, packets, tmax, answer),
        }
    }

    fn work(&self) -> T {
        match self {
            Beamers::None => T::default(),
            Beamers::Eight(beams) => beams.work(),
            Beamers::Sixteen(beams) => beams.work(),
        }
    }
}

impl<'a, T: Tally> Kernels<'a, T> {
    fn new(bvh: &'a Bvh, kernel: Kernel) -> Kernels<'a, T> {
        let singles = match kernel {
            Kernel::Single => true,
            // Within instances, and against cones, a ray on its own is a packet of one.
            Kernel::Auto => bvh.wide().nodes().len() >= LARGE && bvh.wide().is_all_blocks(),
            _ => false,
        };
        let packets = match kernel {
            Kernel::Auto => Kernel::packets(),
            fixed => fixed,
        };
        Kernels {
            kernel,
            eight: PacketKernel::counting(bvh),
            sixteen: PacketKernel::counting(bvh),
            beams: Beamers::new(bvh, kernel),
            singles: singles.then(|| Singles::new(bvh)),
            pairs: matches!(packets, Kernel::Packet16 | Kernel::Beam16),
            // What is usual, until it is known.
            alone: Choices::new(USUAL),
            parted: Choices::new(USUAL),
            shadows: Choices::new([BEAMS_USUAL; SHADOWS]).apart(PIECE),
            starts: Starts::UNKNOWN,
        }
    }

    /// Counters since it was made.
    fn work(&self) -> T {
        let mut work = self.eight.work;
        work.add(&self.sixteen.work);
        work.add(&self.beams.work());
        if let Some(singles) = &self.singles {
            work.add(&singles.work());
        }
        work
    }

    /// The closest hits of some packets of a queue, one [`HitPacket`] each.
    fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        if let (Kernel::Single, Some(singles)) = (self.kernel, &mut self.singles) {
            // As many at once as there are: towards the end of a batch few are left to go side by side.
            return singles.closest(rays, &Part::all(packets), hits);
        }
        let batches = hits.chunks_mut(beam::SIZE);
        for (first, hits) in packets.step_by(beam::SIZE).zip(batches) {
            let batch = first..first + hits.len();
            if self.beams.closest(rays, batch.clone(), hits) {
                continue;
            }
            if self.singles.is_none() {
                self.closest_by_packet(rays, &Part::all(batch), hits);
                continue;
            }
            let class = coherence::class(rays, batch.clone(), STRIDE);
            let mut alone = self.alone;
            alone.trace(class, batch, Part::trial, |single, part| {
                self.closest_by(single, rays, part, hits)
            });
            self.alone = alone;
        }
    }

    /// As single rays or as packets; `hits` are those of the part's whole range.
    fn closest_by(&mut self, single: bool, rays: &RayQueue, part: &Part, hits: &mut [HitPacket]) {
        match &mut self.singles {
            Some(singles) if single => singles.closest(rays, part, hits),
            _ => self.closest_by_packet(rays, part, hits),
        }
    }

    fn closest_by_packet(&mut self, rays: &RayQueue, part: &Part, hits: &mut [HitPacket]) {
        let first = part.packets.start;
        let mut packets = part.each();
        while let Some(packet) = packets.next() {
            let k = packet - first;
            // Fours are whole, so that a pair is one.
            if self.pairs && packet + 1 < part.packets.end {
                closest(&mut self.sixteen, rays, packet, &mut hits[k..k + 2]);
                packets.next();
            } else {
                closest(&mut self.eight, rays, packet, &mut hits[k..k + 1]);
            }
        }
    }

    /// Tells `answer`, for some packets of a queue, which lanes (as bits) of each meet nothing before `tmax`.
    fn unoccluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        mut answer: impl FnMut(usize, u8),
    ) {
        if let (Kernel::Single, Some(singles)) = (self.kernel, &mut self.singles) {
            return singles.unoccluded(rays, packets, tmax, answer);
        }
        let end = packets.end;
        for first in packets.step_by(beam::SIZE) {
            let batch = first..end.min(first + beam::SIZE);
            if self.kernel != Kernel::Auto {
                self.unoccluded_by(true, rays, batch, tmax, &mut answer);
                continue;
            }
            // A rougher look: most of what comes here are shadow rays, which take little more than it does.
            let class = || coherence::class(rays, batch.clone(), 4 * STRIDE);
            let apart = self.singles.is_some().then(class);
            if let Some(class) = apart.filter(|&class| class >= PARTED) {
                let mut parted = self.parted;
                parted.trace(class, batch, Part::trial_in_pieces, |single, part| {
                    self.unoccluded_apart(single, rays, part.packets.clone(), tmax, &mut answer);
                });
                self.parted = parted;
                continue;
            }
            if batch.len() < FEW {
                self.unoccluded_by_packet(rays, batch, tmax, &mut answer);
                continue;
            }
            // Beams want rays that lie together.
            let class = self.starts.class(rays, batch.clone(), 2 * STRIDE);
            let mut shadows = self.shadows;
            shadows.trace(class, batch, Part::trial_in_pieces, |beam, part| {
                self.unoccluded_by(beam, rays, part.packets.clone(), tmax, &mut answer)
            });
            self.shadows = shadows;
        }
    }

    /// As a beam, if there are beams and the rays are one, or as packets.
    fn unoccluded_by(
        &mut self,
        beam: bool,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        answer: &mut impl FnMut(usize, u8),
    ) {
        let beams = &mut self.beams;
        if !(beam && beams.unoccluded(rays, packets.clone(), tmax, answer)) {
            self.unoccluded_by_packet(rays, packets, tmax, answer);
        }
    }

    /// As single rays or as packets.
    fn unoccluded_apart(
        &mut self,
        single: bool,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        answer: &mut impl FnMut(usize, u8),
    ) {
        match &mut self.singles {
            Some(singles) if single => singles.unoccluded(rays, packets, tmax, answer),
            _ => self.unoccluded_by_packet(rays, packets, tmax, answer),
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
    tracer: &mut PacketKernel<L, T>,
    rays: &RayQueue,
    packet: usize,
    hits: &mut [HitPacket],
) {
    let (rays, active) = rays.packet(packet, f32::INFINITY);
    let found = tracer.closest(&rays, active);
    for (k, hit) in hits.iter_mut().enumerate() {
        *hit = found.octet(k);
    }
}

fn unoccluded<L: Lanes, T: Tally>(
    tracer: &mut PacketKernel<L, T>,
    rays: &RayQueue,
    packet: usize,
    tmax: f32,
) -> u32 {
    let (rays, active) = rays.packet(packet, tmax);
    (active & !tracer.occluded(&rays, active)).bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bumpalo::Bump;
    use glam::Vec3;
    use phalanx_scene::Scene;

    /// Squares of two triangles that rise and fall, from −1 to 1.
    fn hills() -> Scene {
        const SIDE: u32 = 64;
        let mut scene = Scene::default();
        let corner = |x: u32, z: u32| {
            let [x, z] = [x, z].map(|k| 2.0 * k as f32 / SIDE as f32 - 1.0);
            Vec3::new(x, 0.1 * (x * x - z * z), z)
        };
        for (x, z) in (0..SIDE).flat_map(|x| (0..SIDE).map(move |z| (x, z))) {
            let [a, b] = [corner(x, z), corner(x + 1, z)];
            let [c, d] = [corner(x, z + 1), corner(x + 1, z + 1)];
            scene.add_triangle([a, b, c], None, 0);
            scene.add_triangle([b, d, c], None, 0);
        }
        scene
    }

    /// What mirrors leave of a wave: a few shadow rays, half of them at one end of the scene and half at the other. Together
    /// they would be one cell, which sees all that lies between.
    #[test]
    fn a_few_rays_from_far_apart_are_no_beam() {
        let bvh = Bvh::build(&hills());
        let light = Vec3::new(6000.0, 100.0, 5000.0);
        let arena = Bump::new();
        let mut rays = RayQueue::with_capacity(&arena, 16);
        for k in 0..16 {
            let side = if k < 8 { 0.9 } else { -0.9 };
            let org = Vec3::new(side, 0.02 + 0.001 * k as f32, -side);
            rays.push_ray(org.to_array(), (light - org).to_array());
        }
        let leaves = |kernel| {
            let mut traversal = Kernels::<Work>::new(&bvh, kernel);
            // Beams were far faster lately.
            traversal.shadows = Choices::new([4.0; SHADOWS]);
            traversal.unoccluded(&rays, 0..rays.packets(), 1.0, |_, _| ());
            traversal.work().leaf_visits
        };
        let [auto, beams, packets] = [Kernel::Auto, Kernel::Beam16, Kernel::Packet16].map(leaves);
        assert!(beams > 4 * packets, "{beams} of {packets}: this is no case");
        assert_eq!(auto, packets);
    }
}
