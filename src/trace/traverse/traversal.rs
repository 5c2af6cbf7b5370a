//! Queues in, hits out: the one place that chooses the kernel for each batch.

use super::batch_slice::BatchSlice;
use super::beam::{Beams, SIZE};
use super::coherence::{self, DIVERGENCE_CLASSES, FIRST_DIVERGENT, OriginSpread, SPREAD_CLASSES};
use super::cost_tuner::{COST_CLASSES, CostTuner};
use super::counters::{Counters, PacketCount, TraversalStats};
use super::every_hit::{FoundHit, FoundHits};
use super::kernel::Kernel;
use super::kernel_tuner::{KernelTuner, PerClassTuner};
use super::next_hit::HitsByLane;
use super::packet_pairs::PacketPairs;
use super::queue_kernel::{QueueKernel, QueuePackets, TMaxOf};
use super::single_ray::SingleRays;
use crate::bvh::Bvh;
use crate::packet::{HitPacket, RayPacket, RayQueue};
use crate::simd::{F32x8, F32x16, Mask8};
use std::cell::RefCell;
use std::ops::Range;

/// Least packets of shadow rays for a beam. If mirrors or silhouettes leave a few rays that start
/// far from each other, their sub-beam covers half of the scene, and takes up to ten thousand times
/// as long as packets (`perf/notes/whole-frames.md`).
const MIN_BEAM_PACKETS: usize = SIZE / 2;

/// Least nodes of a wide tree for single rays. In a smaller tree there is next to nothing to
/// visit, and packets are as fast.
const MIN_SINGLE_NODES: usize = 8;

/// Interval of the sampled packets of a batch.
const SAMPLE_STRIDE: usize = 4;

/// Initial estimate of the time of packets relative to single rays, class by class, before the
/// first trial: natural logarithms.
const INITIAL_LOG_RATIO: [f32; DIVERGENCE_CLASSES] = [-0.8, -0.4, -0.1, 0.15, 0.25];

/// Time of packets relative to single rays for any hit of rays that have parted, by class of cost:
/// natural logarithms, the means of thirteen scenes (`perf/notes/coherence.md`). The tuner measures
/// by how much a scene differs from them.
const ANY_HIT_LOG_RATIO_BY_COST: [f32; COST_CLASSES] =
    [-0.85, -0.85, -0.8, -0.6, -0.3, 0.0, 0.3, 0.5, 0.65];

/// Time of packets relative to beams for shadow rays, by class of cost: of the same scenes.
const BEAM_LOG_RATIO_BY_COST: [f32; COST_CLASSES] =
    [-1.15, -1.0, -0.65, -0.3, 0.05, 0.1, 0.0, -0.2, -0.3];

/// Initial estimate of the time of packets relative to beams for rays that start in one point,
/// before the first trial: a logarithm. Packets are faster in few scenes: of large walls and tiny
/// things, where beams end at many leaves (`perf/notes/coherence.md`).
const INITIAL_CAMERA_LOG_RATIO: f32 = 0.5;

/// Slowdown per packet of a 24-packet trial beam relative to a full 64-packet beam: for shadow
/// rays, 1.1 to 1.5 in seven scenes (`perf/notes/sixteen-children.md`).
const TRIAL_BEAM_PENALTY: f32 = 1.2;

/// Traces queues of rays against one tree. Its functions are not generic, so that kernels are
/// compiled only here.
pub struct Traversal<'a>(Kernels<'a, PacketCount>);

/// A traversal that counts every step. It finds closest hits and occlusion alone.
#[cfg(feature = "counters")]
pub struct CountingTraversal<'a>(Kernels<'a, TraversalStats>);

#[cfg(feature = "counters")]
impl<'a> CountingTraversal<'a> {
    /// A traversal of a tree with one kernel.
    pub fn new(bvh: &'a Bvh, kernel: Kernel) -> CountingTraversal<'a> {
        CountingTraversal(Kernels::new(bvh, kernel))
    }

    /// Counters since the traversal was made.
    pub fn stats(&self) -> TraversalStats {
        self.0.stats()
    }

    /// The closest hits: see [`Traversal::closest`].
    pub fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        self.0.closest(rays, packets, hits);
    }

    /// Occlusion: see [`Traversal::occluded`].
    pub fn occluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        blocked: &mut [u8],
    ) {
        self.0.occluded(rays, packets, tmax, blocked);
    }
}

