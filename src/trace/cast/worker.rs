//! One thread's share of a batch: copies rays into packets, has them traced and copies the answers
//! back.

use super::hit_lists::FoundHit;
use super::{HitBuffer, HitColumns, RayColumns, TMax};
use crate::bvh::{Bvh, GeometryStarts};
use crate::packet::{HitPacket, NO_PRIM, QueueColumns, QueueStorage, RayQueue, packets_for};
use crate::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, U32x8, Vec3x8};
use crate::traverse::{Kernel, Traversal};

/// Three numbers of each of eight rays.
type Octet3 = [[f32; LANES]; 3];

/// The same of rays in columns.
type Octets<'a> = [&'a [f32; LANES]; 3];

/// The substitute of a ray that cannot hit anything, in a packet without any that can.
const STAND_IN: (Octet3, Octet3) = ([[0.0; LANES]; 3], [[1.0; LANES]; 3]);

/// One thread's kernels and memory.
pub(super) struct Worker<'a> {
    traversal: Traversal<'a>,
    geometries: &'a GeometryStarts,
    packets: PacketStorage,
    hits: Vec<HitPacket>,
    blocked: Vec<u8>,
    /// Answers in the order in which rays are traced.
    answers: HitBuffer,
    flags: Vec<bool>,
}

/// Rays of a batch as packets.
#[derive(Default)]
struct PacketStorage {
    queue: QueueStorage,
    /// Limits of each packet, where they differ.
    tmax: Vec<[f32; LANES]>,
    /// Lanes of each packet that can hit anything.
    able: Vec<u8>,
}

