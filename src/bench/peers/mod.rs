//! Other tracers on our rays, for benchmarks only: what they must do to be measured, and who they
//! are.
//!
//! A [`BenchEngine`] is one way to trace one set of rays: a tree, a kernel or mode, and the rays
//! laid out as it wants them, all prepared before the clock starts. Our own kernels and the oracle
//! are contenders, too (`bench`).

pub mod embree;
pub mod obvhs;

use phalanx_scene::Scene;
use phalanx_trace::packet::{HitPacket, RayQueue};
use std::ops::Range;

/// Why a peer does not trace a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{peer} does not trace this scene: {reason}")]
pub struct Unsupported {
    /// The peer's name, for people.
    pub peer: &'static str,
    /// What is in its way.
    pub reason: String,
}

/// A set of rays with one question for all of them.
#[derive(Clone, Copy)]
pub struct RaySetRef<'a> {
    /// The rays; every packet but the last is full.
    pub queue: &'a RayQueue<'a>,
    /// Hits count only below this distance.
    pub tmax: f32,
}

/// One way to trace one set of rays. Shared by the threads that do so.
pub trait BenchEngine: Sync {
    /// What one thread needs.
    fn thread(&self) -> Box<dyn BenchEngineThread + '_>;
}

/// One thread's share of a contender. Packets are the set's, eight rays each; a range starts at an
/// even packet.
pub trait BenchEngineThread {
    /// The closest hits of some packets, one [`HitPacket`] each: `t` (at or above the limit:
    /// nothing was hit) and `prim_id` as in the scene; `u` and `v` only where they come for
    /// nothing. Lanes beyond the last ray may hold anything.
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]);
    /// For each of some packets, the lanes (as bits) whose ray meets anything. Lanes beyond the
    /// last ray may hold anything.
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
    /// As in records.
    pub fn name(&self) -> &'static str {
        match self {
            Peer::Embree(_) => "embree",
            Peer::Obvhs => "obvhs",
        }
    }

    /// With its version, where it says one.
    pub fn describe(&self) -> String {
        match self {
            Peer::Embree(library) => format!("embree {}", library.version()),
            Peer::Obvhs => "obvhs".to_owned(),
        }
    }

    /// Builds its own trees over a scene, on so many threads where it can.
    ///
    /// # Errors
    /// [`Unsupported`] where the scene holds what the peer cannot trace.
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
    /// In Embree's.
    Embree(embree::EmbreeScene),
    /// In obvhs's.
    Obvhs(obvhs::ObvhsScene),
}

impl PeerScene {
    /// Its modes by name, each with the rays laid out as it wants them.
    pub fn engines(&self, rays: RaySetRef) -> Vec<(String, Box<dyn BenchEngine>)> {
        match self {
            PeerScene::Embree(scene) => scene.engines(rays),
            PeerScene::Obvhs(scene) => scene.engines(rays),
        }
    }
}
