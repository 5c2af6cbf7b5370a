//! Queues in, hits out: the one place that chooses the kernel for each batch.

use super::batch_slice::BatchSlice;
use super::beam::{self, Beams};
use super::coherence::{self, DIVERGENCE_CLASSES, FIRST_DIVERGENT, OriginSpread, SPREAD_CLASSES};
use super::counters::{Counters, PacketCount, TraversalStats};
use super::kernel_tuner::PerClassTuner;
use super::packet::PacketKernel;
use super::single_ray::SingleRays;
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayQueue};
use crate::simd::{F32x8, F32x16, LANES, LaneMask, Lanes, NATIVE};
use std::ops::Range;

/// Traversal kernel of the packet engine. Every kernel gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The fastest known kernel for these rays, sixty-four packets at a time. Rays of one origin go
    /// as beams. Shadow rays go as packets or beams, and other rays in a large tree as packets or
    /// single rays, whichever was faster lately for rays of that divergence. All else goes as
    /// packets. Packets are of sixteen if the build has AVX-512, else of eight. Figures stand in
    /// `perf/notes/coherence.md`, `perf/notes/beams.md`, `perf/notes/single-rays.md` and
    /// `perf/notes/packets-of-sixteen.md`.
    Auto,
    /// Packets of eight rays against the binary tree.
    Packet8,
    /// Two packets side by side against the binary tree.
    Packet16,
    /// Beams against the wide tree, in sub-beams of up to eight rays; [`Kernel::Packet8`] for rays
    /// that share no point.
    Beam8,
    /// Beams against the wide tree, in sub-beams of up to sixteen rays; [`Kernel::Packet16`] for
    /// rays that share no point.
    Beam16,
    /// Single rays against the wide tree.
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

    /// The kernel's name on the command line.
    pub fn name(self) -> &'static str {
        let known = Kernel::ALL.iter().find(|(_, kernel)| *kernel == self);
        known.map_or("", |(name, _)| name)
    }

    /// The kernel that pays for one frame of the given number of pixels. Making the wide tree takes
    /// as long as beams save with about four pixels for each primitive. So if [`Kernel::Auto`]
    /// would have to make it for less, packets are used.
    pub fn for_frame(self, bvh: &Bvh, pixels: u64) -> Kernel {
        let prims = bvh.triangles().len() + bvh.spheres().len();
        let pays = bvh.has_wide() || pixels >= MIN_PIXELS_PER_PRIM * prims as u64;
        match self {
            Kernel::Auto if !pays => Kernel::packets(),
            kernel => kernel,
        }
    }

    /// Returns true if the kernel traverses the wide tree.
    pub fn is_wide(self) -> bool {
        match self {
            Kernel::Auto | Kernel::Beam8 | Kernel::Beam16 | Kernel::Single => true,
            Kernel::Packet8 | Kernel::Packet16 => false,
        }
    }

    /// The packet kernel that pays on this build.
    pub const fn packets() -> Kernel {
        if SIXTEEN {
            Kernel::Packet16
        } else {
            Kernel::Packet8
        }
    }

    /// The beam kernel of those packets.
    const fn beams() -> Kernel {
        if SIXTEEN {
            Kernel::Beam16
        } else {
            Kernel::Beam8
        }
    }
}

/// Least packets of shadow rays for a beam. If mirrors or silhouettes leave a few rays that start
/// far from each other, their sub-beam covers half of the scene, and takes up to ten thousand times
/// as long as packets (`perf/notes/whole-frames.md`).
const MIN_BEAM_PACKETS: usize = beam::SIZE / 2;

/// Least pixels for each primitive for which a wide tree pays that is made for one frame
/// (`perf/notes/whole-frames.md`).
const MIN_PIXELS_PER_PRIM: u64 = 4;

/// True if sixteen lanes pay on this build.
pub(super) const SIXTEEN: bool = NATIVE > LANES;

