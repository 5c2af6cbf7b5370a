//! Other tracers on our rays, for benchmarks only: the interface that they implement to be
//! measured, and the peers themselves.

pub mod embree;
mod engine;
pub mod obvhs;

pub use engine::{
    BenchEngine, BenchEngineThread, NamedEngines, ONE, PeerScene, RaySetRef, Unsupported,
};

use phalanx_scene::Scene;
use phalanx_trace::bvh::BuildSettings;
use std::sync::Arc;

/// Another tracer.
pub enum Peer {
    /// Embree at its fastest, from its library.
    Embree(Arc<embree::EmbreeLibrary>),
    /// The same, in scenes whose queries lose no ray at an edge.
    EmbreeRobust(Arc<embree::EmbreeLibrary>),
    /// The traversals of obvhs.
    Obvhs,
}

impl Peer {
    /// Name of the peer in records.
    pub fn name(&self) -> &'static str {
        match self {
            Peer::Embree(_) => "embree",
            Peer::EmbreeRobust(_) => "embree robust",
            Peer::Obvhs => "obvhs",
        }
    }

    /// Name of the peer with its version, if it has one.
    pub fn describe(&self) -> String {
        match self {
            Peer::Embree(library) | Peer::EmbreeRobust(library) => {
                format!("{} {}", self.name(), library.version())
            }
            Peer::Obvhs => self.name().to_owned(),
        }
    }

    /// Builds the peer's own trees over a scene, by the nearest settings that it has.
    ///
    /// # Errors
    /// [`Unsupported`] where the scene holds primitives that the peer cannot trace.
    pub fn build(&self, scene: &Scene, settings: &BuildSettings) -> Result<PeerScene, Unsupported> {
        match self {
            Peer::Embree(library) => library.build(scene, settings, false),
            Peer::EmbreeRobust(library) => library.build(scene, settings, true),
            Peer::Obvhs => obvhs::build(scene, settings.quality),
        }
    }
}