impl<'a> Traversal<'a> {
    /// A traversal of a tree with one kernel. It counts only packets.
    pub fn new(bvh: &'a Bvh, kernel: Kernel) -> Traversal<'a> {
        Traversal(Kernels::new(bvh, kernel))
    }

    /// Counters since the traversal was made.
    pub fn stats(&self) -> TraversalStats {
        self.0.stats()
    }

    /// The closest hits of some packets of a queue, one [`HitPacket`] each.
    pub fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        self.0.closest(rays, packets, hits);
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
        self.0.occluded(rays, packets, tmax, blocked);
    }

    /// The next hits of eight rays after `after`, by (t, prim_id), before their `tmax`. Lanes that
    /// are not active are returned as a miss.
    pub fn next(&mut self, rays: &RayPacket, active: Mask8, after: &HitPacket) -> HitPacket {
        self.0.packets.eight.next(rays, active, after)
    }

    /// Adds the hits of eight rays after `after`, before their `tmax`, to their lists in no order:
    /// `most` at least where there are as many, and all before the last of them.
    pub(super) fn next_hits(
        &mut self,
        rays: &RayPacket,
        active: Mask8,
        after: &HitPacket,
        most: usize,
        hits: &mut HitsByLane,
    ) {
        let shared = RefCell::new(std::mem::take(hits));
        let packets = &mut self.0.packets.eight;
        packets.next_hits(rays, active, after, most, &shared);
        *hits = shared.into_inner();
    }

    /// Adds everything that the rays of a queue hit before their limits to `hit_list`, in no order.
    pub(crate) fn every_hit(
        &mut self,
        rays: &RayQueue,
        tmax: TMaxOf,
        hit_list: &mut Vec<FoundHit>,
    ) {
        let shared = FoundHits::new(std::mem::take(hit_list));
        self.0.every_hit(rays, tmax, &shared);
        *hit_list = shared.into_inner();
    }

    /// The packet kernel, which alone takes a limit for each ray.
    pub(crate) fn packets(&mut self) -> &mut PacketPairs<'a, PacketCount> {
        &mut self.0.packets
    }
}

/// The kernels that one [`Kernel`] uses, counting by `T`.
struct Kernels<'a, T> {
    kernel: Kernel,
    packets: PacketPairs<'a, T>,
    beams: Option<Box<dyn QueueKernel<T> + Send + 'a>>,
    /// Single rays, or packets of eight: see [`divergent_kernel`].
    divergent: Option<Box<dyn QueueKernel<T> + Send + 'a>>,
    /// Tuners of packets and the divergent kernel: for the closest hit, by how far rays part, and
    /// for any hit of divergent rays, by what they cost. The third tunes packets and beams, for
    /// shadow rays, by where they start and what they cost.
    closest_tuner: PerClassTuner<DIVERGENCE_CLASSES>,
    every_hit_tuner: PerClassTuner<DIVERGENCE_CLASSES>,
    any_hit_tuner: CostTuner<1>,
    shadow_tuner: CostTuner<SPREAD_CLASSES>,
    /// Tuner of packets and beams, for rays that start in one point.
    camera_tuner: KernelTuner,
    origin_spread: OriginSpread,
}

/// The beam kernel of a [`Kernel`], if it has one.
fn beam_kernel<'a, T: Counters + Send + 'a>(
    bvh: &'a Bvh,
    kernel: Kernel,
) -> Option<Box<dyn QueueKernel<T> + Send + 'a>> {
    match kernel {
        Kernel::Auto => beam_kernel(bvh, Kernel::beams()),
        Kernel::Beam8 => Some(Box::new(Beams::<F32x8, T>::new(bvh))),
        Kernel::Beam16 => Some(Box::new(Beams::<F32x16, T>::new(bvh))),
        Kernel::Packet8 | Kernel::Packet16 | Kernel::Single => None,
    }
}

/// The kernel for rays that have parted of a [`Kernel`], if it has one: single rays, or packets
/// of eight within instances, where a single ray is a packet of one.
fn divergent_kernel<'a, T: Counters + Send + 'a>(
    bvh: &'a Bvh,
    kernel: Kernel,
) -> Option<Box<dyn QueueKernel<T> + Send + 'a>> {
    match kernel {
        Kernel::Single => Some(Box::new(SingleRays::new(bvh))),
        Kernel::Auto if !bvh.leaf_prims().instances.is_empty() => {
            let wider = Kernel::packets() == Kernel::Packet16;
            wider.then(|| Box::new(PacketPairs::new(bvh, false)) as Box<_>)
        }
        Kernel::Auto => {
            let large = bvh.wide().nodes().len() >= MIN_SINGLE_NODES;
            large.then(|| Box::new(SingleRays::new(bvh)) as Box<_>)
        }
        Kernel::Packet8 | Kernel::Packet16 | Kernel::Beam8 | Kernel::Beam16 => None,
    }
}