/// Least nodes of a wide tree for single rays. A smaller tree stays in the nearest caches, and
/// packets are as fast.
const MIN_SINGLE_NODES: usize = 512;

/// Interval of the sampled packets of a batch.
const SAMPLE_STRIDE: usize = 4;

/// Initial estimate of the time of packets relative to single rays, class by class, before the
/// first trial: natural logarithms.
const INITIAL_LOG_RATIO: [f32; DIVERGENCE_CLASSES] = [-0.8, -0.4, -0.1, 0.15, 0.25];

/// Initial estimate of the time of packets relative to beams for shadow rays, before the first
/// trial: a logarithm. In one scene of seven, packets are faster (`perf/notes/coherence.md`).
const INITIAL_BEAM_LOG_RATIO: f32 = 0.1;

/// Slowdown per packet of a 24-packet trial beam relative to a full 64-packet beam: for shadow
/// rays, 1.1 to 1.5 in seven scenes (`perf/notes/sixteen-children.md`).
const TRIAL_BEAM_PENALTY: f32 = 1.2;

/// Traces queues of rays against one tree. Its functions are not generic, so that kernels are
/// compiled only here.
pub struct Traversal<'a>(Counted<'a>);

/// Kernels by the counter that they use.
enum Counted<'a> {
    Packets(Kernels<'a, PacketCount>),
    Stats(Kernels<'a, TraversalStats>),
}

impl<'a> Traversal<'a> {
    /// A traversal of a tree with one kernel. It counts only packets.
    pub fn new(bvh: &'a Bvh, kernel: Kernel) -> Traversal<'a> {
        Traversal(Counted::Packets(Kernels::new(bvh, kernel)))
    }

    /// A traversal that counts every step.
    pub fn counting(bvh: &'a Bvh, kernel: Kernel) -> Traversal<'a> {
        Traversal(Counted::Stats(Kernels::new(bvh, kernel)))
    }

    /// Counters since the traversal was made.
    pub fn stats(&self) -> TraversalStats {
        match &self.0 {
            Counted::Packets(kernels) => TraversalStats {
                packets: kernels.counters().packets,
                ..TraversalStats::default()
            },
            Counted::Stats(kernels) => kernels.counters(),
        }
    }

    /// The closest hits of some packets of a queue, one [`HitPacket`] each.
    pub fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        match &mut self.0 {
            Counted::Packets(kernels) => kernels.closest(rays, packets, hits),
            Counted::Stats(kernels) => kernels.closest(rays, packets, hits),
        }
    }

    /// Sets `blocked` for some packets of a queue to the lanes (as bits) that hit anything before
    /// `tmax`, a byte a packet. Lanes without a ray are not set.
    pub fn occluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        blocked: &mut [u8],
    ) {
        let (first, last) = (packets.start, packets.end.saturating_sub(1));
        let answer = |packet: usize, seen: u8| blocked[packet - first] = !seen;
        match &mut self.0 {
            Counted::Packets(kernels) => kernels.unoccluded(rays, packets, tmax, answer),
            Counted::Stats(kernels) => kernels.unoccluded(rays, packets, tmax, answer),
        }
        // All packets of a queue but its last are full.
        if let Some(blocked) = blocked.get_mut(last.wrapping_sub(first)) {
            *blocked &= rays.active(last).bits() as u8;
        }
    }
}

/// All kernels for one tree, counting by `T`.
struct Kernels<'a, T> {
    kernel: Kernel,
    eight: PacketKernel<'a, F32x8, T>,
    sixteen: PacketKernel<'a, F32x16, T>,
    beams: BeamKernel<'a, T>,
    singles: Option<SingleRays<'a, T>>,
    pairs: bool,
    /// Tuners of packets and single rays, for each class of rays: for the closest hit, and for any
    /// hit of divergent rays. The third tunes packets and beams, for shadow rays.
    closest_tuner: PerClassTuner<DIVERGENCE_CLASSES>,
    any_hit_tuner: PerClassTuner<DIVERGENCE_CLASSES>,
    shadow_tuner: PerClassTuner<SPREAD_CLASSES>,
    origin_spread: OriginSpread,
}

