//! Beams: hundreds of rays that share a point, the eye or a light, together down the wide tree.
//!
//! What belongs to such rays is a point and a rectangle in projective coordinates, and so is what belongs to boxes and
//! triangles: a node's eight children are seen from the apex once for all rays, then each against all cells, a lane being a
//! cell of up to sixteen rays; a leaf's eight triangles are seen once, then against each cell, a lane being a triangle.
//! Only what is left is tested ray by ray, by the same test that every kernel has.
//!
//! The idea is that of beam and frustum tracing (Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm", 2005;
//! Wald et al., "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies", 2007), with hundreds of rays
//! where they have a packet, and with a mask of cells on the stack instead of a first active ray.
//!
//! | file | what |
//! |---|---|
//! | `apex` | whether rays share a point |
//! | `frame` | boxes and triangles seen from it, and why nothing is lost |
//! | `cells` | the rays, in rectangles |
//! | `descend` | cells down the tree |

mod apex;
mod cells;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod descend;
mod frame;

use super::goal::{AnyHit, Closest, Goal, Prepared, nowhere};
use super::packet::Tracer;
use super::tally::{Packets, Tally};
use crate::bvh::{Bvh, Wide};
use crate::lanes::{F32x8, LANES, LaneMask, Lanes};
use crate::packet::{HitPacket, RayPacket, RayQueue};
use apex::Apex;
use cells::{CELLS, Cells, projected};
use descend::Stack;
use frame::Frame;
use std::ops::Range;

/// Packets of eight that go as one beam. More share more of the nodes, and less of the caches (`perf/notes/beams.md`).
pub(super) const SIZE: usize = 64;

const _: () = assert!(SIZE <= CELLS, "a cell for every packet, at least");

/// Traces rays as beams where they share a point, as packets where they do not, and counts by `T`.
pub(super) struct Beams<'a, L: Lanes = F32x8, T = Packets> {
    wide: &'a Wide,
    extent: f32,
    packets: Tracer<'a, L, T>,
    cells: Box<Cells>,
    /// Packets of the beam, ready for tests.
    groups: Vec<Prepared<L>>,
    /// Where they go.
    projected: Vec<[L; 3]>,
    closest: Vec<Closest<L>>,
    any: Vec<AnyHit<L>>,
    stack: Stack,
    work: T,
}

/// The packets of a beam, of a queue.
struct Batch<'q, 'a> {
    rays: &'q RayQueue<'a>,
    packets: Range<usize>,
    tmax: f32,
}

impl Batch<'_, '_> {
    fn groups<L: Lanes>(&self) -> usize {
        self.packets.len().div_ceil(L::PACKETS)
    }

    /// The k-th packet of as many lanes as `L` has.
    #[inline(always)]
    fn group<L: Lanes>(&self, k: usize) -> (RayPacket<L>, L::Mask) {
        let first = self.packets.start + k * L::PACKETS;
        (self.rays.packet::<L>(first, self.tmax).0, self.active::<L>(k))
    }

    /// Which of its lanes carry rays of this beam.
    #[inline(always)]
    fn active<L: Lanes>(&self, k: usize) -> L::Mask {
        let first = (self.packets.start + k * L::PACKETS) * LANES;
        let end = self.rays.len().min(self.packets.end * LANES);
        L::Mask::first((end - first).min(L::PACKETS * LANES))
    }
}

