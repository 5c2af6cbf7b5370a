//! The kernel of beams: rays of a queue into sub-beams, through the tree, and back as hits.

use super::apex::Apex;
use super::batch::{BeamGroup, SIZE};
use super::deferred::DeferredBlocks;
use super::projection::BeamSpace;
use super::ray_extent::{Extent, directions, directions_by};
use super::sorted::Sorted;
use super::state::BeamTraversal;
use super::sub_beams::{Added, MAX_SUB_BEAMS, SubBeams};
use super::traverse::Stack;
use crate::bvh::{Bvh, WideBvh};
use crate::intersect::aabb::RaySlabs;
use crate::intersect::hit::inactive_t;
use crate::intersect::shear::Shear;
use crate::packet::{HitPacket, RayPacket, RayQueue};
use crate::simd::{F32x8, LANES, LaneMask, Lanes, NATIVE, Native, Vec3Lanes};
use crate::traverse::batch_slice::BatchSlice;
use crate::traverse::counters::{Counters, PacketCount};
use crate::traverse::every_hit::FoundHits;
use crate::traverse::packet::PacketKernel;
use crate::traverse::prefetch::PrefetchTable;
use crate::traverse::query::{AnyHit, ClosestHit, Query};
use crate::traverse::queue_kernel::{QueueKernel, QueuePackets, TMaxOf};

const _: () = assert!(SIZE <= MAX_SUB_BEAMS, "a cell for every packet, at least");

/// Traces rays as beams if they share a point, else as packets, and counts by `T`.
pub(crate) struct Beams<'a, L: Lanes = F32x8, T = PacketCount> {
    wide: &'a WideBvh,
    extent: f32,
    packets: PacketKernel<'a, L, T>,
    sub_beams: Box<SubBeams>,
    /// Packets of the beam, prepared for tests of triangles.
    groups: Vec<BeamGroup<L>>,
    /// Slabs of the packets, unless the tree contains only triangles.
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

