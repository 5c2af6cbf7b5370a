//! The ways to ask Embree: one ray a call, eight or sixteen, told that they go the same way or not.

use super::Inner;
use super::api::{Front, INVALID, Query, RayHit, Valid};
use super::mxcsr::Restore;
use crate::lanes::{F32x8, LANES, LaneMask, Lanes, U32x8};
use crate::packet::HitPacket;
use crate::peers::{Contender, Rays, Runner};
use std::ops::Range;
use std::sync::Arc;

/// A set of rays in packets of N, the first half of each packet as Embree wants it. The other half is the same for all,
/// so that a runner has it once, and copies what differs before every call: to trace where the rays lie would have to
/// put back what the call before has written there, and moves more than twice the memory.
pub(super) struct Laid<const N: usize> {
    fronts: Vec<Front<N>>,
    rays: usize,
    tmax: f32,
}

impl<const N: usize> Laid<N> {
    pub(super) fn new(rays: Rays) -> Laid<N> {
        let count = rays.queue.len();
        let empty = Front([[0.0; N]; 8]);
        let mut fronts = vec![empty; count.div_ceil(N)];
        for ray in 0..count {
            let (org, dir) = rays.queue.ray(ray / LANES, ray % LANES);
            let rows = &mut fronts[ray / N].0;
            for axis in 0..3 {
                rows[axis][ray % N] = org[axis];
                rows[4 + axis][ray % N] = dir[axis];
            }
        }
        Laid {
            fronts,
            rays: count,
            tmax: rays.tmax,
        }
    }
}

/// One way to ask.
pub(super) struct Mode<const N: usize> {
    scene: Arc<Inner>,
    laid: Arc<Laid<N>>,
    coherent: bool,
}

impl<const N: usize> Mode<N> {
    pub(super) fn new(scene: &Arc<Inner>, laid: &Arc<Laid<N>>, coherent: bool) -> Mode<N> {
        Mode {
            scene: Arc::clone(scene),
            laid: Arc::clone(laid),
            coherent,
        }
    }

    fn asker(&self) -> Asker<'_, N> {
        Asker {
            scene: &self.scene,
            laid: &self.laid,
            query: Query::new(self.coherent),
            valid: Valid([-1; N]),
            active: N,
            rays: RayHit::new(),
        }
    }
}

impl Contender for Mode<1> {
    fn runner(&self) -> Box<dyn Runner + '_> {
        Box::new(self.asker())
    }
}

impl Contender for Mode<8> {
    fn runner(&self) -> Box<dyn Runner + '_> {
        Box::new(Packets(self.asker()))
    }
}

impl Contender for Mode<16> {
    fn runner(&self) -> Box<dyn Runner + '_> {
        Box::new(Packets(self.asker()))
    }
}

/// What one thread needs to ask: a packet of N, used again and again.
struct Asker<'a, const N: usize> {
    scene: &'a Inner,
    laid: &'a Laid<N>,
    query: Query,
    valid: Valid<N>,
    /// Rays that `valid` lets through.
    active: usize,
    rays: RayHit<N>,
}

impl<const N: usize> Asker<'_, N> {
    /// Takes a packet, as if nobody had asked yet; of no more than `most` rays.
    #[inline(always)]
    fn load(&mut self, packet: usize, most: usize) {
        self.rays.front = self.laid.fronts[packet];
        self.rays.tfar = [self.laid.tmax; N];
        self.rays.prim = [INVALID; N];
        self.rays.geometry = [INVALID; N];
        let active = (self.laid.rays - packet * N).min(most).min(N);
        if active != self.active {
            self.valid = Valid(std::array::from_fn(|lane| -i32::from(lane < active)));
            self.active = active;
        }
    }

    #[inline(always)]
    fn intersect(&mut self) {
        let scene = &self.scene.built;
        scene.intersect(&mut self.query, &self.valid, &mut self.rays);
    }

    #[inline(always)]
    fn occluded(&mut self) {
        let scene = &self.scene.built;
        scene.occluded(&mut self.query, &self.valid, &mut self.rays);
    }

    /// The `prim_id` of one lane's hit.
    #[inline(always)]
    fn prim_id(&self, lane: usize) -> u32 {
        let rays = &self.rays;
        if self.scene.numbers.same {
            // Embree leaves INVALID where nothing is hit, which is our NO_PRIM.
            return rays.prim[lane];
        }
        let numbers = &self.scene.numbers;
        numbers.of(rays.prim[lane], rays.geometry[lane], rays.instance[lane])
    }
}

/// Single rays, eight calls for each of our packets.
impl Runner for Asker<'_, 1> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        let _restore = Restore::flushing();
        for (packet, hit) in packets.zip(hits) {
            let (mut t, mut u, mut v) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            let mut prim_id = [INVALID; LANES];
            let first = packet * LANES;
            for lane in 0..LANES.min(self.laid.rays - first) {
                self.load(first + lane, 1);
                self.intersect();
                (t[lane], u[lane], v[lane]) = (self.rays.tfar[0], self.rays.u[0], self.rays.v[0]);
                prim_id[lane] = self.prim_id(0);
            }
            *hit = HitPacket {
                t: F32x8::new(t),
                u: F32x8::new(u),
                v: F32x8::new(v),
                prim_id: U32x8::new(prim_id),
            };
        }
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let _restore = Restore::flushing();
        for (packet, blocked) in packets.zip(blocked) {
            let first = packet * LANES;
            *blocked = 0;
            for lane in 0..LANES.min(self.laid.rays - first) {
                self.load(first + lane, 1);
                Asker::occluded(self);
                *blocked |= u8::from(self.rays.tfar[0] < 0.0) << lane;
            }
        }
    }
}

/// Packets of eight, or of two eights.
struct Packets<'a, const N: usize>(Asker<'a, N>);

impl<const N: usize> Packets<'_, N> {
    const EIGHTS: usize = N / LANES;

    /// The answer to the k-th eight.
    #[inline(always)]
    fn hits(&self, k: usize) -> HitPacket {
        let rays = &self.0.rays;
        let prim_id = if self.0.scene.numbers.same {
            rays.prim.as_chunks().0[k]
        } else {
            std::array::from_fn(|lane| self.0.prim_id(k * LANES + lane))
        };
        HitPacket {
            t: F32x8::new(rays.tfar.as_chunks().0[k]),
            u: F32x8::new(rays.u.as_chunks().0[k]),
            v: F32x8::new(rays.v.as_chunks().0[k]),
            prim_id: U32x8::new(prim_id),
        }
    }
}

impl<const N: usize> Runner for Packets<'_, N> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        let _restore = Restore::flushing();
        let first = packets.start / Self::EIGHTS;
        for (k, hits) in hits[..packets.len()].chunks_mut(Self::EIGHTS).enumerate() {
            self.0.load(first + k, hits.len() * LANES);
            self.0.intersect();
            for (k, hit) in hits.iter_mut().enumerate() {
                *hit = self.hits(k);
            }
        }
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let _restore = Restore::flushing();
        let first = packets.start / Self::EIGHTS;
        for (k, blocked) in blocked[..packets.len()]
            .chunks_mut(Self::EIGHTS)
            .enumerate()
        {
            self.0.load(first + k, blocked.len() * LANES);
            self.0.occluded();
            for (k, blocked) in blocked.iter_mut().enumerate() {
                let tfar = F32x8::new(self.0.rays.tfar.as_chunks().0[k]);
                *blocked = tfar.lt(F32x8::ZERO).bits() as u8;
            }
        }
    }
}