/// A tuner for shadow rays, with an initial estimate of what a scene adds to those by cost.
fn shadow_tuner(log_ratio: f32) -> CostTuner<SPREAD_CLASSES> {
    CostTuner::new(log_ratio, TRIAL_BEAM_PENALTY, BEAM_LOG_RATIO_BY_COST, false)
}

impl<'a, T: Counters + Send + 'a> Kernels<'a, T> {
    fn new(bvh: &'a Bvh, kernel: Kernel) -> Kernels<'a, T> {
        let packets = match kernel {
            Kernel::Auto => Kernel::packets(),
            fixed => fixed,
        };
        Kernels {
            kernel,
            packets: PacketPairs::new(bvh, matches!(packets, Kernel::Packet16 | Kernel::Beam16)),
            beams: beam_kernel(bvh, kernel),
            divergent: divergent_kernel(bvh, kernel),
            // The initial estimates, until there are measurements.
            closest_tuner: PerClassTuner::new(INITIAL_LOG_RATIO, 1.0),
            every_hit_tuner: PerClassTuner::new(INITIAL_LOG_RATIO, 1.0),
            any_hit_tuner: CostTuner::new(0.0, 1.0, ANY_HIT_LOG_RATIO_BY_COST, true),
            shadow_tuner: shadow_tuner(0.0),
            camera_tuner: KernelTuner::new(INITIAL_CAMERA_LOG_RATIO, TRIAL_BEAM_PENALTY),
            origin_spread: OriginSpread::UNKNOWN,
        }
    }

    /// Occlusion of one batch by the kernel that was fastest lately for rays like these.
    fn occluded_by_fastest(&mut self, batch: QueuePackets, blocked: &mut [u8]) {
        let (rays, all) = (batch.rays, &batch.packets);
        let first = all.start;
        let part = |slice: &BatchSlice| QueuePackets {
            packets: slice.packets.clone(),
            ..batch
        };
        let places = |slice: &BatchSlice| slice.packets.start - first..slice.packets.end - first;
        // A sparser sample: most rays here are shadow rays, whose tracing takes little more than
        // the sampling.
        let stride = 4 * SAMPLE_STRIDE;
        if let Some(divergent) = &mut self.divergent
            && coherence::divergence_class(rays, all.clone(), stride) >= FIRST_DIVERGENT
        {
            let (packets, tuner) = (&mut self.packets, &mut self.any_hit_tuner);
            tuner.trace(0, all.clone(), |second, slice| {
                let blocked = &mut blocked[places(slice)];
                if second {
                    divergent.occluded(part(slice), blocked)
                } else {
                    packets.occluded(part(slice), blocked)
                };
            });
            return;
        }
        if all.len() < MIN_BEAM_PACKETS {
            self.packets.occluded(batch, blocked);
            return;
        }
        // Beams need rays that lie together.
        let spread = &mut self.origin_spread;
        let spread = spread.spread_class(rays, all.clone(), 2 * SAMPLE_STRIDE);
        let mut tuner = self.shadow_tuner;
        tuner.trace(spread, all.clone(), |beam, slice| {
            self.occluded_by_beam(beam, part(slice), &mut blocked[places(slice)]);
        });
        self.shadow_tuner = tuner;
    }

    /// The closest hits of one batch as a beam, if there are beams and the rays start in one
    /// point. Returns false, and does nothing, if not. Where packets have been faster lately,
    /// packets trace them.
    fn closest_by_beam(
        &mut self,
        rays: &RayQueue,
        all: &BatchSlice,
        hits: &mut [HitPacket],
    ) -> bool {
        let Some(beams) = &mut self.beams else {
            return false;
        };
        if self.kernel != Kernel::Auto {
            return beams.closest(rays, all, hits);
        }
        if !coherence::start_in_one_point(rays, all.packets.clone()) {
            return false;
        }
        let (packets, first) = (&mut self.packets, all.packets.start);
        let parts = BatchSlice::trial_in_pieces;
        (self.camera_tuner).trace(0.0, all.packets.clone(), parts, |beam, slice| {
            let places = slice.packets.start - first..slice.packets.end - first;
            let hits = &mut hits[places];
            if !(beam && beams.closest(rays, slice, hits)) {
                packets.closest(rays, slice, hits);
            }
        });
        true
    }

    /// Traces rays as a beam, if there are beams and the rays share a point, or else as packets.
    fn occluded_by_beam(&mut self, beam: bool, batch: QueuePackets, blocked: &mut [u8]) {
        if let (true, Some(beams)) = (beam, &mut self.beams)
            && beams.occluded(batch.clone(), blocked)
        {
            return;
        }
        self.packets.occluded(batch, blocked);
    }

    fn closest(&mut self, rays: &RayQueue, packets: Range<usize>, hits: &mut [HitPacket]) {
        if let (Kernel::Single, Some(divergent)) = (self.kernel, &mut self.divergent) {
            // As many rays at once as there are: towards the end of a batch few are left to trace
            // side by side.
            divergent.closest(rays, &BatchSlice::all(packets), hits);
            return;
        }
        for (first, hits) in packets.step_by(SIZE).zip(hits.chunks_mut(SIZE)) {
            let batch = first..first + hits.len();
            let all = BatchSlice::all(batch.clone());
            if self.closest_by_beam(rays, &all, hits) {
                continue;
            }
            let packets = &mut self.packets;
            let Some(divergent) = &mut self.divergent else {
                packets.closest(rays, &all, hits);
                continue;
            };
            let class = coherence::divergence_class(rays, batch.clone(), SAMPLE_STRIDE);
            let tuner = &mut self.closest_tuner;
            tuner.trace(class, 0.0, batch, BatchSlice::trial, |second, slice| {
                if second {
                    divergent.closest(rays, slice, hits)
                } else {
                    packets.closest(rays, slice, hits)
                };
            });
        }
    }

    fn occluded(&mut self, rays: &RayQueue, packets: Range<usize>, tmax: f32, blocked: &mut [u8]) {
        let batch = |packets| QueuePackets {
            rays,
            packets,
            tmax,
        };
        if let (Kernel::Single, Some(divergent)) = (self.kernel, &mut self.divergent) {
            divergent.occluded(batch(packets), blocked);
            return;
        }
        for (first, blocked) in packets.step_by(SIZE).zip(blocked.chunks_mut(SIZE)) {
            let batch = batch(first..first + blocked.len());
            if self.kernel == Kernel::Auto {
                self.occluded_by_fastest(batch, blocked);
            } else {
                self.occluded_by_beam(true, batch, blocked);
            }
        }
    }

    fn every_hit(&mut self, rays: &RayQueue, tmax: TMaxOf, hit_list: &FoundHits) {
        let all = 0..rays.packets();
        for first in all.clone().step_by(SIZE) {
            let batch = first..(first + SIZE).min(all.end);
            let packets = &mut self.packets;
            let (Some(divergent), TMaxOf::All(_)) = (&mut self.divergent, tmax) else {
                packets.every_hit(rays, &BatchSlice::all(batch), tmax, hit_list);
                continue;
            };
            let class = coherence::divergence_class(rays, batch.clone(), SAMPLE_STRIDE);
            let tuner = &mut self.every_hit_tuner;
            tuner.trace(class, 0.0, batch, BatchSlice::trial, |second, slice| {
                if second {
                    divergent.every_hit(rays, slice, tmax, hit_list)
                } else {
                    packets.every_hit(rays, slice, tmax, hit_list)
                };
            });
        }
    }

    fn stats(&self) -> TraversalStats {
        let mut work = self.packets.counters();
        for kernel in [&self.beams, &self.divergent].into_iter().flatten() {
            work.add(&kernel.counters());
        }
        work.stats()
    }
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
            traversal.shadow_tuner = shadow_tuner(4.0);
            let blocked = &mut [0; 2];
            traversal.occluded(&rays, 0..rays.packets(), 1.0, blocked);
            traversal.stats().leaf_visits
        };
        let [auto, beams, packets] = [Kernel::Auto, Kernel::Beam16, Kernel::Packet16].map(leaves);
        assert!(beams > 4 * packets, "{beams} of {packets}: this is no case");
        assert_eq!(auto, packets);
    }
}
