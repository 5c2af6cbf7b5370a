//! Beams: hundreds of rays that share a point, the eye or a light, together down the wide tree.
//!
//! What belongs to such rays is a point and a rectangle in projective coordinates, and so is what
//! belongs to boxes and triangles: a node's children are seen from the apex once for all rays, then
//! each against all cells, a lane being a cell of up to sixteen rays; a leaf's triangles are seen
//! once, then against each cell, a lane being a triangle. Only what is left is tested ray by ray,
//! by the same test that every kernel has.
//!
//! The idea is that of beam and frustum tracing (Reshetov, Soupikov and Hurley, "Multi-Level Ray
//! Tracing Algorithm", 2005; Wald et al., "Ray Tracing Deformable Scenes Using Dynamic Bounding
//! Volume Hierarchies", 2007), with hundreds of rays where they have a packet, and with a mask of
//! cells on the stack instead of a first active ray.
//!
//! | file | what |
//! |---|---|
//! | `apex` | whether rays share a point |
//! | `projection` | boxes and triangles seen from it, and why nothing is lost |
//! | `sorted` | rays in the order in which they are seen |
//! | `sub_beams` | the rays, in rectangles |
//! | `block`, `pairs` | the triangles of a block, and which cells each is tested against |
//! | `shadow_cull`, `deferred` | for shadow rays: what can be ruled out before a test, for several blocks at a time |
//! | `traverse` | cells down the tree |

mod apex;
mod block;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod deferred;
#[allow(
    unsafe_code,
    reason = "the list has no bounds checks; each block says why it may"
)]
mod pairs;
mod projection;
mod shadow_cull;
mod sorted;
mod sub_beams;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod traverse;

use super::aabb::RaySlabs;
use super::counters::{Counters, PacketCount};
use super::packet::PacketKernel;
use super::prefetch::{PrefetchTable, prefetch};
use super::query::{AnyHit, ClosestHit, Query, RaySetup, inactive_t};
use super::triangle::Shear;
use crate::bvh::{Bvh, WideBvh};
use crate::packet::{HitPacket, RayPacket, RayQueue};
use crate::simd::{F32x8, LANES, LaneMask, Lanes, NATIVE, Native, Vec3Lanes};
use apex::{Apex, same};
use deferred::DeferredBlocks;
use projection::BeamSpace;
use sorted::Sorted;
use std::ops::Range;
use sub_beams::{Added, Extent, MAX_SUB_BEAMS, SubBeams, directions, directions_by};
use traverse::Stack;

/// Packets of eight that go as one beam. More share more of the nodes, and less of the caches.
pub(super) const SIZE: usize = 64;

const _: () = assert!(SIZE <= MAX_SUB_BEAMS, "a cell for every packet, at least");

/// Traces rays as beams where they share a point, as packets where they do not, and counts by `T`.
pub(super) struct Beams<'a, L: Lanes = F32x8, T = PacketCount> {
    wide: &'a WideBvh,
    extent: f32,
    packets: PacketKernel<'a, L, T>,
    sub_beams: Box<SubBeams>,
    /// Packets of the beam, ready for tests of triangles.
    groups: Vec<Group<L>>,
    /// And of boxes, where the tree holds anything but triangles.
    slabs: Vec<RaySlabs<L>>,
    /// Where they go.
    projected: Vec<[L; 3]>,
    closest: Vec<ClosestHit<L>>,
    any: Vec<AnyHit<L>>,
    /// Room for the rays of one that ends at a light; out of its place while there is one.
    sorted: Option<Box<Sorted>>,
    stack: Stack,
    deferred: Box<DeferredBlocks<'a>>,
    /// Whether the last beam of [`Beams::closest`] met nothing.
    clear: bool,
    counters: T,
}

/// The rays of a packet, and what tests of triangles need of them.
struct Group<L: Lanes> {
    rays: RayPacket<L>,
    shear: Shear<L>,
}

impl<L: Lanes> Group<L> {
    /// What tests of boxes need.
    #[inline(always)]
    fn slabs(&self) -> RaySlabs<L> {
        RaySlabs::new(self.rays.org, self.rays.dir, L::Mask::splat(true))
    }

