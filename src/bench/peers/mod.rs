//! Other tracers on our rays, for benchmarks only: the interface that they implement to be
//! measured, and the peers themselves.

pub mod embree;
mod engine;
pub mod obvhs;

pub use engine::{
    BenchEngine, BenchEngineThread, NamedEngines, ONE, PeerScene, RaySetRef, Unsupported,
};
pub(crate) use engine::{closest_each, occluded_each};

use phalanx_scene::Scene;
use phalanx_trace::bvh::BuildSettings;
use std::sync::Arc;

/// Another tracer.
pub enum Peer {
    /// Embree, from its library: at its fastest, or in scenes whose queries lose no ray at an edge.
    Embree {
        /// The library.
        library: Arc<embree::EmbreeLibrary>,
        /// True if no ray may be lost.
        robust: bool,
    },
    /// The traversals of obvhs.
    Obvhs,
}

impl Peer {
    /// Name of the peer in records.
    pub fn name(&self) -> &'static str {
        match self {
            Peer::Embree { robust: false, .. } => "embree",
            Peer::Embree { robust: true, .. } => "embree robust",
            Peer::Obvhs => "obvhs",
        }
    }

    /// Name of the peer with its version, if it has one.
    pub fn describe(&self) -> String {
        match self {
            Peer::Embree { library, .. } => format!("{} {}", self.name(), library.version()),
            Peer::Obvhs => self.name().to_owned(),
        }
    }

    /// Builds the peer's own trees over a scene, by the nearest settings that it has.
    ///
    /// # Errors
    /// [`Unsupported`] where the scene holds primitives that the peer cannot trace.
    pub fn build(&self, scene: &Scene, settings: &BuildSettings) -> Result<PeerScene, Unsupported> {
        match self {
            Peer::Embree { library, robust } => library.build(scene, settings, *robust),
            Peer::Obvhs => obvhs::build(scene, settings.quality),
        }
    }
}
