//! One thread's share of a batch: copies rays into packets, traces them and copies the answers
//! back.

use super::rows::run_of_four;
use super::{Hit, HitColumns, RayColumns, TMax};
use crate::bvh::{Bvh, GeometryStarts};
use crate::packet::{HitPacket, NO_PRIM, QueueColumns, QueueStorage, RayQueue, packets_for};
use crate::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, Vec3x8};
use crate::traverse::every_hit::FoundHit;
use crate::traverse::queue_kernel::TMaxOf;
use crate::traverse::{Kernel, Traversal};

/// Three components of each of eight rays.
type Octet3 = [[f32; LANES]; 3];

/// Components of rays in columns.
type Octets<'a> = [&'a [f32; LANES]; 3];

/// Output rows of rays that are traced in another order than given.
pub(super) type RowNumbers<'p> = Option<&'p [u32]>;

/// Destination of a packet's answers.
enum EightRows<'p> {
    From(usize),
    At(&'p [u32]),
}

/// Substitute for a ray that cannot hit anything, in a packet without any that can.
const STAND_IN: (Octet3, Octet3) = ([[0.0; LANES]; 3], [[1.0; LANES]; 3]);

/// One thread's kernels and memory.
pub(super) struct Worker<'a> {
    traversal: Traversal<'a>,
    geometries: &'a GeometryStarts,
    packets: PacketStorage,
    hits: Vec<HitPacket>,
    blocked: Vec<u8>,
    /// Every hit of all rays.
    hit_list: Vec<FoundHit>,
    /// The same, ray after ray.
    sorted: Vec<FoundHit>,
}

/// Rays of a batch as packets.
#[derive(Default)]
pub(super) struct PacketStorage {
    pub(super) queue: QueueStorage,
    /// Limits of each packet, if they differ.
    tmax: Vec<[f32; LANES]>,
    /// Lanes of each packet that can hit anything.
    pub(super) able: Vec<u8>,
}

