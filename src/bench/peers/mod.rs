//! Other tracers on our rays, for benchmarks only: the interface that they implement to be
//! measured, and the peers themselves.

pub mod embree;
mod engine;
pub mod obvhs;

pub use engine::{BenchEngine, BenchEngineThread, NamedEngines, PeerScene, RaySetRef, Unsupported};

use phalanx_scene::Scene;

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

    /// Name of the peer with its version, if it has one.
    pub fn describe(&self) -> String {
        match self {
            Peer::Embree(library) => format!("embree {}", library.version()),
            Peer::Obvhs => "obvhs".to_owned(),
        }
    }

    /// Builds the peer's own trees over a scene, on the given number of threads if it can.
    ///
    /// # Errors
    /// [`Unsupported`] where the scene holds primitives that the peer cannot trace.
    pub fn build(&self, scene: &Scene, threads: usize) -> Result<PeerScene, Unsupported> {
        match self {
            Peer::Embree(library) => library.build(scene, threads),
            Peer::Obvhs => obvhs::build(scene),
        }
    }
}
