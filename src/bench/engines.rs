//! Our own kernels and the oracle as benchmark engines.

use crate::peers::{BenchEngine, BenchEngineThread, RaySetRef};
use phalanx_oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx_scene::Scene;
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::{HitPacket, NO_PRIM};
use phalanx_trace::simd::{F32x8, LANES, U32x8};
use phalanx_trace::{Kernel, Ray, Traversal};
use std::ops::Range;

/// A kernel of the packet engine on a set of rays.
pub struct KernelEngine<'a> {
    /// The tree.
    pub bvh: &'a Bvh,
    /// The kernel.
    pub kernel: Kernel,
    /// The rays.
    pub rays: RaySetRef<'a>,
}

impl BenchEngine for KernelEngine<'_> {
    fn thread(&self) -> Box<dyn BenchEngineThread + '_> {
        Box::new(KernelEngineThread {
            traversal: Traversal::new(self.bvh, self.kernel),
            rays: self.rays,
        })
    }
}

struct KernelEngineThread<'a> {
    traversal: Traversal<'a>,
    rays: RaySetRef<'a>,
}

impl BenchEngineThread for KernelEngineThread<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        self.traversal.closest(self.rays.queue, packets, hits);
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let RaySetRef { queue, tmax } = self.rays;
        self.traversal.occluded(queue, packets, tmax, blocked);
    }
}

/// [`Bvh::intersect`] and [`Bvh::occluded`], one ray a call.
pub struct OneRayEngine<'a> {
    bvh: &'a Bvh,
    rays: Vec<Ray>,
}

impl<'a> OneRayEngine<'a> {
    /// Lays the rays out as users have them.
    pub fn new(bvh: &'a Bvh, RaySetRef { queue, tmax }: RaySetRef) -> OneRayEngine<'a> {
        let ray = |k: usize| {
            let (origin, direction) = queue.ray(k / LANES, k % LANES);
            Ray {
                origin,
                direction,
                tmax,
            }
        };
        let rays = (0..queue.len()).map(ray).collect();
        OneRayEngine { bvh, rays }
    }
}

impl BenchEngine for OneRayEngine<'_> {
    fn thread(&self) -> Box<dyn BenchEngineThread + '_> {
        Box::new(OneRayEngineThread(self))
    }
}

struct OneRayEngineThread<'a>(&'a OneRayEngine<'a>);

impl BenchEngineThread for OneRayEngineThread<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        let OneRayEngine { bvh, rays } = self.0;
        closest_each(packets, rays.len(), hits, |ray| {
            let hit = bvh.intersect(&rays[ray])?;
            Some(([hit.t, hit.u, hit.v], hit.prim_id))
        });
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let OneRayEngine { bvh, rays } = self.0;
        occluded_each(packets, rays.len(), blocked, |ray| bvh.occluded(&rays[ray]));
    }
}

/// The oracle on a set of rays.
pub struct OracleEngine<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The oracle's trees.
    pub bvh: &'a TwoLevelBvh,
    /// The rays.
    pub rays: RaySetRef<'a>,
}

impl BenchEngine for OracleEngine<'_> {
    fn thread(&self) -> Box<dyn BenchEngineThread + '_> {
        Box::new(OracleEngineThread {
            oracle: Oracle::new(self.scene, OracleSearch::Tree(self.bvh)),
            rays: self.rays,
        })
    }
}

struct OracleEngineThread<'a> {
    oracle: Oracle<'a>,
    rays: RaySetRef<'a>,
}

impl OracleEngineThread<'_> {
    fn ray(&self, ray: usize) -> OracleRay {
        let (org, dir) = self.rays.queue.ray(ray / LANES, ray % LANES);
        OracleRay::new(org.into(), dir.into())
    }
}

impl BenchEngineThread for OracleEngineThread<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        closest_each(packets, self.rays.queue.len(), hits, |ray| {
            let hit = self.oracle.closest(&self.ray(ray))?;
            Some(([hit.t, hit.u, hit.v], hit.prim_id))
        });
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        occluded_each(packets, self.rays.queue.len(), blocked, |ray| {
            self.oracle.occluded(&self.ray(ray), self.rays.tmax)
        });
    }
}

/// Closest hits of some packets of `rays` rays, ray by ray: t, u and v, and the number of the
/// primitive.
#[inline(always)]
fn closest_each(
    packets: Range<usize>,
    rays: usize,
    hits: &mut [HitPacket],
    mut closest: impl FnMut(usize) -> Option<([f32; 3], u32)>,
) {
    for (packet, out) in packets.zip(hits) {
        let (mut t, mut u, mut v) = ([f32::INFINITY; LANES], [0.0; LANES], [0.0; LANES]);
        let mut prim_id = [NO_PRIM; LANES];
        let first = packet * LANES;
        for lane in 0..LANES.min(rays - first) {
            if let Some((hit, id)) = closest(first + lane) {
                ([t[lane], u[lane], v[lane]], prim_id[lane]) = (hit, id);
            }
        }
        *out = HitPacket {
            t: F32x8::new(t),
            u: F32x8::new(u),
            v: F32x8::new(v),
            prim_id: U32x8::new(prim_id),
        };
    }
}

/// Occluded rays of some packets of `rays` rays, ray by ray.
#[inline(always)]
fn occluded_each(
    packets: Range<usize>,
    rays: usize,
    blocked: &mut [u8],
    mut occluded: impl FnMut(usize) -> bool,
) {
    for (packet, out) in packets.zip(blocked) {
        let first = packet * LANES;
        let lanes = 0..LANES.min(rays - first);
        *out = lanes.fold(0, |bits, lane| {
            bits | u8::from(occluded(first + lane)) << lane
        });
    }
}
