//! Embree's modes: one, eight or sixteen rays per call, flagged as coherent or not.

use super::api::QueryCaller;
use super::layout::{INVALID, RayHeader, RayHit, Valid};
use super::mxcsr::RestoreMxcsr;
use super::scene::{EmbreeSceneData, PrimIdMap};
use crate::peers::engine::{
    BenchEngine, BenchEngineThread, RaySetRef, closest_each, occluded_each,
};
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, U32x8};
use std::ops::Range;
use std::sync::Arc;

/// A set of rays in packets of N. It holds the first half of each packet in Embree's layout. The
/// other half is the same for all packets, so each thread has it once and copies the first half
/// before every call. Tracing the rays in place would require restoring the values overwritten by
/// the previous call, and would move more than twice the memory.
pub(super) struct RayLayout<const N: usize> {
    headers: Vec<RayHeader<N>>,
    rays: usize,
    tmax: f32,
}

impl<const N: usize> RayLayout<N> {
    pub(super) fn new(rays: RaySetRef) -> RayLayout<N> {
        let count = rays.queue.len();
        let empty = RayHeader([[0.0; N]; 8]);
        let mut headers = vec![empty; count.div_ceil(N)];
        for ray in 0..count {
            let (org, dir) = rays.queue.ray(ray / LANES, ray % LANES);
            let rows = &mut headers[ray / N].0;
            for axis in 0..3 {
                rows[axis][ray % N] = org[axis];
                rows[4 + axis][ray % N] = dir[axis];
            }
        }
        RayLayout {
            headers,
            rays: count,
            tmax: rays.tmax,
        }
    }
}

/// One mode: packet width and coherence flag.
pub(super) struct EmbreeEngine<const N: usize> {
    scene: Arc<EmbreeSceneData>,
    layout: Arc<RayLayout<N>>,
    coherent: bool,
}

impl<const N: usize> EmbreeEngine<N> {
    pub(super) fn new(
        scene: &Arc<EmbreeSceneData>,
        layout: &Arc<RayLayout<N>>,
        coherent: bool,
    ) -> EmbreeEngine<N> {
        EmbreeEngine {
            scene: Arc::clone(scene),
            layout: Arc::clone(layout),
            coherent,
        }
    }
}

impl BenchEngine for EmbreeEngine<1> {
    fn thread(&self) -> Box<dyn BenchEngineThread + '_> {
        Box::new(EmbreeSingleThread {
            prim_ids: &self.scene.prim_ids,
            layout: &self.layout,
            caller: self.scene.built.caller(self.coherent),
            ray: RayHit::new(),
        })
    }
}

impl BenchEngine for EmbreeEngine<8> {
    fn thread(&self) -> Box<dyn BenchEngineThread + '_> {
        Box::new(EmbreePacketThread::new(self))
    }
}

impl BenchEngine for EmbreeEngine<16> {
    fn thread(&self) -> Box<dyn BenchEngineThread + '_> {
        Box::new(EmbreePacketThread::new(self))
    }
}

impl<const N: usize> RayHit<N> {
    /// Loads rays and resets the results, as for a first query.
    #[inline(always)]
    fn load(&mut self, header: &RayHeader<N>, tmax: f32) {
        self.header = *header;
        self.tfar = [tmax; N];
        self.prim = [INVALID; N];
        self.geometry = [INVALID; N];
    }
}

/// Single rays, eight calls for each of our packets.
struct EmbreeSingleThread<'a> {
    prim_ids: &'a PrimIdMap,
    layout: &'a RayLayout<1>,
    caller: QueryCaller<'a, 1>,
    ray: RayHit<1>,
}

const SINGLE: Valid<1> = Valid([-1]);

impl BenchEngineThread for EmbreeSingleThread<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        let _restore = RestoreMxcsr::flushing();
        let layout = self.layout;
        closest_each(packets, layout.rays, hits, |k| {
            let ray = &mut self.ray;
            ray.load(&layout.headers[k], layout.tmax);
            self.caller.intersect(&SINGLE, ray);
            let prim_id = ray.prim_id(self.prim_ids, 0);
            Some(([ray.tfar[0], ray.u[0], ray.v[0]], prim_id))
        });
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let _restore = RestoreMxcsr::flushing();
        let layout = self.layout;
        occluded_each(packets, layout.rays, blocked, |k| {
            self.ray.load(&layout.headers[k], layout.tmax);
            self.caller.occluded(&SINGLE, &mut self.ray);
            self.ray.tfar[0] < 0.0
        });
    }
}

