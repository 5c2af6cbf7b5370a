//! Small batches: single rays, from and to the caller's memory, without a queue between them.

use super::worker::{able_lanes, repeat_last};
use super::{Hit, RayBatch, TMax};
use crate::bvh::Bvh;
use crate::packet::{RayPacket, packets_for};
use crate::prefetch;
use crate::simd::{F32x8, LANES, LaneMask, Mask8, Vec3x8};
use crate::traverse::single_ray::{OneHit, OneRay, RayOctets, SingleRays};
use std::cell::Cell;

/// Maximum number of rays that are traced one after another: with more, many in flight are faster
/// (`perf/notes/calls.md`).
pub(super) const FEW: usize = 16;

/// Passes on each ray's number and its closest hit.
pub(super) fn closest(bvh: &Bvh, rays: &RayBatch, mut put: impl FnMut(usize, Option<Hit>)) {
    let source = BatchSource::new(rays);
    if rays.len() == 1 {
        return put(0, bvh.intersect(&rays.ray(0)));
    }
    let hit_of = |(weights, prim_id)| bvh.hit_of(weights, prim_id);
    let done = &mut |k: usize, hit: OneHit| put(k, hit.found().map(hit_of));
    if rays.len() <= FEW {
        let mut kernel = OneRay::new(bvh);
        for packet in 0..packets_for(rays.len()) {
            kernel.packet_closest((&source, packet), done);
        }
    } else {
        SingleRays::new(bvh).closest_of((&source, rays.len()), done);
    }
    source.each_unable(|k| put(k, None));
}

/// Sets the flags of rays that hit anything.
pub(super) fn occluded(bvh: &Bvh, rays: &RayBatch, blocked: &mut [bool]) {
    if let [blocked] = blocked {
        *blocked = bvh.occluded(&rays.ray(0));
        return;
    }
    let source = BatchSource::new(rays);
    if rays.len() > FEW {
        return SingleRays::new(bvh).occluded_of(&source, blocked);
    }
    blocked.fill(false);
    let mut kernel = OneRay::new(bvh);
    for packet in 0..packets_for(rays.len()) {
        kernel.packet_occluded((&source, packet), blocked);
    }
}

/// Packets of a batch, read from the caller's memory as they are needed.
struct BatchSource<'r> {
    rays: &'r RayBatch<'r>,
    /// True if a ray was read that cannot hit anything.
    has_unable: Cell<bool>,
}

impl<'r> BatchSource<'r> {
    fn new(rays: &'r RayBatch<'r>) -> BatchSource<'r> {
        BatchSource {
            rays,
            has_unable: Cell::new(false),
        }
    }

    /// Passes on the numbers of rays that were not traced, because they cannot hit anything.
    fn each_unable(&self, mut miss: impl FnMut(usize)) {
        if self.has_unable.get() {
            let unable = (0..self.rays.len()).filter(|&k| !self.rays.ray(k).can_hit());
            unable.for_each(&mut miss);
        }
    }
}

impl RayOctets for BatchSource<'_> {
    #[inline(always)]
    fn packet(&self, packet: usize) -> (RayPacket<F32x8>, Mask8) {
        let first = packet * LANES;
        let [org, dir] = self.rays.octets(first);
        let tmax = match self.rays.tmax() {
            TMax::All(tmax) => [tmax; LANES],
            TMax::Each(each) => octet(each, first),
        };
        let able = able_lanes(org.each_ref(), dir.each_ref(), &tmax);
        let present = Mask8::first((self.rays.len() - first).min(LANES));
        let active = Mask8::from_bits(u32::from(able)) & present;
        if active.bits() != present.bits() {
            self.has_unable.set(true);
        }
        let vec =
            |[x, y, z]: [[f32; LANES]; 3]| Vec3x8::new(F32x8::new(x), F32x8::new(y), F32x8::new(z));
        let rays = RayPacket {
            org: vec(org),
            dir: vec(dir),
            tmax: F32x8::new(tmax),
        };
        (rays, active)
    }

    #[inline(always)]
    fn limit(&self, ray: usize) -> f32 {
        self.rays.tmax().get(ray)
    }
}

/// Eight numbers of a column, the last one repeated.
#[inline(always)]
fn octet(column: &[f32], first: usize) -> [f32; LANES] {
    let rest = &column[first..];
    // Six columns are more than the processor follows by itself between the rows of a tree.
    prefetch::line_at(rest.as_ptr().wrapping_add(2 * LANES).addr());
    match rest.first_chunk() {
        Some(eight) => *eight,
        None => repeat_last(rest),
    }
}

impl RayBatch<'_> {
    /// Origins and directions of eight rays, the last one repeated, by their components. Written
    /// in loops, because a map of arrays is not always inlined.
    #[inline(always)]
    fn octets(&self, first: usize) -> [[[f32; LANES]; 3]; 2] {
        let mut octets = [[[0.0; LANES]; 3]; 2];
        match self {
            RayBatch::InColumns(columns) => {
                for (octets, columns) in octets.iter_mut().zip([columns.origin, columns.direction])
                {
                    for (octets, column) in octets.iter_mut().zip(columns) {
                        *octets = octet(column, first);
                    }
                }
            }
            RayBatch::InRows(rows) => {
                let last = rows.len() - 1;
                for (octets, numbers) in octets.iter_mut().zip([rows.origin, rows.direction]) {
                    for lane in 0..LANES {
                        let row = &numbers[(first + lane).min(last) * rows.stride..][..3];
                        for (octet, &number) in octets.iter_mut().zip(row) {
                            octet[lane] = number;
                        }
                    }
                }
            }
        }
        octets
    }
}