impl<'a> Worker<'a> {
    pub(super) fn new(bvh: &'a Bvh, kernel: Kernel) -> Worker<'a> {
        Worker {
            traversal: Traversal::new(bvh, kernel),
            geometries: bvh.geometries(),
            packets: PacketStorage::default(),
            hits: Vec::new(),
            blocked: Vec::new(),
            hit_list: Vec::new(),
            sorted: Vec::new(),
        }
    }

    /// The closest hits of rays, stored in the rows with these indices, or in the rays' own rows if
    /// there are none.
    pub(super) fn closest(&mut self, rays: &RayColumns, hits: &mut HitColumns, rows: RowNumbers) {
        self.find_closest(rays);
        let mut run = self.geometries.run_of(0);
        for (k, (packet, &able)) in self.hits.iter().zip(&self.packets.able).enumerate() {
            let hit = if_able(packet, able);
            let geom_id = self.geometries.find_eight(hit.prim_id, &mut run);
            let rows = EightRows::of(rows, k * LANES);
            rows.put(hits.t, hit.t.to_array());
            rows.put(hits.u, hit.u.to_array());
            rows.put(hits.v, hit.v.to_array());
            rows.put(hits.prim_id, hit.prim_id.to_array());
            rows.put(hits.geom_id, geom_id.to_array());
        }
    }

    /// Passes on each ray's number and its closest hit.
    pub(super) fn closest_each(
        &mut self,
        rays: &RayColumns,
        mut put: impl FnMut(usize, Option<Hit>),
    ) {
        self.find_closest(rays);
        let mut run = self.geometries.run_of(0);
        for (k, (packet, &able)) in self.hits.iter().zip(&self.packets.able).enumerate() {
            let hit = if_able(packet, able);
            let geom_id = self.geometries.find_eight(hit.prim_id, &mut run).to_array();
            let (t, prim_id) = (hit.t.to_array(), hit.prim_id.to_array());
            let (u, v) = (hit.u.to_array(), hit.v.to_array());
            for lane in 0..LANES.min(rays.len() - k * LANES) {
                let hit = Hit {
                    t: t[lane],
                    u: u[lane],
                    v: v[lane],
                    prim_id: prim_id[lane],
                    geom_id: geom_id[lane],
                };
                put(k * LANES + lane, (hit.prim_id != NO_PRIM).then_some(hit));
            }
        }
    }

    /// The closest hits of all rays, in `hits`; lanes not in `able` are undefined.
    fn find_closest(&mut self, rays: &RayColumns) {
        let endless = rays.tmax.common() == Some(f32::INFINITY);
        let any_able = self.packets.fill(rays, !endless);
        let count = packets_for(rays.len());
        self.hits.resize(count, HitPacket::miss());
        let queue = self.packets.queue.queue();
        if any_able && endless {
            self.traversal.closest(&queue, 0..count, &mut self.hits);
        } else if any_able {
            let kernel = self.traversal.packets();
            kernel.closest_below(&queue, &self.packets.tmax, &mut self.hits);
        }
    }

    /// All hits: the list of each ray, sorted by (t, prim_id).
    pub(super) fn hit_lists(&mut self, rays: &RayColumns) -> impl Iterator<Item = &[FoundHit]> {
        self.find_every_hit(rays);
        // A counting sort by ray first: a single sort would compare hits of different rays.
        let mut ends = vec![0; rays.len()];
        for hit in &self.hit_list {
            ends[hit.ray as usize] += 1;
        }
        // Start of each list, and once its hits are in place, its end.
        let mut sum = 0;
        for end in &mut ends {
            sum += std::mem::replace(end, sum);
        }
        self.sorted.resize(self.hit_list.len(), FoundHit::default());
        for hit in &self.hit_list {
            let end = &mut ends[hit.ray as usize];
            self.sorted[*end] = *hit;
            *end += 1;
        }
        let mut rest = &mut self.sorted[..];
        let mut start = 0;
        ends.into_iter().map(move |end| {
            let list;
            (list, rest) = std::mem::take(&mut rest).split_at_mut(end - start);
            start = end;
            list.sort_unstable_by_key(FoundHit::key);
            &*list
        })
    }

    /// All hits, unordered.
    pub(super) fn find_every_hit(&mut self, rays: &RayColumns) -> &[FoundHit] {
        let common = rays.tmax.common();
        self.hit_list.clear();
        if self.packets.fill(rays, common.is_none()) {
            let tmax = match common {
                Some(tmax) => TMaxOf::All(tmax),
                None => TMaxOf::Each(&self.packets.tmax),
            };
            let queue = self.packets.queue.queue();
            self.traversal.every_hit(&queue, tmax, &mut self.hit_list);
            self.hit_list
                .retain(|hit| is_able(&self.packets.able, hit.ray as usize));
        }
        &self.hit_list
    }

    /// Flags of rays that hit anything, stored in rows as by [`Worker::closest`].
    pub(super) fn occluded(&mut self, rays: &RayColumns, blocked: &mut [bool], rows: RowNumbers) {
        let common = rays.tmax.common();
        let any_able = self.packets.fill(rays, common.is_none());
        let count = packets_for(rays.len());
        self.blocked.resize(count, 0);
        let queue = self.packets.queue.queue();
        let (traversal, bits) = (&mut self.traversal, &mut self.blocked);
        match common {
            _ if !any_able => {}
            Some(tmax) => traversal.occluded(&queue, 0..count, tmax, bits),
            None => (traversal.packets()).occluded_below(&queue, &self.packets.tmax, bits),
        }
        let lanes = self.blocked.iter().zip(&self.packets.able);
        for (k, (bits, able)) in lanes.enumerate() {
            let flags = std::array::from_fn(|lane| (bits & able) >> lane & 1 == 1);
            EightRows::of(rows, k * LANES).put(blocked, flags);
        }
    }
}

/// Eight answers in their final form: lanes not in `able` miss, and all misses are the same.
#[inline(always)]
fn if_able(packet: &HitPacket, able: u8) -> HitPacket {
    let (miss, able) = (HitPacket::miss(), Mask8::from_bits(u32::from(able)));
    let met = !packet.prim_id.eq(miss.prim_id) & able;
    HitPacket {
        t: met.select(packet.t, miss.t),
        u: met.select(packet.u, miss.u),
        v: met.select(packet.v, miss.v),
        prim_id: met.select_u32(packet.prim_id, miss.prim_id),
    }
}

/// Returns true if a ray can hit anything; another one stands in for it if not.
pub(super) fn is_able(able: &[u8], ray: usize) -> bool {
    able[ray / LANES] >> (ray % LANES) & 1 == 1
}

impl<'p> EightRows<'p> {
    /// Answers of the packet whose rays begin at `from`.
    #[inline(always)]
    fn of(rows: RowNumbers<'p>, from: usize) -> EightRows<'p> {
        match rows {
            None => EightRows::From(from),
            Some(rows) => EightRows::At(&rows[from..(from + LANES).min(rows.len())]),
        }
    }

    /// Writes eight answers, or fewer if there are fewer rows.
    #[inline(always)]
    fn put<T: Copy>(&self, column: &mut [T], eight: [T; LANES]) {
        match *self {
            EightRows::From(from) => {
                let rows = &mut column[from..];
                match rows.first_chunk_mut() {
                    Some(rows) => *rows = eight,
                    None => rows.copy_from_slice(&eight[..rows.len()]),
                }
            }
            EightRows::At(rows) => {
                let fours = rows.as_chunks::<4>().0;
                if let [a, b] = fours
                    && let (Some(a), Some(b)) = (run_of_four(a), run_of_four(b))
                {
                    column[a..a + 4].copy_from_slice(&eight[..4]);
                    column[b..b + 4].copy_from_slice(&eight[4..]);
                    return;
                }
                for (&row, answer) in rows.iter().zip(eight) {
                    column[row as usize] = answer;
                }
            }
        }
    }
}

impl PacketStorage {
    /// Copies rays into packets, and their limits if they are needed; returns true if any of the
    /// rays can hit anything.
    pub(super) fn fill(&mut self, rays: &RayColumns, with_limits: bool) -> bool {
        let (count, full) = (packets_for(rays.len()), rays.len() / LANES);
        self.able.resize(count, 0);
        self.tmax
            .resize(if with_limits { count } else { 0 }, [0.0; LANES]);
        let (able, limits) = (&mut self.able[..], &mut self.tmax[..]);
        let mut neighbour = STAND_IN;
        self.queue.fill(count, QueueColumns::default(), |queue| {
            // Whole packets are copied directly from the columns to the queue. Arrays that might
            // also be assembled number by number would be copied that way, too.
            let [ox, oy, oz] = rays.origin.map(|column| &column.as_chunks().0[..full]);
            let [dx, dy, dz] = rays.direction.map(|column| &column.as_chunks().0[..full]);
            for (k, able) in able[..full].iter_mut().enumerate() {
                let (org, dir) = ([&ox[k], &oy[k], &oz[k]], [&dx[k], &dy[k], &dz[k]]);
                let tmax = match rays.tmax {
                    TMax::All(tmax) => [tmax; LANES],
                    TMax::Each(each) => each.as_chunks().0[k],
                };
                *able = able_lanes(org, dir, &tmax);
                if *able == 0xff {
                    queue.push_octet(org, dir, LANES);
                } else {
                    push_able(queue, (org, dir), *able, LANES, &mut neighbour);
                }
                if let Some(limits) = limits.get_mut(k) {
                    *limits = tmax;
                }
            }
            if full < count {
                let tail = |column: &[f32]| repeat_last(&column[full * LANES..]);
                let (org, dir) = (rays.origin.map(tail), rays.direction.map(tail));
                let (org, dir) = (org.each_ref(), dir.each_ref());
                let tmax = match rays.tmax {
                    TMax::All(tmax) => [tmax; LANES],
                    TMax::Each(each) => tail(each),
                };
                let rest = rays.len() % LANES;
                able[full] = able_lanes(org, dir, &tmax);
                push_able(queue, (org, dir), able[full], rest, &mut neighbour);
                if let Some(limits) = limits.get_mut(full) {
                    *limits = tmax;
                }
            }
        });
        able.iter().any(|&lanes| lanes != 0)
    }
}

/// Appends a packet in which every ray that cannot hit anything is replaced by one that can.
#[cold]
fn push_able(
    queue: &mut RayQueue,
    (org, dir): (Octets, Octets),
    able: u8,
    count: usize,
    neighbour: &mut (Octet3, Octet3),
) {
    let (mut org, mut dir) = (org.map(|row| *row), dir.map(|row| *row));
    *neighbour = replace_unable(able, (&mut org, &mut dir), *neighbour);
    queue.push_octet(org.each_ref(), dir.each_ref(), count);
}

/// Fewer than eight numbers, padded with the last one.
pub(super) fn repeat_last(numbers: &[f32]) -> [f32; LANES] {
    std::array::from_fn(|lane| numbers[lane.min(numbers.len() - 1)])
}

/// Lanes (as bits) of rays that can hit something; see [`RayColumns`].
#[inline(always)]
pub(super) fn able_lanes(org: Octets, dir: Octets, tmax: &[f32; LANES]) -> u8 {
    // 0 for a finite number, else NaN.
    let residue = |x: &[f32; LANES]| F32x8::new(*x) * F32x8::ZERO;
    let sum = |[x, y, z]: Octets| residue(x) + residue(y) + residue(z);
    let residue = sum(org) + sum(dir);
    let [x, y, z] = dir;
    let length = Vec3x8::new(F32x8::new(*x), F32x8::new(*y), F32x8::new(*z)).max_abs();
    let able = residue.eq(F32x8::ZERO) & length.gt(F32x8::ZERO) & F32x8::new(*tmax).gt(F32x8::ZERO);
    able.bits() as u8
}

/// Replaces each ray that cannot hit anything by a neighbour that can: NaNs would spread over the
/// whole beam, and a copy of a neighbour is the cheapest substitute. `before` is a ray of an
/// earlier packet; returns one for later packets.
fn replace_unable(
    able: u8,
    (org, dir): (&mut Octet3, &mut Octet3),
    before: (Octet3, Octet3),
) -> (Octet3, Octet3) {
    let (lane, from) = match able {
        0 => (0, before),
        _ => (able.trailing_zeros() as usize, (*org, *dir)),
    };
    let stand_in = (
        from.0.map(|c| [c[lane]; LANES]),
        from.1.map(|c| [c[lane]; LANES]),
    );
    for unable in (0..LANES).filter(|lane| able >> lane & 1 == 0) {
        for axis in 0..3 {
            org[axis][unable] = stand_in.0[axis][unable];
            dir[axis][unable] = stand_in.1[axis][unable];
        }
    }
    stand_in
}
