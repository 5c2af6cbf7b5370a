//! The ways to ask Embree: one ray a call, eight or sixteen, told that they go the same way or not.

use super::Inner;
use super::api::{Caller, Front, INVALID, RayHit, Valid};
use super::mxcsr::Restore;
use super::scene::Numbers;
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
}

impl Contender for Mode<1> {
    fn runner(&self) -> Box<dyn Runner + '_> {
        Box::new(Singles {
            numbers: &self.scene.numbers,
            laid: &self.laid,
            caller: self.scene.built.caller(self.coherent),
            ray: RayHit::new(),
        })
    }
}

impl Contender for Mode<8> {
    fn runner(&self) -> Box<dyn Runner + '_> {
        Box::new(Packets::new(self))
    }
}

impl Contender for Mode<16> {
    fn runner(&self) -> Box<dyn Runner + '_> {
        Box::new(Packets::new(self))
    }
}

impl<const N: usize> RayHit<N> {
    /// Takes rays, as if nobody had asked about them yet.
    #[inline(always)]
    fn load(&mut self, front: &Front<N>, tmax: f32) {
        self.front = *front;
        self.tfar = [tmax; N];
        self.prim = [INVALID; N];
        self.geometry = [INVALID; N];
    }
}

/// Single rays, eight calls for each of our packets.
struct Singles<'a> {
    numbers: &'a Numbers,
    laid: &'a Laid<1>,
    caller: Caller<'a, 1>,
    ray: RayHit<1>,
}

const SINGLE: Valid<1> = Valid([-1]);

impl<'a> Singles<'a> {
    /// The rays of one of our packets; the last may have fewer.
    fn fronts(&self, packet: usize) -> &'a [Front<1>] {
        let fronts = &self.laid.fronts[packet * LANES..];
        &fronts[..fronts.len().min(LANES)]
    }
}

impl Runner for Singles<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        let _restore = Restore::flushing();
        let (tmax, mut prim_id) = (self.laid.tmax, [INVALID; LANES]);
        let (mut t, mut u, mut v) = ([tmax; LANES], [0.0; LANES], [0.0; LANES]);
        for (packet, hit) in packets.zip(hits) {
            for (lane, front) in self.fronts(packet).iter().enumerate() {
                let ray = &mut self.ray;
                ray.load(front, tmax);
                self.caller.intersect(&SINGLE, ray);
                (t[lane], u[lane], v[lane]) = (ray.tfar[0], ray.u[0], ray.v[0]);
                prim_id[lane] = ray.prim_id(self.numbers, 0);
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
        let tmax = self.laid.tmax;
        for (packet, blocked) in packets.zip(blocked) {
            *blocked = 0;
            for (lane, front) in self.fronts(packet).iter().enumerate() {
                self.ray.load(front, tmax);
                self.caller.occluded(&SINGLE, &mut self.ray);
                *blocked |= u8::from(self.ray.tfar[0] < 0.0) << lane;
            }
        }
    }
}

/// Packets of eight, or of two eights.
struct Packets<'a, const N: usize> {
    numbers: &'a Numbers,
    laid: &'a Laid<N>,
    caller: Caller<'a, N>,
    rays: RayHit<N>,
    valid: Valid<N>,
    /// Rays that `valid` lets through.
    active: usize,
}

impl<'a, const N: usize> Packets<'a, N> {
    const EIGHTS: usize = N / LANES;

    fn new(mode: &'a Mode<N>) -> Packets<'a, N> {
        Packets {
            numbers: &mode.scene.numbers,
            laid: &mode.laid,
            caller: mode.scene.built.caller(mode.coherent),
            rays: RayHit::new(),
            valid: Valid([-1; N]),
            active: N,
        }
    }

    /// Takes a packet, of no more than `most` rays.
    #[inline(always)]
    fn load(&mut self, packet: usize, most: usize) {
        self.rays.load(&self.laid.fronts[packet], self.laid.tmax);
        let active = (self.laid.rays - packet * N).min(most).min(N);
        if active != self.active {
            self.valid = Valid(std::array::from_fn(|lane| -i32::from(lane < active)));
            self.active = active;
        }
    }

    /// The answer to the k-th eight.
    #[inline(always)]
    fn hits(&self, k: usize) -> HitPacket {
        let rays = &self.rays;
        let prim_id = if self.numbers.same {
            // Embree leaves INVALID where nothing is hit, which is our NO_PRIM.
            rays.prim.as_chunks().0[k]
        } else {
            std::array::from_fn(|lane| rays.prim_id(self.numbers, k * LANES + lane))
        };
        HitPacket {
            t: F32x8::new(rays.tfar.as_chunks().0[k]),
            u: F32x8::new(rays.u.as_chunks().0[k]),
            v: F32x8::new(rays.v.as_chunks().0[k]),
            prim_id: U32x8::new(prim_id),
        }
    }
}

impl<const N: usize> RayHit<N> {
    /// The `prim_id` of one lane's hit.
    #[inline(always)]
    fn prim_id(&self, numbers: &Numbers, lane: usize) -> u32 {
        if numbers.same {
            return self.prim[lane];
        }
        numbers.of(self.prim[lane], self.geometry[lane], self.instance[lane])
    }
}

impl<const N: usize> Runner for Packets<'_, N> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        let _restore = Restore::flushing();
        let first = packets.start / Self::EIGHTS;
        for (k, hits) in hits[..packets.len()].chunks_mut(Self::EIGHTS).enumerate() {
            self.load(first + k, hits.len() * LANES);
            self.caller.intersect(&self.valid, &mut self.rays);
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
            self.load(first + k, blocked.len() * LANES);
            self.caller.occluded(&self.valid, &mut self.rays);
            for (k, blocked) in blocked.iter_mut().enumerate() {
                let tfar = F32x8::new(self.rays.tfar.as_chunks().0[k]);
                *blocked = tfar.lt(F32x8::ZERO).bits() as u8;
            }
        }
    }
}