impl<'a, L: Lanes, T: Counters> Beams<'a, L, T> {
    pub(crate) fn new(bvh: &'a Bvh) -> Beams<'a, L, T> {
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

    /// Returns true if all rays start at the apex and none hits anything. Sky neighbours sky, so
    /// this is called if the previous beam had no hits. It costs a fifth of a beam's set-up.
    #[inline(never)]
    fn is_clear(&mut self, space: &BeamSpace, batch: &QueuePackets) -> bool {
        let [x, y, z] = space.center;
        let (center, mut extent) = (Vec3Lanes::splat(x, y, z), Extent::none());
        let (mut apart, mut lanes) = (L::Mask::none(), 0);
        for k in 0..batch.groups::<L>() {
            let (rays, active) = batch.group_and_next::<L>(k);
            apart = apart | (active & !rays.org.bits_eq(center));
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

    /// Passes to `blocked`, for each group, the lanes (as bits) that hit anything. Returns false,
    /// and passes nothing, in the same case as [`Beams::trace`].
    #[inline(always)]
    fn shadows<const SHARED: bool>(
        &mut self,
        space: &BeamSpace,
        count: usize,
        load: impl Fn(usize) -> (RayPacket<L>, L::Mask),
        mut blocked: impl FnMut(usize, u32),
    ) -> bool {
        let mut queries = std::mem::take(&mut self.any);
        let traced = self.trace::<_, SHARED>(space, count, load, &mut queries, AnyHit::new);
        if let Some(alone) = traced {
            for (k, query) in queries.iter().enumerate() {
                let mut hits = query.occluded();
                if alone >> k & 1 == 1 {
                    // In a packet that was not traced, no lane is occluded yet.
                    let rays = &self.groups[k].rays;
                    hits = self.packets.call_occluded(rays, query.unoccluded());
                }
                blocked(k, hits.bits());
            }
        }
        self.any = queries;
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
        queries: &mut Vec<G>,
        query: impl Fn(L, L::Mask) -> G,
    ) -> Option<u64> {
        self.groups.clear();
        self.slabs.clear();
        self.projected.clear();
        queries.clear();
        let [x, y, z] = space.center;
        let center = Vec3Lanes::splat(x, y, z);
        for k in 0..count {
            let (rays, active) = load(k);
            if SHARED && (active & !rays.org.bits_eq(center)).any() {
                return None;
            }
            let shear = Shear::new(rays.org, rays.dir, active);
            self.projected.push(directions_by(space, &rays, &shear));
            self.groups.push(BeamGroup { rays, shear });
            queries.push(query(active.select(rays.tmax, inactive_t()), active));
        }
        if !self.wide.has_triangles_only() {
            self.slabs.extend(self.groups.iter().map(BeamGroup::slabs));
        }
        self.sub_beams.look_at(space, &self.projected);
        let (mut alone, mut next) = (0, 0);
        while next < count {
            next = self.fill_sub_beams(space, queries, next, &mut alone);
            self.traverse(space, queries);
        }
        Some(alone)
    }

    /// Makes sub-beams of packets from the `next`-th on, as many as fit, and returns the first
    /// packet that does not fit. Packets that diverge too much are marked in `alone`, as bits.
    #[inline(always)]
    fn fill_sub_beams<G: Query<L>>(
        &mut self,
        space: &BeamSpace,
        queries: &[G],
        mut next: usize,
        alone: &mut u64,
    ) -> usize {
        self.sub_beams.clear();
        for (query, projected) in queries.iter().zip(&self.projected).skip(next) {
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
    fn traverse<G: Query<L>>(&mut self, space: &BeamSpace, queries: &mut [G]) {
        BeamTraversal::<L, G, T> {
            wide: self.wide,
            rows: PrefetchTable::of(self.wide),
            space,
            sub_beams: &mut self.sub_beams,
            groups: &self.groups,
            projected: &self.projected,
            slabs: &self.slabs,
            queries,
            packets: &mut self.packets,
            counters: &mut self.counters,
        }
        .traverse(&mut self.stack, &mut self.deferred);
    }
}

impl<L: Lanes, T: Counters> QueueKernel<T> for Beams<'_, L, T> {
    /// Traces rays that all start in one point; refuses others, and rays for which rounding leaves
    /// no useful [`BeamSpace`].
    fn closest(&mut self, rays: &RayQueue, slice: &BatchSlice, hits: &mut [HitPacket]) -> bool {
        let batch = QueuePackets {
            rays,
            packets: slice.packets.clone(),
            tmax: f32::INFINITY,
        };
        let Some(apex) = Apex::behind(rays, &batch.packets) else {
            return false;
        };
        let Some(space) = BeamSpace::new(&apex, batch.toward(), self.extent) else {
            return false;
        };
        if self.clear && self.is_clear(&space, &batch) {
            hits.fill(HitPacket::miss());
            return true;
        }
        let mut queries = std::mem::take(&mut self.closest);
        let count = batch.groups::<L>();
        let traced = self.trace::<_, true>(
            &space,
            count,
            |k| batch.group_and_next(k),
            &mut queries,
            |limit, _| ClosestHit::new(limit),
        );
        if let Some(alone) = traced {
            self.clear = alone == 0 && !queries.iter().any(ClosestHit::has_hit);
            for (k, query) in queries.iter().enumerate() {
                let (rays, active) = (&self.groups[k].rays, batch.active::<L>(k));
                let closest = match alone >> k & 1 {
                    0 => query.hits(rays.tmax, active),
                    _ => self.packets.call_closest(rays, active),
                };
                for j in 0..L::PACKETS {
                    if let Some(hit) = hits.get_mut(batch.packet::<L>(k, j) - batch.packets.start) {
                        *hit = closest.octet(j);
                    }
                }
            }
        }
        self.closest = queries;
        traced.is_some()
    }

    /// Traces rays that all end or all start in one point; refuses as [`QueueKernel::closest`].
    fn occluded(&mut self, batch: QueuePackets, blocked: &mut [u8]) -> bool {
        let (rays, tmax) = (batch.rays, batch.tmax);
        let mut answers = [0; SIZE];
        if let Some(apex) = Apex::ahead(rays, batch.packets.clone(), tmax) {
            let Some(space) = BeamSpace::new(&apex, batch.toward(), self.extent) else {
                return false;
            };
            batch.fetch_next();
            let mut sorted = self.sorted.take().unwrap_or_default();
            sorted.take(&space, rays, batch.packets.clone());
            let (count, load) = (sorted.groups::<L>(), |k| sorted.group(k, tmax));
            self.shadows::<false>(&space, count, load, |k, lanes| {
                sorted.put_back::<L>(k, lanes, &mut answers);
            });
            self.sorted = Some(sorted);
        } else if let Some(apex) = Apex::behind(rays, &batch.packets) {
            let Some(space) = BeamSpace::new(&apex, batch.toward(), self.extent) else {
                return false;
            };
            batch.fetch_next();
            let (count, load) = (batch.groups::<L>(), |k| batch.group(k));
            let traced = self.shadows::<true>(&space, count, load, |k, lanes| {
                for j in 0..L::PACKETS {
                    let index = batch.packet::<L>(k, j) - batch.packets.start;
                    answers[index % SIZE] |= (lanes >> (j * LANES)) as u8;
                }
            });
            if !traced {
                return false;
            }
        } else {
            return false;
        }
        blocked.copy_from_slice(&answers[..blocked.len()]);
        true
    }

    /// Beams end at the closest hits.
    fn every_hit(&mut self, _: &RayQueue, _: &BatchSlice, _: TMaxOf, _: &FoundHits) -> bool {
        false
    }

    fn counters(&self) -> T {
        let mut work = self.counters;
        work.add(&self.packets.counters);
        work
    }
}