impl<'a> Worker<'a> {
    pub(super) fn new(bvh: &'a Bvh, kernel: Kernel) -> Worker<'a> {
        Worker {
            traversal: Traversal::new(bvh, kernel),
            geometries: bvh.geometries(),
            packets: PacketStorage::default(),
            hits: Vec::new(),
            blocked: Vec::new(),
            answers: HitBuffer::default(),
            flags: Vec::new(),
        }
    }

    /// The closest hits of rays whose answers belong to these places.
    pub(super) fn closest_at(&mut self, rays: &RayColumns, hits: &mut HitColumns, places: &[u32]) {
        let mut answers = std::mem::take(&mut self.answers);
        answers.resize(rays.len());
        self.closest(rays, &mut answers.columns());
        answers.columns().put_at(hits, places);
        self.answers = answers;
    }

    /// As [`Worker::closest_at`], of flags.
    pub(super) fn occluded_at(&mut self, rays: &RayColumns, blocked: &mut [bool], places: &[u32]) {
        let mut flags = std::mem::take(&mut self.flags);
        flags.resize(rays.len(), false);
        self.occluded(rays, &mut flags);
        for (&place, &flag) in places.iter().zip(&flags) {
            blocked[place as usize] = flag;
        }
        self.flags = flags;
    }

    pub(super) fn closest(&mut self, rays: &RayColumns, hits: &mut HitColumns) {
        self.find_closest(rays, false);
        let mut run = self.geometries.run_of(0);
        for (k, (packet, &able)) in self.hits.iter().zip(&self.packets.able).enumerate() {
            let found = if_able(packet, able);
            let geom_id = self.geometries.find_eight(found.prim_id, &mut run);
            write_rows(&found, geom_id, hits, k * LANES);
        }
    }

    /// The closest hits of all rays, in `hits`; those of lanes that are not able mean nothing.
    /// Packets have their limits where they are asked for, or needed.
    fn find_closest(&mut self, rays: &RayColumns, with_limits: bool) {
        let endless = rays.common_tmax() == Some(f32::INFINITY);
        let any_able = self.packets.fill(rays, !endless || with_limits);
        let count = packets_for(rays.len());
        self.hits.resize(count, HitPacket::miss());
        let queue = self.packets.queue.queue();
        if any_able && endless {
            self.traversal.closest(&queue, 0..count, &mut self.hits);
        } else if any_able {
            let tmax = &self.packets.tmax;
            self.traversal
                .packets()
                .closest_below(&queue, tmax, &mut self.hits);
        }
    }

    /// The hits of each ray, by (t, prim_id): the closest one, the next one after it, and so on.
    pub(super) fn all_hits(&mut self, rays: &RayColumns) -> Vec<Vec<FoundHit>> {
        self.find_closest(rays, true);
        let mut lists = vec![Vec::new(); rays.len()];
        let queue = self.packets.queue.queue();
        let packets = self.hits.iter().zip(&self.packets.able);
        for (k, ((closest, &able), lists)) in packets.zip(lists.chunks_mut(LANES)).enumerate() {
            let (mut packet, _) = queue.packet::<F32x8>(k, f32::INFINITY);
            packet.tmax = F32x8::new(self.packets.tmax[k]);
            let mut found = if_able(closest, able);
            loop {
                let live = !found.prim_id.eq(U32x8::splat(NO_PRIM));
                if !live.any() {
                    break;
                }
                for lane in (0..lists.len()).filter(|lane| live.bits() >> lane & 1 == 1) {
                    lists[lane].push(FoundHit::of(&found, lane));
                }
                found = self.traversal.next(&packet, live, &found);
            }
        }
        lists
    }

    pub(super) fn occluded(&mut self, rays: &RayColumns, blocked: &mut [bool]) {
        let common = rays.common_tmax();
        let any_able = self.packets.fill(rays, common.is_none());
        let count = packets_for(rays.len());
        self.blocked.resize(count, 0);
        let queue = self.packets.queue.queue();
        match common {
            _ if !any_able => {}
            Some(tmax) => {
                let blocked = &mut self.blocked;
                self.traversal.occluded(&queue, 0..count, tmax, blocked);
            }
            None => {
                let tmax = &self.packets.tmax;
                let blocked = &mut self.blocked;
                self.traversal
                    .packets()
                    .occluded_below(&queue, tmax, blocked);
            }
        }
        let lanes = self.blocked.iter().zip(&self.packets.able);
        for (flags, (bits, able)) in blocked.chunks_mut(LANES).zip(lanes) {
            for (lane, flag) in flags.iter_mut().enumerate() {
                *flag = (bits & able) >> lane & 1 == 1;
            }
        }
    }
}

/// Eight answers as they are given out: lanes that are not in `able` miss, and all misses are
/// alike.
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

/// Writes eight answers into the rows from `from` on, or as many as there are rows.
#[inline(always)]
fn write_rows(found: &HitPacket, geom_id: U32x8, rows: &mut HitColumns, from: usize) {
    put(rows.t, from, found.t.to_array());
    put(rows.u, from, found.u.to_array());
    put(rows.v, from, found.v.to_array());
    put(rows.prim_id, from, found.prim_id.to_array());
    put(rows.geom_id, from, geom_id.to_array());
}

#[inline(always)]
fn put<T: Copy>(column: &mut [T], from: usize, eight: [T; LANES]) {
    let rows = &mut column[from..];
    match rows.first_chunk_mut() {
        Some(rows) => *rows = eight,
        None => rows.copy_from_slice(&eight[..rows.len()]),
    }
}

impl PacketStorage {
    /// Copies rays into packets, and their limits if they are needed; returns true if any of the
    /// rays can hit anything.
    fn fill(&mut self, rays: &RayColumns, with_limits: bool) -> bool {
        let (count, whole) = (packets_for(rays.len()), rays.len() / LANES);
        self.able.resize(count, 0);
        self.tmax
            .resize(if with_limits { count } else { 0 }, [0.0; LANES]);
        let (able, limits) = (&mut self.able[..], &mut self.tmax[..]);
        let mut neighbour = STAND_IN;
        self.queue.fill(count, QueueColumns::default(), |queue| {
            // Whole packets go from the columns to the queue as they are. Arrays that may also be
            // put together number by number would be copied so, too.
            let [ox, oy, oz] = rays.origin.map(|column| &column.as_chunks().0[..whole]);
            let [dx, dy, dz] = rays.direction.map(|column| &column.as_chunks().0[..whole]);
            for (k, able) in able[..whole].iter_mut().enumerate() {
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
            if whole < count {
                let tail = |column: &[f32]| repeat_last(&column[whole * LANES..]);
                let (org, dir) = (rays.origin.map(tail), rays.direction.map(tail));
                let (org, dir) = (org.each_ref(), dir.each_ref());
                let tmax = match rays.tmax {
                    TMax::All(tmax) => [tmax; LANES],
                    TMax::Each(each) => tail(each),
                };
                let rest = rays.len() % LANES;
                able[whole] = able_lanes(org, dir, &tmax);
                push_able(queue, (org, dir), able[whole], rest, &mut neighbour);
                if let Some(limits) = limits.get_mut(whole) {
                    *limits = tmax;
                }
            }
        });
        able.iter().any(|&lanes| lanes != 0)
    }
}

/// Appends a packet with a ray that can hit something in place of each that cannot.
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

/// Fewer than eight numbers, the last one again and again.
fn repeat_last(numbers: &[f32]) -> [f32; LANES] {
    std::array::from_fn(|lane| numbers[lane.min(numbers.len() - 1)])
}

/// Lanes (as bits) of rays that can hit something: see [`RayColumns`].
#[inline(always)]
fn able_lanes(org: Octets, dir: Octets, tmax: &[f32; LANES]) -> u8 {
    // 0 for a finite number, else NaN.
    let residue = |x: &[f32; LANES]| F32x8::new(*x) * F32x8::ZERO;
    let sum = |[x, y, z]: Octets| residue(x) + residue(y) + residue(z);
    let residue = sum(org) + sum(dir);
    let [x, y, z] = dir;
    let length = Vec3x8::new(F32x8::new(*x), F32x8::new(*y), F32x8::new(*z)).max_abs();
    let able = residue.eq(F32x8::ZERO) & length.gt(F32x8::ZERO) & F32x8::new(*tmax).gt(F32x8::ZERO);
    able.bits() as u8
}

/// Puts a ray that can hit something in place of each that cannot: numbers that are none would
/// spread over the whole beam, and its neighbour is the ray that costs least. `before` is a ray of
/// an earlier packet; returns one for later ones.
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