/// Beam kernel, or none.
enum BeamKernel<'a, T> {
    None,
    Eight(Box<Beams<'a, F32x8, T>>),
    Sixteen(Box<Beams<'a, F32x16, T>>),
}

impl<'a, T: Counters> BeamKernel<'a, T> {
    fn new(bvh: &'a Bvh, kernel: Kernel) -> BeamKernel<'a, T> {
        match kernel {
            Kernel::Auto => BeamKernel::new(bvh, Kernel::beams()),
            Kernel::Beam8 => BeamKernel::Eight(Box::new(Beams::new(bvh))),
            Kernel::Beam16 => BeamKernel::Sixteen(Box::new(Beams::new(bvh))),
            _ => BeamKernel::None,
        }
    }

    /// Closest hits: see [`Beams::closest`].
    fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) -> bool {
        match self {
            BeamKernel::None => false,
            BeamKernel::Eight(beams) => beams.closest(rays, packets, hits),
            BeamKernel::Sixteen(beams) => beams.closest(rays, packets, hits),
        }
    }

    /// Lanes without a hit: see [`Beams::unoccluded`].
    fn unoccluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        answer: &mut impl FnMut(usize, u8),
    ) -> bool {
        match self {
            BeamKernel::None => false,
            BeamKernel::Eight(beams) => beams.unoccluded(rays, packets, tmax, answer),
            BeamKernel::Sixteen(beams) => beams.unoccluded(rays, packets, tmax, answer),
        }
    }

    fn counters(&self) -> T {
        match self {
            BeamKernel::None => T::default(),
            BeamKernel::Eight(beams) => beams.counters(),
            BeamKernel::Sixteen(beams) => beams.counters(),
        }
    }
}

impl<'a, T: Counters> Kernels<'a, T> {
    fn new(bvh: &'a Bvh, kernel: Kernel) -> Kernels<'a, T> {
        let singles = match kernel {
            Kernel::Single => true,
            // Within instances, and against cones, a single ray is a packet of one.
            Kernel::Auto => {
                bvh.wide().nodes().len() >= MIN_SINGLE_NODES && bvh.wide().is_all_blocks()
            }
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
            beams: BeamKernel::new(bvh, kernel),
            singles: singles.then(|| SingleRays::new(bvh)),
            pairs: matches!(packets, Kernel::Packet16 | Kernel::Beam16),
            // The initial estimates, until there are measurements.
            closest_tuner: PerClassTuner::new(INITIAL_LOG_RATIO),
            any_hit_tuner: PerClassTuner::new(INITIAL_LOG_RATIO),
            shadow_tuner: PerClassTuner::new([INITIAL_BEAM_LOG_RATIO; SPREAD_CLASSES])
                .with_trial_penalty(TRIAL_BEAM_PENALTY),
            origin_spread: OriginSpread::UNKNOWN,
        }
    }

    /// Counters since the kernels were made.
    fn counters(&self) -> T {
        let mut work = self.eight.counters;
        work.add(&self.sixteen.counters);
        work.add(&self.beams.counters());
        if let Some(singles) = &self.singles {
            work.add(&singles.counters());
        }
        work
    }

    /// The closest hits of some packets of a queue, one [`HitPacket`] each.
    fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        if let (Kernel::Single, Some(singles)) = (self.kernel, &mut self.singles) {
            // As many rays at once as there are: towards the end of a batch few are left to trace
            // side by side.
            return singles.closest(rays, &BatchSlice::all(packets), hits);
        }
        let batches = hits.chunks_mut(beam::SIZE);
        for (first, hits) in packets.step_by(beam::SIZE).zip(batches) {
            let batch = first..first + hits.len();
            if self.beams.closest(rays, batch.clone(), hits) {
                continue;
            }
            if self.singles.is_none() {
                self.closest_by_packet(rays, &BatchSlice::all(batch), hits);
                continue;
            }
            let class = coherence::divergence_class(rays, batch.clone(), SAMPLE_STRIDE);
            let mut tuner = self.closest_tuner;
            tuner.trace(class, batch, BatchSlice::trial, |single, part| {
                self.closest_by(single, rays, part, hits)
            });
            self.closest_tuner = tuner;
        }
    }