    /// With them, what a packet's tests need.
    fn prepared(&self, slabs: &RaySlabs<L>) -> RaySetup<L> {
        RaySetup {
            rays: self.rays,
            slabs: *slabs,
            shear: self.shear,
        }
    }
}

/// The packets of a beam, of a queue.
struct BeamBatch<'q, 'a> {
    rays: &'q RayQueue<'a>,
    packets: Range<usize>,
    tmax: f32,
}

impl BeamBatch<'_, '_> {
    fn groups<L: Lanes>(&self) -> usize {
        self.packets.len().div_ceil(L::PACKETS)
    }

    /// Asks for the rays that come after these: when a beam's are wanted, all at once, there is
    /// nothing else to do.
    fn fetch_next(&self) {
        let slots = self.rays.slots();
        let end = self.packets.end;
        for packet in end..slots.len().min(end + self.packets.len()) {
            prefetch(slots, packet as u32);
        }
    }

    /// The k-th group, while those of the next beam are asked for.
    #[inline(always)]
    fn group_and_next<L: Lanes>(&self, k: usize) -> (RayPacket<L>, L::Mask) {
        let slots = self.rays.slots();
        for j in 0..L::PACKETS {
            let packet = self.packets.end + k * L::PACKETS + j;
            prefetch(slots, packet as u32);
        }
        self.group(k)
    }

    /// Which packet of the queue is the j-th of the k-th group. Of camera rays, the packet after
    /// the next lies below and not beside: two of 4×2 pixels make a square.
    #[inline(always)]
    fn packet<L: Lanes>(&self, k: usize, j: usize) -> usize {
        let (at, whole) = (k * L::PACKETS + j, self.packets.len() & !3);
        let turned = L::PACKETS == 2 && at < whole;
        let place = if turned {
            at & !3 | (at & 1) << 1 | (at >> 1 & 1)
        } else {
            at
        };
        self.packets.start + place
    }

    /// The k-th group, and which of its lanes carry rays.
    #[inline(always)]
    fn group<L: Lanes>(&self, k: usize) -> (RayPacket<L>, L::Mask) {
        let rays = self.rays.packets_at(|j| self.packet::<L>(k, j), self.tmax);
        (rays, self.active::<L>(k))
    }

    #[inline(always)]
    fn active<L: Lanes>(&self, k: usize) -> L::Mask {
        let mut lanes = 0;
        for j in 0..L::PACKETS {
            let packet = self.packet::<L>(k, j);
            if packet < self.packets.end {
                lanes |= self.rays.active(packet).bits() << (j * LANES);
            }
        }
        L::Mask::from_bits(lanes)
    }
}

