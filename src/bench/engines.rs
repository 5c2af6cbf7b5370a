//! Our own kernels and the oracle as benchmark engines.

use crate::peers::{BenchEngine, BenchEngineThread, RaySetRef};
use phalanx_oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx_scene::Scene;
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::LaneMask;
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
    /// The tree.
    pub bvh: &'a Bvh,
    /// The rays.
    pub rays: RaySetRef<'a>,
}

impl BenchEngine for OneRayEngine<'_> {
    fn thread(&self) -> Box<dyn BenchEngineThread + '_> {
        Box::new(OneRayEngine { ..*self })
    }
}

impl BenchEngineThread for OneRayEngine<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        closest_each(self.rays, packets, hits, |[origin, direction]| {
            let hit = self.bvh.intersect(&Ray::new(origin, direction))?;
            Some(([hit.t, hit.u, hit.v], hit.prim_id))
        });
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let tmax = self.rays.tmax;
        occluded_each(self.rays, packets, blocked, |[origin, direction]| {
            let ray = Ray {
                tmax,
                ..Ray::new(origin, direction)
            };
            self.bvh.occluded(&ray)
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
            oracle: Oracle::new(self.scene, OracleSearch::Tree(self.bvh), 0),
            rays: self.rays,
        })
    }
}

struct OracleEngineThread<'a> {
    oracle: Oracle<'a>,
    rays: RaySetRef<'a>,
}

impl BenchEngineThread for OracleEngineThread<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        closest_each(self.rays, packets, hits, |[org, dir]| {
            let hit = self
                .oracle
                .closest(&OracleRay::new(org.into(), dir.into()))?;
            Some(([hit.t, hit.u, hit.v], hit.prim_id))
        });
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let tmax = self.rays.tmax;
        occluded_each(self.rays, packets, blocked, |[org, dir]| {
            let ray = OracleRay::new(org.into(), dir.into());
            self.oracle.occluded(&ray, tmax)
        });
    }
}

/// Origin and direction of a ray.
type OrgDir = [[f32; 3]; 2];

/// Closest hits of some packets, ray by ray: t, u and v, and the number of the primitive.
#[inline(always)]
fn closest_each(
    rays: RaySetRef,
    packets: Range<usize>,
    hits: &mut [HitPacket],
    mut closest: impl FnMut(OrgDir) -> Option<([f32; 3], u32)>,
) {
    for (packet, out) in packets.zip(hits) {
        *out = HitPacket::miss();
        for lane in rays.queue.active(packet).lanes() {
            if let Some((weights, prim_id)) = closest(rays.queue.ray(packet, lane).into()) {
                out.set(lane, weights, prim_id);
            }
        }
    }
}

/// Occluded rays of some packets, ray by ray.
#[inline(always)]
fn occluded_each(
    rays: RaySetRef,
    packets: Range<usize>,
    blocked: &mut [u8],
    mut occluded: impl FnMut(OrgDir) -> bool,
) {
    for (packet, out) in packets.zip(blocked) {
        *out = 0;
        for lane in rays.queue.active(packet).lanes() {
            *out |= u8::from(occluded(rays.queue.ray(packet, lane).into())) << lane;
        }
    }
}
