//! Our own kernels and the oracle as benchmark engines.

use crate::peers::{BenchEngine, BenchEngineThread, RaySetRef};
use phalanx_oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx_scene::Scene;
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::{HitPacket, NO_PRIM};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, U32x8};
use phalanx_trace::{Kernel, Traversal};
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

impl OracleEngineThread<'_> {
    fn ray(&self, packet: usize, lane: usize) -> OracleRay {
        let (org, dir) = self.rays.queue.ray(packet, lane);
        OracleRay::new(org.into(), dir.into())
    }
}

impl BenchEngineThread for OracleEngineThread<'_> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        for (packet, out) in packets.zip(hits) {
            let (mut t, mut u, mut v) = ([f32::INFINITY; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            let mut prim_id = [NO_PRIM; LANES];
            for lane in self.rays.queue.active(packet).lanes() {
                if let Some(hit) = self.oracle.closest(&self.ray(packet, lane)) {
                    (t[lane], u[lane], v[lane]) = (hit.t, hit.u, hit.v);
                    prim_id[lane] = hit.prim_id;
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

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        for (packet, out) in packets.zip(blocked) {
            let stopped = |lane: &usize| {
                let ray = self.ray(packet, *lane);
                self.oracle.occluded(&ray, self.rays.tmax)
            };
            let lanes = self.rays.queue.active(packet).lanes().filter(stopped);
            *out = lanes.fold(0, |bits, lane| bits | 1 << lane);
        }
    }
}
