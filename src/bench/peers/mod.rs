//! Other tracers on our rays, for benchmarks only: the interface that they must implement to be
//! measured, and the peers themselves.
//!
//! A [`BenchEngine`] is one way to trace one set of rays: a tree, a kernel or mode, and the rays
//! laid out as it wants them, all prepared before the clock starts. Our own kernels and the oracle
//! are engines, too (`bench`).

pub mod embree;
pub mod obvhs;

use phalanx_scene::Scene;
use phalanx_trace::packet::{HitPacket, RayQueue};
use std::ops::Range;

/// The reason why a peer does not trace a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{peer} does not trace this scene: {reason}")]
pub struct Unsupported {
    /// The peer's name, for people.
    pub peer: &'static str,
    /// The obstacle.
    pub reason: String,
}

/// A set of rays for one query.
#[derive(Clone, Copy)]
pub struct RaySetRef<'a> {
    /// The rays; every packet but the last is full.
    pub queue: &'a RayQueue<'a>,
    /// Hits count only below this distance.
    pub tmax: f32,
}

/// One way to trace one set of rays. It is shared by the threads that do so.
pub trait BenchEngine: Sync {
    /// The state that one thread needs.
    fn thread(&self) -> Box<dyn BenchEngineThread + '_>;
}

/// One thread's share of an engine. Packets are the set's, eight rays each; a range starts at an
/// even packet.
pub trait BenchEngineThread {
    /// The closest hits of some packets, one [`HitPacket`] each: `t` (at or above the limit:
    /// nothing was hit) and `prim_id` as in the scene; `u` and `v` only where they cost nothing.
    /// Lanes beyond the last ray may hold anything.
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]);
    /// Occluded lanes (as bits) of each of some packets. Lanes beyond the last ray may hold
    /// anything.
    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]);
}

/// Another tracer.
pub enum Peer {
    /// Embree, from its library.
    Embree(embree::EmbreeLibrary),
    /// The traversals of obvhs.
    Obvhs,
}

impl Peer {
    /// Name of the peer in records.
    pub fn name(&self) -> &'static str {
        match self {
            Peer::Embree(_) => "embree",
            Peer::Obvhs => "obvhs",
        }
    }

    /// Name of the peer with its version, where it has one.
    pub fn describe(&self) -> String {
        match self {
            Peer::Embree(library) => format!("embree {}", library.version()),
            Peer::Obvhs => "obvhs".to_owned(),
        }
    }

    /// Builds the peer's own trees over a scene, on the given number of threads where it can.
    ///
    /// # Errors
    /// [`Unsupported`] where the scene holds primitives that the peer cannot trace.
    pub fn build(&self, scene: &Scene, threads: usize) -> Result<PeerScene, Unsupported> {
        match self {
            Peer::Embree(library) => {
                embree::EmbreeScene::build(library, scene, threads).map(PeerScene::Embree)
            }
            Peer::Obvhs => obvhs::ObvhsScene::build(scene).map(PeerScene::Obvhs),
        }
    }
}

/// A scene in another tracer's own form.
pub enum PeerScene {
    /// A scene in Embree's form.
    Embree(embree::EmbreeScene),
    /// A scene in obvhs's form.
    Obvhs(obvhs::ObvhsScene),
}

impl PeerScene {
    /// The peer's modes by name, each with the rays laid out as it wants them.
    pub fn engines(&self, rays: RaySetRef) -> Vec<(String, Box<dyn BenchEngine>)> {
        match self {
            PeerScene::Embree(scene) => scene.engines(rays),
            PeerScene::Obvhs(scene) => scene.engines(rays),
        }
    }
}