/// Packets of eight, or of two eights.
struct EmbreePacketThread<'a, const N: usize> {
    prim_ids: &'a PrimIdMap,
    layout: &'a RayLayout<N>,
    caller: QueryCaller<'a, N>,
    /// The packet that is queried, and the next.
    rays: [RayHit<N>; 2],
    valid: Valid<N>,
    /// Number of rays that `valid` admits.
    active: usize,
}

impl<'a, const N: usize> EmbreePacketThread<'a, N> {
    const EIGHTS: usize = N / LANES;

    fn new(mode: &'a EmbreeEngine<N>) -> EmbreePacketThread<'a, N> {
        EmbreePacketThread {
            prim_ids: &mode.scene.prim_ids,
            layout: &mode.layout,
            caller: mode.scene.built.caller(mode.coherent),
            rays: [RayHit::new(), RayHit::new()],
            valid: Valid([-1; N]),
            active: N,
        }
    }

    /// Queries some of our packets. `answer` receives the index of each call and Embree's results
    /// for its N rays.
    ///
    /// Each packet is copied while the packet before it waits for its query. Embree reads as a
    /// whole a row that was copied in halves, which takes the row through memory. Immediately after
    /// the copy, and after the results before it, that was 6 % of the time of incoherent packets of
    /// sixteen.
    #[inline(always)]
    fn query(
        &mut self,
        packets: Range<usize>,
        call_embree: impl Fn(&mut QueryCaller<'a, N>, &Valid<N>, &mut RayHit<N>),
        mut answer: impl FnMut(usize, &mut RayHit<N>),
    ) {
        let first = packets.start / Self::EIGHTS;
        self.load(first, 0);
        for call in 0..packets.len().div_ceil(Self::EIGHTS) {
            self.load(first + call + 1, (call + 1) % 2);
            let left = (packets.len() - call * Self::EIGHTS) * LANES;
            self.admit(left.min(self.layout.rays - (first + call) * N));
            let rays = &mut self.rays[call % 2];
            call_embree(&mut self.caller, &self.valid, rays);
            answer(call, rays);
        }
    }

    /// Loads a packet, if it exists.
    #[inline(always)]
    fn load(&mut self, packet: usize, slot: usize) {
        if let Some(header) = self.layout.headers.get(packet) {
            self.rays[slot].load(header, self.layout.tmax);
        }
    }

    /// Admits the given number of rays of the packet.
    #[inline(always)]
    fn admit(&mut self, most: usize) {
        let active = most.min(N);
        if active != self.active {
            self.valid = Valid(std::array::from_fn(|lane| -i32::from(lane < active)));
            self.active = active;
        }
    }
}

impl<const N: usize> RayHit<N> {
    /// The `prim_id` of one lane's hit.
    #[inline(always)]
    fn prim_id(&self, prim_ids: &PrimIdMap, lane: usize) -> u32 {
        if prim_ids.same {
            // Embree leaves INVALID where nothing is hit, which is our NO_PRIM.
            return self.prim[lane];
        }
        prim_ids.prim_id(self.prim[lane], self.geometry[lane], self.instance[lane])
    }

    /// The results of the k-th eight.
    #[inline(always)]
    fn hits(&self, k: usize) -> HitPacket {
        HitPacket {
            t: F32x8::new(self.tfar.as_chunks().0[k]),
            u: F32x8::new(self.u.as_chunks().0[k]),
            v: F32x8::new(self.v.as_chunks().0[k]),
            prim_id: U32x8::new(self.prim.as_chunks().0[k]),
        }
    }
}

impl<const N: usize> BenchEngineThread for EmbreePacketThread<'_, N> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        let _restore = RestoreMxcsr::flushing();
        let prim_ids = self.prim_ids;
        self.query(packets, QueryCaller::intersect, |call, rays| {
            if !prim_ids.same {
                rays.prim = std::array::from_fn(|lane| rays.prim_id(prim_ids, lane));
            }
            let hits = hits.iter_mut().skip(call * Self::EIGHTS);
            for (k, hit) in hits.take(Self::EIGHTS).enumerate() {
                *hit = rays.hits(k);
            }
        });
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let _restore = RestoreMxcsr::flushing();
        self.query(packets, QueryCaller::occluded, |call, rays| {
            let blocked = blocked.iter_mut().skip(call * Self::EIGHTS);
            for (k, blocked) in blocked.take(Self::EIGHTS).enumerate() {
                let tfar = F32x8::new(rays.tfar.as_chunks().0[k]);
                *blocked = tfar.lt(F32x8::ZERO).bits() as u8;
            }
        });
    }
}