    /// The closest hits by single rays or by packets; `hits` are those of the part's whole range.
    fn closest_by(
        &mut self,
        single: bool,
        rays: &RayQueue,
        part: &BatchSlice,
        hits: &mut [HitPacket],
    ) {
        match &mut self.singles {
            Some(singles) if single => singles.closest(rays, part, hits),
            _ => self.closest_by_packet(rays, part, hits),
        }
    }

    fn closest_by_packet(&mut self, rays: &RayQueue, part: &BatchSlice, hits: &mut [HitPacket]) {
        let first = part.packets.start;
        let mut packets = part.each();
        while let Some(packet) = packets.next() {
            let k = packet - first;
            // Fours are complete, so that a pair is two consecutive packets.
            if self.pairs && packet + 1 < part.packets.end {
                closest(&mut self.sixteen, rays, packet, &mut hits[k..k + 2]);
                packets.next();
            } else {
                closest(&mut self.eight, rays, packet, &mut hits[k..k + 1]);
            }
        }
    }

    /// Passes `answer`, for some packets of a queue, the lanes (as bits) of each that hit nothing
    /// before `tmax`.
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
            // A sparser sample: most rays here are shadow rays, whose tracing takes little more
            // than the sampling.
            let class = || coherence::divergence_class(rays, batch.clone(), 4 * SAMPLE_STRIDE);
            let apart = self.singles.is_some().then(class);
            if let Some(class) = apart.filter(|&class| class >= FIRST_DIVERGENT) {
                let mut tuner = self.any_hit_tuner;
                tuner.trace(class, batch, BatchSlice::trial_in_pieces, |single, part| {
                    self.unoccluded_apart(single, rays, part.packets.clone(), tmax, &mut answer);
                });
                self.any_hit_tuner = tuner;
                continue;
            }
            if batch.len() < MIN_BEAM_PACKETS {
                self.unoccluded_by_packet(rays, batch, tmax, &mut answer);
                continue;
            }
            // Beams need rays that lie together.
            let class = self
                .origin_spread
                .spread_class(rays, batch.clone(), 2 * SAMPLE_STRIDE);
            let mut shadows = self.shadow_tuner;
            shadows.trace(class, batch, BatchSlice::trial_in_pieces, |beam, part| {
                self.unoccluded_by(beam, rays, part.packets.clone(), tmax, &mut answer)
            });
            self.shadow_tuner = shadows;
        }
    }

    /// Traces rays as a beam, if there are beams and the rays share a point, or else as packets.
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

    /// Traces rays as single rays or as packets.
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

#[inline(never)]
fn closest<L: Lanes, T: Counters>(
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

#[inline(never)]
fn unoccluded<L: Lanes, T: Counters>(
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

    /// A scene of squares of two triangles that rise and fall, from −1 to 1.
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

    /// Checks a few shadow rays as mirrors leave them, half of them at one end of the scene and
    /// half at the other. Together they would be one sub-beam, which covers all that lies between.
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
            let mut traversal = Kernels::<TraversalStats>::new(&bvh, kernel);
            // Beams were far faster lately.
            traversal.shadow_tuner = PerClassTuner::new([4.0; SPREAD_CLASSES]);
            traversal.unoccluded(&rays, 0..rays.packets(), 1.0, |_, _| ());
            traversal.counters().leaf_visits
        };
        let [auto, beams, packets] = [Kernel::Auto, Kernel::Beam16, Kernel::Packet16].map(leaves);
        assert!(beams > 4 * packets, "{beams} of {packets}: this is no case");
        assert_eq!(auto, packets);
    }
}