impl<'a, L: Lanes, T: Counters> Beams<'a, L, T> {
    pub(super) fn new(bvh: &'a Bvh) -> Beams<'a, L, T> {
        let wide = bvh.wide();
        Beams {
            wide,
            extent: wide.extent(),
            packets: PacketKernel::counting(bvh),
            sub_beams: Box::new(SubBeams::new()),
            groups: Vec::with_capacity(SIZE),
            slabs: Vec::with_capacity(SIZE),
            projected: Vec::with_capacity(SIZE),
            closest: Vec::with_capacity(SIZE),
            any: Vec::with_capacity(SIZE),
            sorted: None,
            stack: Stack::new(wide),
            deferred: Box::new(DeferredBlocks::none()),
            clear: false,
            counters: T::default(),
        }
    }

    /// Counters since it was made.
    pub(super) fn counters(&self) -> T {
        let mut work = self.counters;
        work.add(&self.packets.counters);
        work
    }

    /// The closest hits of some packets of a queue that all start in one point, one [`HitPacket`]
    /// each; false, and nothing done, if they do not or rounding leaves no useful [`BeamSpace`].
    pub(super) fn closest(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        hits: &mut [HitPacket],
    ) -> bool {
        let batch = BeamBatch {
            rays,
            packets,
            tmax: f32::INFINITY,
        };
        let Some(apex) = Apex::behind(rays, &batch.packets) else {
            return false;
        };
        let Some(space) = BeamSpace::new(&apex, toward(&batch), self.extent) else {
            return false;
        };
        if self.clear && self.is_clear(&space, &batch) {
            hits.fill(HitPacket::miss());
            return true;
        }
        let mut goals = std::mem::take(&mut self.closest);
        let count = batch.groups::<L>();
        let traced = self.trace::<_, true>(
            &space,
            count,
            |k| batch.group_and_next(k),
            &mut goals,
            |limit, _| ClosestHit::new(limit),
        );
        if let Some(alone) = traced {
            self.clear = alone == 0 && !goals.iter().any(ClosestHit::found);
            for (k, query) in goals.iter().enumerate() {
                let (rays, active) = (&self.groups[k].rays, batch.active::<L>(k));
                let found = match alone >> k & 1 {
                    0 => query.hits(rays.tmax, active),
                    _ => self.packets.closest(rays, active),
                };
                for j in 0..L::PACKETS {
                    if let Some(hit) = hits.get_mut(batch.packet::<L>(k, j) - batch.packets.start) {
                        *hit = found.octet(j);
                    }
                }
            }
        }
        self.closest = goals;
        traced.is_some()
    }

    /// Whether all rays start at the apex and none meets anything. Sky is beside sky, so this is
    /// asked where the beam before met nothing, and costs a fifth of what a beam takes to set up.
    #[inline(never)]
    fn is_clear(&mut self, space: &BeamSpace, batch: &BeamBatch) -> bool {
        let [x, y, z] = space.center;
        let (center, mut extent) = (Vec3Lanes::splat(x, y, z), Extent::none());
        let (mut apart, mut lanes) = (L::Mask::none(), 0);
        for k in 0..batch.groups::<L>() {
            let (rays, active) = batch.group_and_next::<L>(k);
            apart = apart | (active & !same(rays.org, center));
            extent.add(directions(space, &rays), active);
            lanes += active.bits().count_ones();
        }
        let root = self.wide.nodes()[0].boxes.map(|c| c.map(Native::new));
        let clear = !apart.any() && extent.misses(space, &space.boxes(&root));
        self.counters.wide_node(NATIVE as u64);
        if clear {
            self.counters.begin(batch.packets.len() as u64, lanes);
        }
        clear
    }

    /// Tells `answer`, for some packets of a queue that all end or all start in one point, which
    /// lanes (as bits) of each meet nothing before `tmax`; false, and nothing done, if they do not
    /// or rounding leaves no useful [`BeamSpace`].
    pub(super) fn unoccluded(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        tmax: f32,
        answer: &mut impl FnMut(usize, u8),
    ) -> bool {
        let batch = BeamBatch {
            rays,
            packets,
            tmax,
        };
        let mut seen = [0; SIZE];
        if let Some(apex) = Apex::ahead(rays, batch.packets.clone(), tmax) {
            let Some(space) = BeamSpace::new(&apex, toward(&batch), self.extent) else {
                return false;
            };
            batch.fetch_next();
            let mut sorted = self.sorted.take().unwrap_or_default();
            sorted.take(&space, rays, batch.packets.clone());
            let (count, load) = (sorted.groups::<L>(), |k| sorted.group(k, tmax));
            self.shadows::<false>(&space, count, load, |k, lanes| {
                sorted.put_back::<L>(k, lanes, &mut seen);
            });
            self.sorted = Some(sorted);
        } else if let Some(apex) = Apex::behind(rays, &batch.packets) {
            let Some(space) = BeamSpace::new(&apex, toward(&batch), self.extent) else {
                return false;
            };
            batch.fetch_next();
            let (count, load) = (batch.groups::<L>(), |k| batch.group(k));
            let traced = self.shadows::<true>(&space, count, load, |k, lanes| {
                for j in 0..L::PACKETS {
                    let at = batch.packet::<L>(k, j) - batch.packets.start;
                    seen[at % SIZE] |= (lanes >> (j * LANES)) as u8;
                }
            });
            if !traced {
                return false;
            }
        } else {
            return false;
        }
        for (packet, seen) in batch.packets.zip(seen) {
            answer(packet, seen);
        }
        true
    }

    /// Tells `seen`, for some packets, which lanes (as bits) meet nothing; false, and nothing told,
    /// as [`Beams::trace`].
    #[inline(always)]
    fn shadows<const SHARED: bool>(
        &mut self,
        space: &BeamSpace,
        count: usize,
        load: impl Fn(usize) -> (RayPacket<L>, L::Mask),
        mut seen: impl FnMut(usize, u32),
    ) -> bool {
        let mut goals = std::mem::take(&mut self.any);
        let traced = self.trace::<_, SHARED>(space, count, load, &mut goals, AnyHit::new);
        if let Some(alone) = traced {
            for (k, query) in goals.iter().enumerate() {
                // Of one that was left alone, nothing is blocked yet.
                let mut unblocked = query.unoccluded();
                if alone >> k & 1 == 1 {
                    let rays = &self.groups[k].rays;
                    unblocked = unblocked & !self.packets.occluded(rays, unblocked);
                }
                seen(k, unblocked.bits());
            }
        }
        self.any = goals;
        traced.is_some()
    }

    /// Traces a beam, and tells which of its packets, as bits, are left because they part too much;
    /// none, and nothing done, if rays that are to start at the apex (`SHARED`) do not.
    #[inline(always)]
    fn trace<G: Query<L>, const SHARED: bool>(
        &mut self,
        space: &BeamSpace,
        count: usize,
        load: impl Fn(usize) -> (RayPacket<L>, L::Mask),
        goals: &mut Vec<G>,
        query: impl Fn(L, L::Mask) -> G,
    ) -> Option<u64> {
        self.groups.clear();
        self.slabs.clear();
        self.projected.clear();
        goals.clear();
        let [x, y, z] = space.center;
        let center = Vec3Lanes::splat(x, y, z);
        for k in 0..count {
            let (rays, active) = load(k);
            if SHARED && (active & !same(rays.org, center)).any() {
                return None;
            }
            let shear = Shear::new(rays.org, rays.dir, active);
            self.projected.push(directions_by(space, &rays, &shear));
            self.groups.push(Group { rays, shear });
            goals.push(query(active.select(rays.tmax, inactive_t()), active));
        }
        if !self.wide.has_triangles_only() {
            self.slabs.extend(self.groups.iter().map(Group::slabs));
        }
        self.sub_beams.look_at(space, &self.projected);
        let (mut alone, mut next) = (0, 0);
        while next < count {
            next = self.fill_sub_beams(space, goals, next, &mut alone);
            self.traverse(space, goals);
        }
        Some(alone)
    }

    /// Makes cells of packets from the `next`-th on, as many as there is room for, and tells which
    /// is the first that has none. Packets that part too much are told as bits.
    #[inline(always)]
    fn fill_sub_beams<G: Query<L>>(
        &mut self,
        space: &BeamSpace,
        goals: &[G],
        mut next: usize,
        alone: &mut u64,
    ) -> usize {
        self.sub_beams.clear();
        for (query, projected) in goals.iter().zip(&self.projected).skip(next) {
            let limit = query.limit();
            let active = limit.gt(inactive_t());
            match self
                .sub_beams
                .add(space.near, *projected, limit, active, next)
            {
                Added::NoRoom => break,
                Added::TooWide => *alone |= 1 << next,
                Added::All => {
                    let lanes = active.bits().count_ones();
                    self.counters
                        .begin(u64::from(lanes.div_ceil(LANES as u32)), lanes);
                }
            }
            next += 1;
        }
        self.sub_beams.finish(space);
        next
    }

    /// Takes the cells down the tree.
    #[inline(always)]
    fn traverse<G: Query<L>>(&mut self, space: &BeamSpace, goals: &mut [G]) {
        traverse::BeamTraversal::<L, G, T> {
            wide: self.wide,
            rows: PrefetchTable::of(self.wide),
            space,
            sub_beams: &mut self.sub_beams,
            groups: &self.groups,
            projected: &self.projected,
            slabs: &self.slabs,
            goals,
            packets: &mut self.packets,
            counters: &mut self.counters,
        }
        .traverse(&mut self.stack, &mut self.deferred);
    }
}

/// About where the rays of a beam go: the sum of one of each few packets.
fn toward(batch: &BeamBatch) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for packet in batch.packets.clone().step_by(8) {
        let (_, dir) = batch.rays.ray(packet, 0);
        for (sum, d) in sum.iter_mut().zip(dir) {
            *sum += d;
        }
    }
    sum
}
