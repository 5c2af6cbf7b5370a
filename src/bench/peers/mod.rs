//! Other tracers on our rays, for benchmarks only: the interface that they implement to be
//! measured, and the peers themselves.

pub mod embree;
mod engine;
pub mod obvhs;

pub use engine::{BenchEngine, BenchEngineThread, NamedEngines, RaySetRef, Unsupported};

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
    pub fn engines(&self, rays: RaySetRef) -> NamedEngines {
        match self {
            PeerScene::Embree(scene) => scene.engines(rays),
            PeerScene::Obvhs(scene) => scene.engines(rays),
        }
    }
}
