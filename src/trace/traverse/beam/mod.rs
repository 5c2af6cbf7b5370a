//! Beams: hundreds of rays that share a point, the eye or a light, traverse the wide tree together.
//!
//! In projective coordinates such a ray is a point, and a group of rays has a rectangle; boxes and
//! triangles have projections, too. A node's children are projected from the apex once for all
//! rays. Then each child is tested against all sub-beams; a lane is a sub-beam of up to sixteen
//! rays. A leaf's triangles are projected once, and then tested against each sub-beam; a lane is a
//! triangle. Only the pairs that are left are tested ray by ray, by the same test that every kernel
//! has.
//!
//! The idea is that of beam and frustum tracing (Reshetov, Soupikov and Hurley, "Multi-Level Ray
//! Tracing Algorithm", 2005; Wald et al., "Ray Tracing Deformable Scenes Using Dynamic Bounding
//! Volume Hierarchies", 2007). The departures are hundreds of rays instead of a packet, and a mask
//! of sub-beams on the stack instead of a first active ray.
//!
//! | file | contents |
//! |---|---|
//! | `apex` | the common point of rays |
//! | `projection` | projected boxes and triangles, and why nothing is lost |
//! | `sorted` | rays in the order of their projections |
//! | `sub_beams` | the rays, in rectangles |
//! | `block`, `pairs` | the triangles of a block, and their pairs with sub-beams |
//! | `shadow_cull`, `deferred` | culling before the test of shadow rays, several blocks at a time |
//! | `traverse` | the traversal of the wide tree |

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

use super::counters::{Counters, PacketCount};
use super::packet::PacketKernel;
use super::prefetch::{PrefetchTable, prefetch};
use crate::bvh::{Bvh, WideBvh};
use crate::intersect::aabb::RaySlabs;
use crate::intersect::hit::inactive_t;
use crate::intersect::ray_setup::RaySetup;
use crate::intersect::shear::Shear;
use crate::packet::{HitPacket, RayPacket, RayQueue};
use crate::simd::{F32x8, LANES, LaneMask, Lanes, NATIVE, Native, Vec3Lanes};
use crate::traverse::query::{AnyHit, ClosestHit, Query};
use apex::{Apex, same};
use deferred::DeferredBlocks;
use projection::BeamSpace;
use sorted::Sorted;
use std::ops::Range;
use sub_beams::{Added, Extent, MAX_SUB_BEAMS, SubBeams, directions, directions_by};
use traverse::Stack;

/// Packets of eight in a beam. More packets share more of the nodes, and less of the caches.
pub(super) const SIZE: usize = 64;

const _: () = assert!(SIZE <= MAX_SUB_BEAMS, "a cell for every packet, at least");

/// Traces rays as beams if they share a point, else as packets, and counts by `T`.
pub(super) struct Beams<'a, L: Lanes = F32x8, T = PacketCount> {
    wide: &'a WideBvh,
    extent: f32,
    packets: PacketKernel<'a, L, T>,
    sub_beams: Box<SubBeams>,
    /// Packets of the beam, prepared for tests of triangles.
    groups: Vec<Group<L>>,
    /// Slabs of the packets, if the tree holds anything but triangles.
    slabs: Vec<RaySlabs<L>>,
    /// Projections of the packets' rays.
    projected: Vec<[L; 3]>,
    closest: Vec<ClosestHit<L>>,
    any: Vec<AnyHit<L>>,
    /// Memory for the rays of a beam that ends at a light; taken out while it is traced.
    sorted: Option<Box<Sorted>>,
    stack: Stack,
    deferred: Box<DeferredBlocks<'a>>,
    /// True if the last beam of [`Beams::closest`] had no hits.
    clear: bool,
    counters: T,
}

/// The rays of a packet, with the data of triangle tests.
struct Group<L: Lanes> {
    rays: RayPacket<L>,
    shear: Shear<L>,
}

impl<L: Lanes> Group<L> {
    /// The data of box tests.
    #[inline(always)]
    fn slabs(&self) -> RaySlabs<L> {
        RaySlabs::new(self.rays.org, self.rays.dir, L::Mask::splat(true))
    }

    /// The data of all of a packet's tests.
    fn prepared(&self, slabs: &RaySlabs<L>) -> RaySetup<L> {
        RaySetup {
            rays: self.rays,
            slabs: *slabs,
            shear: self.shear,
        }
    }
}

/// The packets of a beam, as a range of a queue.
struct BeamBatch<'q, 'a> {
    rays: &'q RayQueue<'a>,
    packets: Range<usize>,
    tmax: f32,
}

impl BeamBatch<'_, '_> {
    fn groups<L: Lanes>(&self) -> usize {
        self.packets.len().div_ceil(L::PACKETS)
    }

    /// Prefetches the rays that come after these. A beam needs its rays all at once, and then there
    /// is no other work to overlap with the fetch.
    fn fetch_next(&self) {
        let slots = self.rays.slots();
        let end = self.packets.end;
        for packet in end..slots.len().min(end + self.packets.len()) {
            prefetch(slots, packet as u32);
        }
    }

    /// The k-th group; prefetches that of the next beam.
    #[inline(always)]
    fn group_and_next<L: Lanes>(&self, k: usize) -> (RayPacket<L>, L::Mask) {
        let slots = self.rays.slots();
        for j in 0..L::PACKETS {
            let packet = self.packets.end + k * L::PACKETS + j;
            prefetch(slots, packet as u32);
        }
        self.group(k)
    }

    /// Index in the queue of the j-th packet of the k-th group. For camera rays, the packet after
    /// the next lies below and not beside: two packets of 4×2 pixels make a square.
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

    /// The k-th group, and the lanes that carry rays.
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
    /// each. Returns false, and does nothing, if they do not, or if rounding leaves no useful
    /// [`BeamSpace`].
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
                    _ => self.packets.call_closest(rays, active),
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

    /// Returns true if all rays start at the apex and none hits anything. Sky is beside sky, so
    /// this is called if the beam before had no hits. It costs a fifth of the set-up of a beam.
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

    /// Passes `answer`, for some packets of a queue that all end or all start in one point, the
    /// lanes (as bits) of each that hit nothing before `tmax`. Returns false, and does nothing, if
    /// they do not, or if rounding leaves no useful [`BeamSpace`].
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

    /// Passes `seen`, for some packets, the lanes (as bits) that hit nothing. Returns false, and
    /// passes nothing, in the same case as [`Beams::trace`].
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
                // In a packet that was not traced, no lane is occluded yet.
                let mut unblocked = query.unoccluded();
                if alone >> k & 1 == 1 {
                    let rays = &self.groups[k].rays;
                    unblocked = unblocked & !self.packets.call_occluded(rays, unblocked);
                }
                seen(k, unblocked.bits());
            }
        }
        self.any = goals;
        traced.is_some()
    }

    /// Traces a beam, and returns the packets, as bits, that were not traced because they diverge
    /// too much. Returns `None`, and does nothing, if rays that must start at the apex (`SHARED`)
    /// do not.
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

    /// Makes sub-beams of packets from the `next`-th on, as many as there is room for, and returns
    /// the first packet that has no room. Packets that diverge too much are marked in `alone`, as
    /// bits.
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

    /// Traverses the tree with the sub-beams.
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

/// Approximate direction of a beam's rays: the sum of one ray of every eighth packet.
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
