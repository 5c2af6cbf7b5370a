//! Our own kernels and the oracle as benchmark engines.

use crate::peers::{BenchEngine, BenchEngineThread, RaySetRef, closest_each, occluded_each};
use phalanx_oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx_scene::Scene;
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::LANES;
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
        Box::new(self)
    }
}

impl BenchEngineThread for &OneRayEngine<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        closest_each(packets, self.rays.len(), hits, |ray| {
            let hit = self.bvh.intersect(&self.rays[ray])?;
            Some(([hit.t, hit.u, hit.v], hit.prim_id))
        });
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        occluded_each(packets, self.rays.len(), blocked, |ray| {
            self.bvh.occluded(&self.rays[ray])
        });
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