impl<'a, L: Lanes, T: Tally> Beams<'a, L, T> {
    pub(super) fn new(bvh: &'a Bvh) -> Beams<'a, L, T> {
        let wide = bvh.wide();
        Beams {
            wide,
            extent: wide.extent(),
            packets: Tracer::counting(bvh),
            cells: Box::new(Cells::new()),
            groups: Vec::with_capacity(SIZE),
            projected: Vec::with_capacity(SIZE),
            closest: Vec::with_capacity(SIZE),
            any: Vec::with_capacity(SIZE),
            stack: Stack::new(wide),
            work: T::default(),
        }
    }

    /// Counters since it was made.
    pub(super) fn work(&self) -> T {
        let mut work = self.work;
        work.add(&self.packets.work);
        work
    }

    /// The closest hits of some packets of a queue that all start in one point, one [`HitPacket`] each; false, and nothing
    /// done, if they do not.
    pub(super) fn closest(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        hits: &mut [HitPacket],
    ) -> bool {
        let batch = Batch {
            rays,
            packets,
            tmax: f32::INFINITY,
        };
        let Some(apex) = Apex::behind(rays, batch.packets.clone()) else {
            return false;
        };
        let mut goals = std::mem::take(&mut self.closest);
        let alone = self.trace::<_, true>(&batch, &apex, &mut goals, |limit, _| Closest::new(limit));
        let places = hits.chunks_mut(L::PACKETS);
        for (k, (goal, hits)) in goals.iter().zip(places).enumerate() {
            let (rays, active) = batch.group::<L>(k);
            let found = match alone >> k & 1 {
                0 => goal.hits(rays.tmax, active),
                _ => self.packets.closest(&rays, active),
            };
            for (k, hit) in hits.iter_mut().enumerate() {
                *hit = found.eight(k);
            }
        }
        self.closest = goals;
        true
    }

    /// Tells `answer`, for some packets of a queue that all end or all start in one point, which lanes (as bits) of each meet
    /// nothing before `tmax`; false, and nothing done, if they do not.
    pub(super) fn unoccluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        answer: &mut impl FnMut(usize, u8),
    ) -> bool {
        let batch = Batch {
            rays,
            packets,
            tmax,
        };
        let mut goals = std::mem::take(&mut self.any);
        let alone = if let Some(apex) = Apex::ahead(rays, batch.packets.clone(), tmax) {
            self.trace::<_, false>(&batch, &apex, &mut goals, AnyHit::new)
        } else if let Some(apex) = Apex::behind(rays, batch.packets.clone()) {
            self.trace::<_, true>(&batch, &apex, &mut goals, AnyHit::new)
        } else {
            self.any = goals;
            return false;
        };
        for (k, goal) in goals.iter().enumerate() {
            let (rays, active) = batch.group::<L>(k);
            let blocked = match alone >> k & 1 {
                0 => goal.blocked(),
                _ => self.packets.occluded(&rays, active),
            };
            let seen = (active & !blocked).bits();
            let first = batch.packets.start + k * L::PACKETS;
            for (k, packet) in (first..batch.packets.end).take(L::PACKETS).enumerate() {
                answer(packet, (seen >> (k * LANES)) as u8);
            }
        }
        self.any = goals;
        true
    }

    /// Traces a beam, and tells which of its packets, as bits, are left because they part too much.
    #[inline(always)]
    fn trace<G: Goal<L>, const SHARED: bool>(
        &mut self,
        batch: &Batch,
        apex: &Apex,
        goals: &mut Vec<G>,
        goal: impl Fn(L, L::Mask) -> G,
    ) -> u64 {
        let count = batch.groups::<L>();
        let frame = Frame::new(apex, toward(batch), self.extent);
        self.cells.clear();
        self.groups.clear();
        goals.clear();
        self.projected.clear();
        for k in 0..count {
            let (rays, active) = batch.group::<L>(k);
            let prepared = Prepared::new(&rays, active);
            self.projected.push(projected(&frame, &prepared));
            self.groups.push(prepared);
            goals.push(goal(active.select(rays.tmax, nowhere()), active));
        }
        self.cells.look_at(&frame, &self.projected);
        let mut alone = 0;
        for (k, (goal, projected)) in goals.iter().zip(&self.projected).enumerate() {
            let active = batch.active::<L>(k);
            if self.cells.add(frame.near, *projected, goal.limit(), active, k, count - k - 1) {
                self.work
                    .begin(L::PACKETS as u64, active.bits().count_ones());
            } else {
                alone |= 1 << k;
            }
        }
        self.cells.finish(&frame);
        descend::Descent::<L, G, T> {
            wide: self.wide,
            frame: &frame,
            cells: &mut self.cells,
            groups: &self.groups,
            goals,
            packets: &mut self.packets,
            work: &mut self.work,
        }
        .run::<SHARED>(&mut self.stack);
        alone
    }
}

/// About where the rays of a beam go: the sum of one of each few packets.
fn toward(batch: &Batch) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for packet in batch.packets.clone().step_by(8) {
        let (_, dir) = batch.rays.ray(packet, 0);
        for (sum, d) in sum.iter_mut().zip(dir) {
            *sum += d;
        }
    }
    sum
}
