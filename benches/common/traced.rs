//! Scenes with both trees, sets of rays, and the engines that trace them.

use super::standard_scene;
use bumpalo::Bump;
use phalanx::bench::{Answer, KernelEngine, OracleEngine, RayKind, RaySet};
use phalanx::bench::{primary, secondary};
use phalanx::bvh::{BuildSettings, Bvh};
use phalanx::oracle::TwoLevelBvh;
use phalanx::peers::{BenchEngine, BenchEngineThread, RaySetRef};
use phalanx::scene::Scene;
use phalanx::trace::Kernel;

/// A standard scene and both trees.
pub struct TracedScene {
    pub scene: Scene,
    pub bvh: Bvh,
    pub oracle_bvh: TwoLevelBvh,
}

impl TracedScene {
    /// Builds both trees of the standard scene with this full name.
    pub fn new(name: &str) -> TracedScene {
        let scene = standard_scene(name);
        let settings = BuildSettings {
            threads: 1,
            ..BuildSettings::default()
        };
        let bvh = Bvh::build_with(&scene, &settings);
        TracedScene::with_bvh(scene, bvh)
    }

    /// Builds the oracle's tree of a scene that has the packets' tree.
    pub fn with_bvh(scene: Scene, bvh: Bvh) -> TracedScene {
        TracedScene {
            oracle_bvh: TwoLevelBvh::build(&scene),
            scene,
            bvh,
        }
    }

    /// The rays of a kind for a picture of some size.
    pub fn rays<'a>(&self, arena: &'a Bump, kind: RayKind, size: [u32; 2]) -> RaySet<'a> {
        let first = primary(arena, &self.scene, size).expect("a valid scene");
        if kind == RayKind::Primary {
            return first;
        }
        let seen = answer(&self.oracle(first.rays()), &first);
        secondary(arena, &self.scene, kind, &first, &seen)
    }

    /// The packet engine with one kernel, on a set of rays.
    pub fn packets<'a>(&'a self, kernel: Kernel, rays: RaySetRef<'a>) -> KernelEngine<'a> {
        KernelEngine {
            bvh: &self.bvh,
            kernel,
            rays,
        }
    }

    /// The oracle on a set of rays.
    pub fn oracle<'a>(&'a self, rays: RaySetRef<'a>) -> OracleEngine<'a> {
        OracleEngine {
            scene: &self.scene,
            bvh: &self.oracle_bvh,
            rays,
        }
    }
}

/// Storage for the results of a set of rays.
pub fn room(set: &RaySet) -> Answer {
    Answer::with_capacity(set.kind.query(), set.queue.packets())
}

/// The results of an engine for a set of rays.
pub fn answer(engine: &dyn BenchEngine, set: &RaySet) -> Answer {
    let mut answer = room(set);
    trace(&mut *engine.thread(), &mut answer);
    answer
}

/// Traces all packets for which `answer` has storage.
pub fn trace(engine_thread: &mut dyn BenchEngineThread, answer: &mut Answer) {
    match answer {
        Answer::Closest(hits) => engine_thread.closest(0..hits.len(), hits),
        Answer::Occluded(blocked) => engine_thread.occluded(0..blocked.len(), blocked),
    }
}

/// Returns true if two results of a set of rays have the same bits.
pub fn same(a: &Answer, b: &Answer, set: &RaySet) -> bool {
    a.first_difference(b, 0..set.queue.len()).is_none()
}
